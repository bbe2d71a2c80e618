//! What became of each of several robots.

use std::fmt;

use contract::{Cell, Member, Name, RobotId, Standing, Status, Vehicle};
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

impl From<Vehicle> for RobotKind {
    fn from(vehicle: Vehicle) -> Self {
        match vehicle {
            Vehicle::Hopper | Vehicle::HopperTo { .. } => RobotKind::Hopper,
            Vehicle::Rover { .. } | Vehicle::Driver { .. } => RobotKind::Rover,
            Vehicle::Helicopter { .. } => RobotKind::Helicopter,
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
    /// Of the robot `member` after so many actions, in a mission that stands at `status`. `planner` commanded it last.
    #[must_use]
    pub(crate) fn of(
        (robot, member): (RobotId, &Member),
        planner: Name,
        actions: u64,
        (status, is_mixed): (Status, bool),
    ) -> Self {
        let vehicle = member.robot.vehicle;
        // Where a hopper or a rover has the only goal, the end of its way is that of the mission.
        let decides = !is_mixed && matches!(vehicle, Vehicle::Hopper | Vehicle::Driver { .. });
        let standing = match (member.standing, status) {
            (Standing::Active, Status::Goal) if decides => Standing::Done,
            (Standing::Active, Status::Lost | Status::LeftMap) if decides => Standing::Stranded,
            (standing, _) => standing,
        };
        Self { robot, kind: vehicle.into(), planner, actions, status: standing, cell: member.at.cell }
    }
}

impl fmt::Display for RobotSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, planner, actions, status, cell, .. } = self;
        let planner = if *planner == Name::NONE { "no planner" } else { planner.as_str() };
        write!(f, "{}, {planner}, {}, {status} at {cell}", kind.as_str(), counted(*actions, "action"))
    }
}
