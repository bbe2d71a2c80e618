//! Which past a reader has folded, so that it notices when hopper-sim continues from another one.
//!
//! A journal may lose its tail, or be restored to an earlier decision and flown on elsewhere under the same run. From there
//! on the same decision numbers stand for other hops, and what was folded of the old ones is void. The digest chain tells
//! the two apart.

use contract::{Decision, Digest, Record, State};

/// The decisions that a reader has folded, and the digest after the last of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct Timeline {
    due: Decision,
    /// `None` where only the start is known: the brief has its pose, but not its digest.
    digest: Option<Digest>,
}

impl Timeline {
    /// The timeline of a reader that has folded everything up to `state`.
    #[must_use]
    pub fn through(state: &State) -> Self {
        Self { due: state.decision, digest: Some(state.digest) }
    }

    /// The decision whose record comes next.
    #[must_use]
    pub fn due(&self) -> Decision {
        self.due
    }

    /// The digest after the last decision folded, if it is known.
    #[must_use]
    pub fn digest(&self) -> Option<Digest> {
        self.digest
    }

    /// Takes note that `record`, the one that is due, is folded.
    pub fn fold(&mut self, record: &Record) {
        *self = Self { due: record.decision.next(), digest: Some(record.digest) };
    }

    /// Whether `record`, the one that is due, continues from another past than the one folded.
    #[must_use]
    pub fn is_broken_by(&self, record: &Record) -> bool {
        self.digest.is_some_and(|digest| digest != record.previous)
    }

    /// Whether `record`, of the decision that was folded last, leads elsewhere than the one folded.
    #[must_use]
    pub fn is_not_after(&self, record: &Record) -> bool {
        record.decision.next() == self.due && self.digest.is_some_and(|digest| digest != record.digest)
    }

    /// Whether `state` proves that the past folded is not its own. A state more than one decision ahead proves nothing:
    /// the records between decide.
    #[must_use]
    pub fn is_contradicted_by(&self, state: &State) -> bool {
        if state.decision < self.due {
            return true;
        }
        let Some(digest) = self.digest else { return false };
        if state.decision == self.due {
            return digest != state.digest;
        }
        state.decision == self.due.next() && digest != state.previous
    }
}

#[cfg(test)]
mod tests {
    use contract::{
        Action, Branch, Cell, Collected, Direction, Flight, Leader, MonotonicNs, Origin, Outcome, Pose,
        RobotId, RunId, Status, Timing, Vetoed,
    };

    use super::*;

    fn record(decision: u64, action: Action, to: Cell, previous: Digest) -> Record {
        let branch = if action == Action::Hold { Branch::Held } else { Branch::Intended };
        let mut record = Record {
            robot: RobotId(0),
            decision: Decision(decision),
            leader: Leader::default(),
            action,
            origin: Origin::Planner,
            vetoed: Vetoed::NONE,
            observation: 0,
            work: 0,
            cut: false,
            outcome: Outcome { branch, from: Cell::new(3, 3), to, flight: Flight::default() },
            pose: Pose { cell: to, height_m: 0.5 },
            detail: contract::DetailId::NONE,
            collected: Collected::default(),
            visits: 0,
            steps: 2 * (decision + 1),
            status: Status::Underway,
            timing: Timing::default(),
            previous,
            digest: previous,
        };
        record.digest = previous.chain(&record);
        record
    }

    fn state(record: &Record) -> State {
        record.state_after(RunId(1), MonotonicNs(1), MonotonicNs(2))
    }

    /// P-TIMELINE: Every reader of the past compares each record and state with the digest chain.
    /// If the journal has lost its tail, or was restored and continued elsewhere, map and history
    /// are rebuilt, and no plan for another past is sent or executed: states, maps and commands
    /// name the digest they belong to.
    #[test]
    fn a_past_is_contradicted_by_what_cannot_follow_it_and_by_nothing_else() {
        let east = Action::Hop(Direction::East);
        let first = record(0, east, Cell::new(4, 3), Digest([7; 32]));
        let second = record(1, east, Cell::new(5, 3), first.digest);
        let other_first = record(0, Action::Hold, Cell::new(3, 3), Digest([7; 32]));
        let other_second = record(1, east, Cell::new(4, 3), other_first.digest);
        let mut timeline = Timeline::default();
        assert!(
            !timeline.is_contradicted_by(&state(&first)) && !timeline.is_contradicted_by(&state(&second))
        );
        timeline.fold(&first);
        let through = Timeline::through(&state(&first));
        assert_eq!(timeline, through);
        assert_eq!(timeline.due(), Decision(1));
        assert!(!timeline.is_broken_by(&second) && timeline.is_broken_by(&other_second));
        for (state_after, contradicts) in
            [(&first, false), (&second, false), (&other_first, true), (&other_second, true)]
        {
            assert_eq!(timeline.is_contradicted_by(&state(state_after)), contradicts);
        }
        timeline.fold(&second);
        assert!(timeline.is_contradicted_by(&state(&first)), "decisions that were folded are gone");
        let later = record(5, east, Cell::new(4, 3), Digest([9; 32]));
        assert!(!timeline.is_contradicted_by(&state(&later)), "the records between decide");
    }
}
