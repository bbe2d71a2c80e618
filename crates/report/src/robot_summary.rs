//! What became of each of several robots.

use std::fmt;

use contract::{Cell, Member, Name, Robot, RobotId, Standing, Status};
use serde::{Deserialize, Serialize};

use crate::phrases::counted;

/// One of several robots at the end of a mission. Displayed, it is a phrase for a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RobotSummary {
    /// Number of the robot.
    pub robot: RobotId,
    /// What people call its body.
    pub kind: Name,
    /// The planner that commanded it last; [`Name::NONE`] if none did.
    pub planner: Name,
    /// Number of decisions that were its turn, those by which it waited included.
    pub actions: u64,
    /// How its part of the mission stands: active if the mission ended first.
    pub status: Standing,
    /// Its last cell; outside the grid if it has left the map.
    pub cell: Cell,
}

impl RobotSummary {
    /// Of a robot that stands as `member` after so many actions. `planner` commanded it last; `mission` is how the mission stands, if
    /// its goal is that of this robot.
    #[must_use]
    pub(crate) fn of(
        (number, robot): (RobotId, &Robot),
        member: &Member,
        planner: Name,
        actions: u64,
        mission: Option<Status>,
    ) -> Self {
        let status = match (member.standing, mission) {
            (Standing::Active, Some(Status::Goal)) => Standing::Done,
            (Standing::Active, Some(Status::Lost | Status::LeftMap)) => Standing::Stranded,
            (standing, _) => standing,
        };
        let kind = robot.body.word().parse().unwrap_or(Name::NONE);
        Self { robot: number, kind, planner, actions, status, cell: member.at.cell }
    }
}

impl fmt::Display for RobotSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, planner, actions, status, cell, .. } = self;
        let planner = if *planner == Name::NONE { "no planner" } else { planner.as_str() };
        write!(f, "{}, {planner}, {}, {status} at {cell}", kind.as_str(), counted(*actions, "action"))
    }
}
