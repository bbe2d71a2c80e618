//! What became of each of several robots.

use std::fmt;

use contract::{Body, Cell, Member, Name, Robot, RobotId, Standing, Status};
use serde::{Deserialize, Serialize};

use crate::phrases::counted;

/// What a robot is, in the words of scenarios.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RobotKind {
    /// Hops from cell to cell.
    Hopper,
    /// Drives, to a goal or to cover ground.
    Rover,
    /// Flies and looks ahead.
    Helicopter,
}

impl RobotKind {
    /// The name in scenarios and summaries.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            RobotKind::Hopper => "hopper",
            RobotKind::Rover => "rover",
            RobotKind::Helicopter => "helicopter",
        }
    }
}

impl From<Body> for RobotKind {
    fn from(body: Body) -> Self {
        match body {
            Body::Hopper(_) => RobotKind::Hopper,
            Body::Rover(_) | Body::Driver(_) => RobotKind::Rover,
            Body::Helicopter(_) => RobotKind::Helicopter,
        }
    }
}

/// One of several robots at the end of a mission. Displayed, it is a phrase for a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RobotSummary {
    /// Number of the robot.
    pub robot: RobotId,
    /// What it is.
    pub kind: RobotKind,
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
        Self { robot: number, kind: robot.body.into(), planner, actions, status, cell: member.at.cell }
    }
}

impl fmt::Display for RobotSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, planner, actions, status, cell, .. } = self;
        let planner = if *planner == Name::NONE { "no planner" } else { planner.as_str() };
        write!(f, "{}, {planner}, {}, {status} at {cell}", kind.as_str(), counted(*actions, "action"))
    }
}
