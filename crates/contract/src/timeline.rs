//! Which past a reader has folded, so that it notices when hopper-sim continues from another one.
//!
//! A journal may lose its tail, or be restored to an earlier decision and flown on elsewhere under the same run. From there
//! on the same decision numbers stand for other hops, and what was folded of the old ones is void. The digest chain tells
//! the two apart.

use crate::{Action, Decision, Digest, Link, MonotonicNs, Outcome, Record, State};

/// The decisions that a reader has folded, and the digest after the last of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Timeline {
    due: Decision,
    /// `None` where only the start is known: the brief has its pose, but not its digest.
    digest: Option<Digest>,
    /// When the state of the decision that is due was published, if it was one that was folded; else 0.
    published: MonotonicNs,
}

impl Timeline {
    /// The timeline of a reader that has folded everything up to `state`.
    #[must_use]
    pub fn through(state: &State) -> Self {
        Self { due: state.decision, digest: Some(state.digest), published: state.published }
    }

    /// The decision whose record comes next.
    #[must_use]
    pub fn due(&self) -> Decision {
        self.due
    }

    /// Takes note that `record`, the one that is due, is folded.
    pub fn fold(&mut self, record: &Record) {
        *self = Self { due: record.decision.next(), digest: Some(record.digest), published: MonotonicNs(0) };
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
        state.decision == self.due.next() && !self.is_followed_by(state) && !state.continues(digest)
    }

    /// Whether `state`, one decision ahead, names the very moment at which the state folded was published. One hopper-sim
    /// publishes at a time, on one clock, so no other past has a state of that moment; this spares a hash for nearly every
    /// state.
    fn is_followed_by(&self, state: &State) -> bool {
        self.published > MonotonicNs(0) && state.last_timing.state_published == self.published
    }
}

impl State {
    /// Whether `known`, of the same run, has replaced this state: published no earlier, it is of a later decision, or of
    /// the same decision on another timeline. A lower decision published later is that of a journal that has lost its
    /// tail.
    #[must_use]
    pub fn is_older_than(&self, known: &State) -> bool {
        let behind = self.decision < known.decision
            || (self.decision == known.decision && self.digest != known.digest);
        self.run == known.run && behind && self.published <= known.published
    }

    /// Whether this is the state one decision after the one whose digest is `before`. The state does not name the action
    /// that led to it, so each is tried; the direction of the landing first, which is nearly always right.
    #[must_use]
    pub fn continues(&self, before: Digest) -> bool {
        let leads_there = |action: &Action| {
            let Some(Outcome { from, to, .. }) = self.last else { return false };
            let (x, y) = if let Action::Hop(direction) = action { direction.step() } else { (0, 0) };
            ((to.x - from.x).signum(), (to.y - from.y).signum()) == (x, y)
        };
        let likely = Action::ALL.into_iter().filter(leads_there);
        let others = Action::ALL.into_iter().filter(|action| !leads_there(action));
        likely.chain(others).any(|action| self.digest_after(before, action) == Some(self.digest))
    }

    /// The digest that this state has if `action` led to it from the state with the digest `before`; `None` for the
    /// state before the first decision.
    #[must_use]
    pub fn digest_after(&self, before: Digest, action: Action) -> Option<Digest> {
        let State { pose, steps, status, collected, .. } = *self;
        let (outcome, decision) = (self.last?, Decision(self.decision.0.checked_sub(1)?));
        Some(before.chain_link(&Link { decision, action, outcome, pose, steps, status, collected }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Branch, Cell, Collected, Direction, Flight, Leader, MonotonicNs, Origin, Pose, RobotId, RunId,
        Status, Timing, Vetoed,
    };

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

    /// P-TIMELINE.
    #[test]
    fn a_state_continues_the_digest_before_it_whatever_the_action_and_the_landing() {
        let before = Digest([7; 32]);
        for action in Action::ALL {
            for to in [Cell::new(3, 4), Cell::new(3, 3), Cell::new(2, 4), Cell::new(9, 0)] {
                let after = state(&record(4, action, to, before));
                assert!(after.continues(before), "{action} to {to}");
                assert!(!after.continues(Digest([8; 32])), "{action} to {to}");
            }
        }
    }

    /// P-TIMELINE.
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
        assert_eq!((timeline.due, timeline.digest), (through.due, through.digest));
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

    /// P-TIMELINE.
    #[test]
    fn a_state_that_names_the_publication_before_it_needs_no_hash() {
        let east = Action::Hop(Direction::East);
        let first = record(0, east, Cell::new(4, 3), Digest([7; 32]));
        let known = state(&first);
        let named = |published| Timing { state_published: published, ..Timing::default() };
        let follows = |timing| {
            let other = record(1, east, Cell::new(5, 3), Digest([9; 32]));
            !Timeline::through(&known).is_contradicted_by(&state(&Record { timing, ..other }))
        };
        assert!(follows(named(known.published)));
        assert!(!follows(named(MonotonicNs(known.published.0 + 1))) && !follows(named(MonotonicNs(0))));
    }
}
