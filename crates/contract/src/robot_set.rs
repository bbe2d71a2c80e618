//! Some of the robots of a mission.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::RobotId;

/// Some of the robots of a mission, one bit each: bit 0 for robot 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RobotSet(pub u16);

impl RobotSet {
    /// Every robot that a mission may have.
    pub const ALL: RobotSet = RobotSet(u16::MAX);

    /// No robot.
    pub const NONE: RobotSet = RobotSet(0);

    /// The robots 0 to `count` − 1.
    #[must_use]
    pub fn first(count: u16) -> Self {
        (0..count).map(RobotId).fold(Self(0), Self::with)
    }

    /// The robots of this set that a mission of `count` robots has.
    #[must_use]
    pub fn of(self, count: u16) -> Self {
        Self(self.0 & Self::first(count).0)
    }

    /// Whether `robot` is among them.
    #[must_use]
    pub fn has(self, robot: RobotId) -> bool {
        self.0.checked_shr(robot.0.into()).unwrap_or(0) & 1 == 1
    }

    /// These and `robot`, if a mission may have it.
    #[must_use]
    pub fn with(self, robot: RobotId) -> Self {
        Self(self.0 | 1_u16.checked_shl(robot.0.into()).unwrap_or(0))
    }

    /// These and `others`.
    #[must_use]
    pub fn union(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// The robots that are in this set and in `others`.
    #[must_use]
    pub fn intersection(self, others: Self) -> Self {
        Self(self.0 & others.0)
    }

    /// These, but for `others`.
    #[must_use]
    pub fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// In the order of their numbers.
    pub fn iter(self) -> impl Iterator<Item = RobotId> {
        let rest = |set: &u16| Some(set & (set - 1)).filter(|rest| *rest != 0);
        let first = Some(self.0).filter(|set| *set != 0);
        std::iter::successors(first, rest).map(|set| RobotId(set.trailing_zeros() as u16))
    }
}

impl Default for RobotSet {
    /// Robot 0 alone: that of a hopper mission.
    fn default() -> Self {
        Self(1)
    }
}

impl fmt::Display for RobotSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers: Vec<String> = self.iter().map(|robot| robot.to_string()).collect();
        f.pad(&numbers.join(","))
    }
}
