//! Orders that a person may give a running mission, with the pacing that hopper-sim reports.
//!
//! Nothing in here changes an outcome: pace, pause and single step move landings in time, a hand-over asks a
//! planner to claim the next term, which any planner may do.

use serde::{Deserialize, Serialize};

use crate::{Incarnation, Pace, RobotId, RunId};

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Hold the next landing back.
    Pause,
    /// Let landings come again.
    Resume,
    /// While paused: let one landing come.
    Step,
    /// Land at this pace from now on.
    Pace(Pace),
    /// The planner of this life shall claim the next term; all others take no notice.
    HandOver(Incarnation),
}

/// One order for one robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// The run that is meant.
    pub run: RunId,
    /// Robot 0, the only one of a mission.
    pub robot: RobotId,
    /// What is asked for.
    pub order: Order,
}

/// How hopper-sim paces landings at present, on `hop/tempo`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pacing {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// Robot 0, the only one of a mission.
    pub robot: RobotId,
    /// How fast landings follow each other.
    pub pace: Pace,
    /// Whether landings are held back.
    pub paused: bool,
    /// Whether hopper-sim was started with `--control` and obeys orders. In JSON it is `heeds`, as in the wire type.
    #[serde(rename = "heeds")]
    pub obeys: bool,
}
