//! What an executed action leaves behind.

use contract::{Collected, DetailId, Outcome, Pose, Status};

/// Where an executed action left the mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Execution {
    /// What became of the action.
    pub outcome: Outcome,
    /// Pose afterwards; outside the map it keeps the height of the departure.
    pub pose: Pose,
    /// What the motion model tells of it beyond the outcome; see [`RobotTeam::detail`](crate::RobotTeam::detail).
    pub detail: DetailId,
    /// Treasures collected so far, this landing's among them.
    pub collected: Collected,
    /// Steps afterwards, in the paper's count.
    pub steps: u64,
    /// Goals visited so far, this landing's among them.
    pub visits: u64,
    /// Status afterwards.
    pub status: Status,
}
