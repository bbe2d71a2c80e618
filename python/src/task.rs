//! What a mission is about, as planners written in Python are told.

use contract::{Account, Body, Brief, Goal, Robot};

/// What a mission is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// A hopper goes from a start to a goal.
    Reach,
    /// A hopper visits goals in turn.
    Patrol,
    /// A hopper goes from a start to a goal, and helicopters look ahead for it.
    Accompany,
    /// Rovers cover ground.
    Cover,
    /// A rover drives to a goal over uncertain ground, and helicopters look ahead for it.
    Scout,
    /// Robots have tasks of their own.
    Mixed,
}

impl Task {
    /// The task of a mission.
    pub fn of(brief: &Brief) -> Self {
        let covers = |robot: &Robot| matches!((robot.body, robot.goal), (Body::Rover(_), Goal::Cover(_)));
        match brief.account {
            Account::Hopper if brief.has_team() => Task::Accompany,
            Account::Hopper if brief.visits().is_some() => Task::Patrol,
            Account::Hopper => Task::Reach,
            Account::Actions => Task::Scout,
            Account::ActionsWithoutWaits if brief.robots.iter().all(covers) => Task::Cover,
            Account::ActionsWithoutWaits => Task::Mixed,
        }
    }

    /// Its name.
    pub fn as_str(self) -> &'static str {
        match self {
            Task::Reach => "reach",
            Task::Patrol => "patrol",
            Task::Accompany => "accompany",
            Task::Cover => "cover",
            Task::Scout => "scout",
            Task::Mixed => "mixed",
        }
    }
}
