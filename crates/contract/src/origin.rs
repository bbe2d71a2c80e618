//! Who chose an action: the planner in command, or hopper-sim's fallback at the deadline.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::Action;

/// Where an executed action came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// A planner commanded it.
    #[default]
    Planner,
    /// The deadline passed: the last policy of the algorithm in command says so, or the route that the robot announced.
    Policy,
    /// The deadline passed: the hop the guard allows that comes nearest to the goal.
    Greedy,
    /// The deadline passed, and there is no hop that the guard allows.
    Hold,
}

impl Origin {
    /// Every origin, in the order of their wire codes.
    pub const ALL: [Origin; 4] = [Origin::Planner, Origin::Policy, Origin::Greedy, Origin::Hold];

    /// Whether the guard acted because no planner did.
    #[must_use]
    pub fn is_fallback(self) -> bool {
        self != Origin::Planner
    }

    /// The name in JSON and tables.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Origin::Planner => "planner",
            Origin::Policy => "policy",
            Origin::Greedy => "greedy",
            Origin::Hold => "hold",
        }
    }

    /// The code on the wire.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32 + 1
    }

    /// The origin of a wire code, if there is one.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|origin| origin.code() == code)
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

/// A set of vetoed actions, one bit each: bit [`Action::code`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Vetoed(pub u32);

impl Vetoed {
    /// No action.
    pub const NONE: Vetoed = Vetoed(0);

    /// Whether `action` is among them.
    #[must_use]
    pub fn has(self, action: Action) -> bool {
        self.0 >> action.code() & 1 == 1
    }

    /// These and `action`.
    #[must_use]
    pub fn with(self, action: Action) -> Self {
        Self(self.0 | 1 << action.code())
    }

    /// Actions that are vetoed in `self`, in `other`, or in both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Number of actions vetoed.
    #[must_use]
    pub fn count(self) -> u64 {
        u64::from(self.0.count_ones())
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_origin_survives_its_code() {
        for origin in Origin::ALL {
            assert_eq!(Origin::from_code(origin.code()), Some(origin));
        }
        assert_eq!(Origin::from_code(0), None);
        assert!(Origin::ALL.into_iter().filter(|origin| origin.is_fallback()).count() == 3);
    }

    #[test]
    fn a_vetoed_action_counts_once() {
        let set = Action::ALL[1..3].iter().fold(Vetoed::NONE, |set, &action| set.with(action).with(action));
        assert_eq!((set.count(), set.is_empty(), Vetoed::NONE.is_empty()), (2, false, true));
        assert_eq!(Action::ALL.map(|action| set.has(action))[..5], [false, true, true, false, false]);
        assert_eq!(set.union(Vetoed::NONE.with(Action::Hold)).count(), 3);
    }
}
