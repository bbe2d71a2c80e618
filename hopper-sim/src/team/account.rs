//! What a state tells of a mission of several robots.

use contract::Brief;

/// Whose pose, steps and visits a state tells, and what the limit of the mission counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Account {
    /// Those of the hopper, whoever acted: its planner need not know of the others. The limit is of its steps, in the
    /// paper's count.
    Hopper,
    /// The pose of the robot that acted, the actions of the robot with most of them, and the cells that are covered. The limit
    /// is of a robot's actions.
    Actions,
    /// As [`Account::Actions`], where an action by which a robot waits for another one is no step.
    ActionsWithoutWaits,
}

impl Account {
    /// That of a mission.
    #[must_use]
    pub fn of(brief: &Brief) -> Self {
        if brief.is_of_hopper() {
            Account::Hopper
        } else if brief.scout.is_some() && brief.mixed.is_none() {
            Account::Actions
        } else {
            Account::ActionsWithoutWaits
        }
    }
}
