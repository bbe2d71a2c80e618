//! Where the mission stands, as hopper-sim tells everyone.

use serde::{Deserialize, Serialize};

use crate::{
    Cell, Collected, Decision, Digest, Leader, MonotonicNs, Origin, Outcome, RobotId, RunId, Status, Timing,
    Vetoed,
};

/// Where a robot is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Its cell; outside the grid once it has left the map.
    pub cell: Cell,
    /// Height of the ground under it above the datum, metres.
    pub height_m: f64,
}

/// The state at one decision: what the last one led to. In a mission of several robots robot, leader, pose and outcome are
/// those of the robot that took it, and [`crate::Team`] tells whose turn it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// The robot that took the last decision; robot 0 at decision 0.
    pub robot: RobotId,
    /// The decision that is due; equals the number of commands executed.
    pub decision: Decision,
    /// Steps so far, in the paper's count; of rovers, the actions of the one that acted most.
    pub steps: u64,
    /// Goals visited so far; of rovers, cells covered. Where goals are visited in turn, it says which one is in force
    /// ([`crate::Brief::leg`]).
    pub visits: u64,
    /// How the mission stands.
    pub status: Status,
    /// The planner whose commands are accepted.
    pub leader: Leader,
    /// Where the robot is.
    pub pose: Pose,
    /// Treasures collected so far.
    pub collected: Collected,
    /// What the guard has vetoed at this decision: commanded again, it would be vetoed again.
    pub vetoed: Vetoed,
    /// What became of the last action; `None` at decision 0.
    pub last: Option<Outcome>,
    /// Who chose the last action.
    pub last_origin: Origin,
    /// What the guard vetoed before the last action.
    pub last_vetoed: Vetoed,
    /// Digest of the state before; zero at decision 0.
    pub previous: Digest,
    /// Chained digest of everything executed so far.
    pub digest: Digest,
    /// When the hopper came to rest here.
    pub landed: MonotonicNs,
    /// When this message was published.
    pub published: MonotonicNs,
    /// Timing of the last decision; zero at decision 0.
    pub last_timing: Timing,
}

impl State {
    /// What of it follows from the past that its digest names, and what the guard has vetoed there; all else is blank. A
    /// planner is given no more: a command names its past by the digest alone, so a plan that depended on anything else
    /// could be taken for one of another past with the same digest.
    #[must_use]
    pub fn of_its_past(&self) -> Self {
        let Self {
            run,
            robot,
            decision,
            steps,
            visits,
            status,
            leader: _,
            pose,
            collected,
            vetoed,
            last,
            last_origin: _,
            last_vetoed: _,
            previous,
            digest,
            landed: _,
            published: _,
            last_timing: _,
        } = *self;
        Self {
            run,
            robot,
            decision,
            steps,
            visits,
            status,
            leader: Leader::default(),
            pose,
            collected,
            vetoed,
            last,
            last_origin: Origin::Planner,
            last_vetoed: Vetoed::NONE,
            previous,
            digest,
            landed: MonotonicNs(0),
            published: MonotonicNs(0),
            last_timing: Timing::default(),
        }
    }

    /// Whether a reader that has `known` takes this state: its robot is below `robots`, and `known` has not replaced it.
    #[must_use]
    pub fn is_news(&self, robots: u16, known: Option<&State>) -> bool {
        self.robot.0 < robots && !known.is_some_and(|known| self.is_older_than(known))
    }

    /// Whether `known`, of the same run, has replaced this state: published no earlier, it is of a later decision, or of
    /// the same decision on another timeline. A lower decision published later is that of a journal that has lost its
    /// tail.
    fn is_older_than(&self, known: &State) -> bool {
        let behind = self.decision < known.decision
            || (self.decision == known.decision && self.digest != known.digest);
        self.run == known.run && behind && self.published <= known.published
    }
}
