//! Who speaks, and which decision is meant.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::Name;
use crate::spelling::did_you_mean;

/// A random 128-bit nonce drawn once per run; it stays the same when hopper-sim resumes a journal.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct RunId(pub u128);

impl fmt::Display for RunId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl fmt::Debug for RunId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "RunId({self})")
    }
}

impl Serialize for RunId {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for RunId {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        u128::from_str_radix(&text, 16).map(RunId).map_err(serde::de::Error::custom)
    }
}

macro_rules! counted {
    ($(#[$doc:meta])* $name:ident($inner:ty)) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub $inner);

        impl $name {
            /// The one after.
            #[must_use]
            pub fn next(self) -> Self {
                Self(self.0 + 1)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    };
}

counted! {
    /// Counts hops commanded so far: at decision *n* the hopper has executed *n* commands.
    Decision(u64)
}
counted! {
    /// Fences planners: it only rises, and each rise is a change of who commands.
    Term(u64)
}
counted! {
    /// A robot of the mission; the hopper mission has only number 0.
    RobotId(u16)
}

/// One life of one process: random, never zero for a living process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Incarnation(pub u64);

impl fmt::Display for Incarnation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

/// The part a process plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Executes hops, arbitrates who commands, keeps the journal.
    HopperSim,
    /// Builds the observed map.
    Perception,
    /// Decides the next hop.
    Planner,
    /// Watches.
    Monitor,
}

impl Role {
    /// Every role, in the order of their wire codes.
    pub const ALL: [Role; 4] = [Role::HopperSim, Role::Perception, Role::Planner, Role::Monitor];

    /// The name of the role, which is also the name of its binary.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Role::HopperSim => "hopper-sim",
            Role::Perception => "perception",
            Role::Planner => "planner",
            Role::Monitor => "monitor",
        }
    }

    /// The code on the wire.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32 + 1
    }

    /// The role of a wire code, if there is one.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.code() == code)
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

/// Who commands: set by the first accepted command of a term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Leader {
    /// The term in force; 0 before the first command of the run.
    pub term: Term,
    /// The life of the planner in command; 0 for nobody yet.
    pub incarnation: Incarnation,
    /// Its operating-system process; 0 for nobody yet, or in lockstep.
    pub pid: u32,
    /// The algorithm in command.
    pub planner: Name,
}

/// Parses a role from its name.
impl FromStr for Role {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|role| role.as_str() == text).ok_or_else(|| {
            let meant = did_you_mean(text, Self::ALL.map(Role::as_str));
            format!("a role is one of hopper-sim, perception, planner, monitor; got {text:?}{meant}")
        })
    }
}

/// Fingerprint of a route: XXH3-64 over the bits of its points in order; never 0, which stands for no route.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RouteId(pub u64);

impl fmt::Display for RouteId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}
