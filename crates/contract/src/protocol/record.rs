//! One executed decision, as the journal keeps it and the past serves it.

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::{
    Action, Collected, Decision, DetailId, Digest, Leader, MonotonicNs, Origin, Outcome, Pose, RobotId,
    RouteId, RunId, State, Status, Timing, Vetoed,
};

/// A decision that was executed, as the journal keeps it and `hop/past` serves it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Robot 0, the only one of a mission.
    pub robot: RobotId,
    /// The decision, counted from 0.
    pub decision: Decision,
    /// Who commanded, under which term.
    pub leader: Leader,
    /// Action executed, whoever chose it.
    pub action: Action,
    /// Who chose the action: a planner or the fallback, which does not change who commands.
    pub origin: Origin,
    /// What the guard vetoed at this decision before the action.
    pub vetoed: Vetoed,
    /// Fingerprint of the map it was decided on; 0 for a fallback, which knows none.
    pub observation: u64,
    /// Work the planner did.
    pub work: u64,
    /// Whether a budget cut that work short.
    pub cut: bool,
    /// What became of it.
    pub outcome: Outcome,
    /// Pose afterwards.
    pub pose: Pose,
    /// What the motion model tells beyond the outcome. Journals hold the detail itself, behind the record.
    #[serde(skip)]
    pub detail: DetailId,
    /// Treasures collected so far, this landing's among them.
    pub collected: Collected,
    /// Goals visited so far, this landing's among them.
    pub visits: u64,
    /// Steps afterwards, in the paper's count.
    pub steps: u64,
    /// Status afterwards.
    pub status: Status,
    /// Timing of this decision, `committed` as it stood when the record was written.
    pub timing: Timing,
    /// Digest before this decision.
    pub previous: Digest,
    /// Digest after it: [`Digest::chain`].
    pub digest: Digest,
}

impl Record {
    /// The route that this decision announced, with the decision and the robot.
    #[must_use]
    pub fn announced(&self) -> Option<((Decision, RobotId), RouteId)> {
        match self.action {
            Action::Announce(id) => Some(((self.decision, self.robot), id)),
            _ => None,
        }
    }

    /// The state this record leads to.
    #[must_use]
    pub fn state_after(&self, run: RunId, landed: MonotonicNs, published: MonotonicNs) -> State {
        State {
            run,
            robot: self.robot,
            decision: self.decision.next(),
            steps: self.steps,
            visits: self.visits,
            status: self.status,
            leader: self.leader,
            pose: self.pose,
            collected: self.collected,
            vetoed: Vetoed::NONE,
            last: Some(self.outcome),
            last_origin: self.origin,
            last_vetoed: self.vetoed,
            previous: self.previous,
            digest: self.digest,
            landed,
            published,
            last_timing: self.timing,
        }
    }
}

impl State {
    /// Whether the digest chain names `detail` as that of the last action, which was not the announcement of a route. A state does
    /// not have the action, so every action is tried; it does have all else that the chain covers.
    #[must_use]
    pub fn names_detail(&self, detail: DetailId) -> bool {
        let (Some(outcome), Some(decision)) = (self.last, self.decision.0.checked_sub(1)) else {
            return detail.is_none();
        };
        let mut record = Record {
            robot: self.robot,
            decision: Decision(decision),
            leader: self.leader,
            action: Action::Hold,
            origin: self.last_origin,
            vetoed: self.last_vetoed,
            observation: 0,
            work: 0,
            cut: false,
            outcome,
            pose: self.pose,
            detail,
            collected: self.collected,
            visits: self.visits,
            steps: self.steps,
            status: self.status,
            timing: self.last_timing,
            previous: self.previous,
            digest: self.digest,
        };
        Action::ALL.iter().any(|action| {
            record.action = *action;
            self.previous.chain(&record) == self.digest
        })
    }
}

impl Digest {
    /// The next link: hash of the previous digest and of `record`'s decision, action, outcome and
    /// state after. `record.previous` and `record.digest` are not read.
    #[must_use]
    pub fn chain(self, record: &Record) -> Self {
        let mut hasher = Sha256::new();
        hasher.update(self.0);
        hasher.update(record.decision.0.to_le_bytes());
        hasher.update(record.action.code().to_le_bytes());
        let outcome = &record.outcome;
        hasher.update(outcome.branch.code().to_le_bytes());
        for cell in [outcome.from, outcome.to, record.pose.cell] {
            hasher.update(cell.x.to_le_bytes());
            hasher.update(cell.y.to_le_bytes());
        }
        let flight = &outcome.flight;
        for value in [
            flight.launch_speed_mps,
            flight.launch_angle_rad,
            flight.range_m,
            flight.rise_m,
            flight.apex_height_m,
            flight.flight_time_s,
            record.pose.height_m,
        ] {
            hasher.update(value.to_bits().to_le_bytes());
        }
        hasher.update(flight.flights.to_le_bytes());
        hasher.update(record.steps.to_le_bytes());
        hasher.update(record.status.code().to_le_bytes());
        hasher.update(record.collected.0.to_le_bytes());
        if record.action.route() != 0 {
            hasher.update(record.action.route().to_le_bytes());
        }
        if !record.detail.is_none() {
            hasher.update(record.detail.0);
        }
        // A link without a number is one of robot 0: so the links of a single hopper are as ever.
        if record.robot != RobotId(0) {
            hasher.update(record.robot.0.to_le_bytes());
        }
        Self(hasher.finalize().into())
    }
}
