//! What a state tells of a mission of several robots.

use serde::{Deserialize, Serialize};

/// Whose pose, steps and visits a state tells, and what the limit of the mission counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Account {
    /// Those of robot 0, a hopper, whoever acted: its planner need not know of the others, which look ahead for it. The limit is
    /// of its steps, in the paper's count.
    #[default]
    Hopper,
    /// The pose of the robot that acted, the actions of the robot with most of them, and the cells that are covered. The limit
    /// is of a robot's actions.
    Actions,
    /// As [`Account::Actions`], where an action by which a robot waits for another one is no step.
    ActionsWithoutWaits,
}

impl Account {
    /// Every account, in the order of their wire codes.
    pub const ALL: [Account; 3] = [Account::Hopper, Account::Actions, Account::ActionsWithoutWaits];

    /// The code on the wire.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32 + 1
    }

    /// The account of a wire code, if there is one.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|account| account.code() == code)
    }
}
