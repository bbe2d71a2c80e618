//! The executed decisions of a mission, a bounded number of them.

use std::collections::{BTreeMap, VecDeque};

use contract::{Branch, Cell, Collected, Decision, MonotonicNs, Name, Origin, RobotId, Status, Term, Vetoed};
use report::Executed;

/// Number of hops that are kept, the last ones.
pub const HOPS_KEPT: usize = 1 << 16;

/// Number of changes of leader that are kept, the last ones.
const LEADER_CHANGES_KEPT: usize = 4096;

/// One executed decision with the fields that are displayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hop {
    /// Robot that took it.
    pub robot: RobotId,
    /// How it ended: as intended, as a slip, or not at all.
    pub branch: Branch,
    /// Cell it began in.
    pub from: Cell,
    /// Cell it landed in.
    pub to: Cell,
    /// Height of the landing above the datum, metres.
    pub height_m: f64,
    /// How long the action lasted, seconds of simulated time; 0 for one that held or waited.
    pub lasts_s: f64,
    /// Term in which it was commanded.
    pub term: Term,
    /// Steps after it, in the papers' count.
    pub steps: u64,
    /// Status after it.
    pub status: Status,
    /// Treasures collected up to and including it.
    pub collected: Collected,
    /// Goals visited up to and including it.
    pub visits: u64,
    /// Who chose the action: a planner or the guard's fallback.
    pub origin: Origin,
    /// Actions that the guard vetoed before it.
    pub vetoed: Vetoed,
    /// When the hopper had landed before it, on CLOCK_MONOTONIC.
    pub landed: MonotonicNs,
    /// Durations of its stages, nanoseconds, in the order of [`contract::Stage::ALL`].
    pub stages_ns: [u64; 7],
}

impl Hop {
    /// Time from landing to commit, nanoseconds.
    #[must_use]
    pub fn total_ns(&self) -> u64 {
        self.stages_ns.iter().sum()
    }
}

/// The planner that took command of a robot at a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeaderChange {
    /// The robot; terms are counted for each.
    pub robot: RobotId,
    /// Whether nobody had commanded the robot before.
    pub is_first: bool,
    /// Term that began.
    pub term: Term,
    /// Name of the algorithm.
    pub planner: Name,
    /// Process id of the planner.
    pub pid: u32,
    /// First decision it commanded.
    pub from: Decision,
}

/// Consecutive hops, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Hops {
    first: u64,
    kept: VecDeque<Hop>,
    leader_changes: VecDeque<LeaderChange>,
    /// Number of changes of leader that are no longer kept.
    leader_changes_dropped: u64,
    /// The term of the last change of each robot.
    terms: BTreeMap<RobotId, Term>,
}

impl Hops {
    /// The decision that is due: the number of decisions added so far.
    #[must_use]
    pub fn due(&self) -> Decision {
        Decision(self.first + self.kept.len() as u64)
    }

    /// First decision that is kept.
    #[must_use]
    pub fn first(&self) -> Decision {
        Decision(self.first)
    }

    /// The hop of a decision; `None` if it is not kept.
    #[must_use]
    pub fn get(&self, decision: Decision) -> Option<&Hop> {
        self.kept.get(decision.0.checked_sub(self.first)? as usize)
    }

    /// The hops from `decision` on, or from the first one kept.
    pub fn from(&self, decision: Decision) -> impl DoubleEndedIterator<Item = &Hop> + ExactSizeIterator {
        let skipped = decision.0.saturating_sub(self.first).min(self.kept.len() as u64) as usize;
        self.kept.range(skipped..)
    }

    /// The changes of leader, in order; the last one of each robot leads it now.
    pub fn leader_changes(&self) -> impl DoubleEndedIterator<Item = &LeaderChange> {
        self.leader_changes.iter()
    }

    /// The changes of leader from number `number` of the mission on.
    pub(super) fn leader_changes_from(&self, number: u64) -> impl Iterator<Item = &LeaderChange> {
        self.leader_changes.iter().skip(number.saturating_sub(self.leader_changes_dropped) as usize)
    }

    /// Number of changes of leader in the mission so far.
    pub(super) fn leader_changes_count(&self) -> u64 {
        self.leader_changes_dropped + self.leader_changes.len() as u64
    }

    /// Adds the decision that is due; any other is ignored.
    pub fn fold(&mut self, executed: &Executed) {
        if executed.decision != self.due() {
            return;
        }
        let Executed { robot, outcome, leader, .. } = executed;
        let before = self.terms.insert(*robot, leader.term);
        if before != Some(leader.term) {
            if self.leader_changes.len() == LEADER_CHANGES_KEPT {
                self.leader_changes.pop_front();
                self.leader_changes_dropped += 1;
            }
            let Executed { decision: from, .. } = *executed;
            self.leader_changes.push_back(LeaderChange {
                robot: *robot,
                is_first: before.is_none(),
                term: leader.term,
                planner: leader.planner,
                pid: leader.pid,
                from,
            });
        }
        if self.kept.len() == HOPS_KEPT {
            self.kept.pop_front();
            self.first += 1;
        }
        self.kept.push_back(Hop {
            robot: *robot,
            branch: outcome.branch,
            from: outcome.from,
            to: outcome.to,
            height_m: executed.pose.height_m,
            lasts_s: outcome.flight.flight_time_s * f64::from(outcome.flight.flights),
            term: leader.term,
            steps: executed.steps,
            status: executed.status,
            collected: executed.collected,
            visits: executed.visits,
            origin: executed.origin,
            vetoed: executed.vetoed,
            landed: executed.timing.landed,
            stages_ns: executed.timing.stages_ns(),
        });
    }
}

#[cfg(test)]
mod tests {
    use contract::{Digest, Flight, Incarnation, Leader, Outcome, Pose, Timing};

    use super::*;

    #[test]
    fn a_change_of_leader_is_told_once_of_each_robot_and_term() {
        let at = Cell::new(1, 1);
        let executed = |decision: u64, robot: u16, term: u64| Executed {
            decision: Decision(decision),
            robot: RobotId(robot),
            leader: Leader {
                term: Term(term),
                incarnation: Incarnation(u64::from(robot) + 1),
                planner: (if term == 1 { "spiral" } else { "cover_frontier" }).parse().expect("a name"),
                pid: 40 + u32::from(robot),
            },
            outcome: Outcome { branch: Branch::Held, from: at, to: at, flight: Flight::default() },
            pose: Pose { cell: at, height_m: 0.0 },
            collected: Collected::default(),
            steps: decision,
            visits: 0,
            status: Status::Underway,
            origin: Origin::Planner,
            vetoed: Vetoed::NONE,
            timing: Timing::default(),
            digest: Digest::default(),
        };
        let mut hops = Hops::default();
        // Robot 1 changes hands at decision 3; both go on in turn.
        for (decision, term) in [(0, 1), (1, 1), (2, 1), (3, 2), (4, 1), (5, 2), (6, 1), (7, 2)] {
            hops.fold(&executed(decision, (decision % 2) as u16, term));
        }
        let changes = hops
            .leader_changes()
            .map(|change| (change.robot.0, change.term.0, change.from.0, change.is_first));
        assert_eq!(changes.collect::<Vec<_>>(), [(0, 1, 0, true), (1, 1, 1, true), (1, 2, 3, false)]);
    }
}
