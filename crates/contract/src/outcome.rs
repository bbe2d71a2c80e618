//! What became of a command.

use serde::{Deserialize, Serialize};

use crate::Cell;

/// Which branch of the motion model came true.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Branch {
    /// Landed where it was meant to.
    Intended,
    /// Did not get away from where it stood.
    Stayed,
    /// Slipped to the left of the hop's direction.
    Left,
    /// Slipped to the right of the hop's direction.
    Right,
    /// The command was to stand still.
    Held,
    /// Failed instead of acting, and will never act again.
    Stranded,
    /// Stopped on the way, since the driving time of the stage was used up.
    Halted,
    /// Came to rest on another cell than any of those.
    Elsewhere,
    /// Did not come to rest: it rolled or bounced on, and is lost.
    RolledAway,
}

impl Branch {
    /// Every branch, in the order of their wire codes.
    pub const ALL: [Branch; 9] = [
        Branch::Intended,
        Branch::Stayed,
        Branch::Left,
        Branch::Right,
        Branch::Held,
        Branch::Stranded,
        Branch::Halted,
        Branch::Elsewhere,
        Branch::RolledAway,
    ];

    /// The code on the wire.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32 + 1
    }

    /// The branch of a wire code, if there is one.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|branch| branch.code() == code)
    }
}

/// The ballistic flight of a hop, from launch to the planned landing. All zero where a hopper did not fly. Of a rover's
/// action it has the way (`range_m`, `rise_m`) and the time that it takes, as one flight without a launch.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Flight {
    /// Speed at launch, m/s.
    pub launch_speed_mps: f64,
    /// Angle at launch above the horizontal, radians.
    pub launch_angle_rad: f64,
    /// Horizontal distance of one flight, metres.
    pub range_m: f64,
    /// Height of the landing above the launch, metres.
    pub rise_m: f64,
    /// Highest point above the launch, metres.
    pub apex_height_m: f64,
    /// Time of one flight, seconds.
    pub flight_time_s: f64,
    /// Flights flown one after the other: 0 (held), 1, or 2 half hops on sand.
    pub flights: u32,
}

/// Outcome of one command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Branch of the motion model.
    pub branch: Branch,
    /// Where the robot stood when it acted.
    pub from: Cell,
    /// Cell of landing; outside the grid when the hopper left the map.
    pub to: Cell,
    /// Range, rise and duration.
    pub flight: Flight,
}

/// How the mission stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Not over.
    Underway,
    /// The goal is reached within the step limit.
    Goal,
    /// The step limit is reached elsewhere.
    Deadlock,
    /// The hopper left the map.
    LeftMap,
    /// The hopper landed on impassable ground.
    Lost,
}

impl Status {
    /// Every status, in the order of their wire codes.
    pub const ALL: [Status; 5] =
        [Status::Underway, Status::Goal, Status::Deadlock, Status::LeftMap, Status::Lost];

    /// Whether nothing more will happen.
    #[must_use]
    pub fn is_over(self) -> bool {
        self != Status::Underway
    }

    /// The name in JSON and tables.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Status::Underway => "underway",
            Status::Goal => "goal",
            Status::Deadlock => "deadlock",
            Status::LeftMap => "left_map",
            Status::Lost => "lost",
        }
    }

    /// The code on the wire.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32 + 1
    }

    /// The status of a wire code, if there is one.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|status| status.code() == code)
    }
}

impl std::fmt::Display for Status {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.as_str())
    }
}
