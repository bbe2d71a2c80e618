//! The executed decisions of a run in order, from states and from `hop/past`.
//!
//! A state tells of the last decision, so a reader that has folded all before it needs nothing else. What it has missed
//! it asks for. The digest chain shows whether a state or a record continues what was folded. A state that does not is
//! proof that the journal has lost its tail or was flown on elsewhere. A record that does not may itself be wrong, as that
//! of a late page, so the reader asks for the record before it, which decides.

use contract::{Decision, MonotonicNs, PastRequest, Record, RobotId, RunId, State};

use crate::page_cursor::PageCursor;
use crate::timeline::Timeline;

/// How far the decisions of one run are folded, and which records are asked for.
#[derive(Clone, Copy, Debug, Default)]
pub struct PastFollower {
    timeline: Timeline,
    /// When the last decision that is folded was executed: a state published before is a late one.
    committed: MonotonicNs,
    /// Whether a record came that does not continue what is folded, and the record before is asked for.
    doubts: bool,
    cursor: PageCursor,
}

/// How a record continues what a reader has folded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// It is the next one: fold it, then [`PastFollower::fold`].
    Next,
    /// It is of another decision than the one that is due.
    OtherDecision,
    /// It is of the decision that is due, and of another past. The record before it is asked for.
    Broken,
    /// What is folded is not in the journal: begin anew.
    PastIsLost,
}

impl PastFollower {
    /// The decision whose record comes next.
    #[must_use]
    pub fn due(&self) -> Decision {
        self.timeline.due()
    }

    /// Whether it is known in which past the decision that is due follows. Of the start this is unknown until its state
    /// or the first record came.
    #[must_use]
    pub fn knows_its_past(&self) -> bool {
        self.timeline.digest().is_some()
    }

    /// Whether `state` proves that what is folded is not in the journal. For a reader that folds records beyond its state
    /// it does so only if it is not late: [`PastFollower::is_late`].
    #[must_use]
    pub fn is_contradicted_by(&self, state: &State) -> bool {
        self.timeline.is_contradicted_by(state)
    }

    /// Whether records may have brought decisions after `state`, so that it is no news. To be asked only by a reader that
    /// folds records beyond its state: stamps of before a reboot are later than those after it.
    #[must_use]
    pub fn is_late(&self, state: &State) -> bool {
        state.decision < self.due() && state.published <= self.committed
    }

    /// Whether `state` tells of the decision that is due: fold it, then [`PastFollower::fold_state`].
    #[must_use]
    pub fn is_next(&self, state: &State) -> bool {
        state.decision == self.due().next()
    }

    /// Takes note that everything up to `state` is folded.
    pub fn fold_state(&mut self, state: &State) {
        self.timeline = Timeline::through(state);
        (self.committed, self.doubts) = (state.last_timing.committed, false);
    }

    /// How `record` continues what is folded.
    pub fn link(&mut self, record: &Record) -> Link {
        if self.doubts && self.timeline.is_not_after(record) {
            return Link::PastIsLost;
        }
        if self.doubts && record.decision.next() == self.due() {
            // It is as it was folded: the record that was due was wrong, and is asked for again.
            self.doubts = false;
        }
        if record.decision != self.due() {
            return Link::OtherDecision;
        }
        if self.timeline.is_broken_by(record) {
            self.doubts = true;
            return Link::Broken;
        }
        Link::Next
    }

    /// Takes note that `record`, which was [`Link::Next`], is folded.
    pub fn fold(&mut self, record: &Record) {
        self.timeline.fold(record);
        (self.committed, self.doubts) = (record.timing.committed, false);
    }

    /// Begins at decision 0 again. The pause since the last request stays in force for [`PastFollower::ask_after`].
    pub fn begin_anew(&mut self) {
        *self = Self { cursor: self.cursor, ..Self::default() };
    }

    /// What to ask for at `now`: at once when something was folded since the last request, else again after a pause.
    pub fn ask(&mut self, run: RunId, robot: RobotId, now: MonotonicNs) -> Option<PastRequest> {
        self.cursor.advance_to(self.wanted());
        let from = Decision(self.cursor.ask(now)?);
        Some(PastRequest { run, robot, from })
    }

    /// What to ask for at `now`: `pause_ns` nanoseconds after the last request, whatever was folded since.
    pub fn ask_after(
        &mut self,
        run: RunId,
        robot: RobotId,
        now: MonotonicNs,
        pause_ns: u64,
    ) -> Option<PastRequest> {
        self.cursor.move_to(self.wanted());
        let from = Decision(self.cursor.ask_after(now, pause_ns)?);
        Some(PastRequest { run, robot, from })
    }

    /// Lets the next request be sent at once.
    pub fn end_pause(&mut self) {
        self.cursor = PageCursor::default();
    }

    /// The first record that is wanted: the one that is due, or the one before if that has to decide.
    fn wanted(&self) -> u64 {
        self.due().0.saturating_sub(u64::from(self.doubts))
    }
}

#[cfg(test)]
mod tests {
    use contract::limits::ASK_AGAIN_NS;
    use contract::{
        Action, Branch, Cell, Collected, Digest, Flight, Leader, Origin, Outcome, Pose, Status, Timing,
        Vetoed,
    };

    use super::*;

    const RUN: RunId = RunId(3);

    /// A journal of `count` decisions that begins at `start`.
    fn journal(start: Digest, count: u64) -> Vec<Record> {
        let cell = Cell::new(3, 3);
        let mut records: Vec<Record> = Vec::new();
        for decision in (0..count).map(Decision) {
            let previous = records.last().map_or(start, |last| last.digest);
            let mut record = Record {
                robot: RobotId(0),
                decision,
                leader: Leader::default(),
                action: Action::Hold,
                origin: Origin::Planner,
                vetoed: Vetoed::NONE,
                observation: 0,
                work: 0,
                cut: false,
                outcome: Outcome { branch: Branch::Held, from: cell, to: cell, flight: Flight::default() },
                pose: Pose { cell, height_m: 0.5 },
                detail: contract::DetailId::NONE,
                collected: Collected::default(),
                visits: 0,
                steps: 2 * decision.next().0,
                status: Status::Underway,
                timing: Timing { committed: MonotonicNs(100 * decision.next().0), ..Timing::default() },
                previous,
                digest: previous,
            };
            record.digest = previous.chain(&record);
            records.push(record);
        }
        records
    }

    fn followed(records: &[Record]) -> PastFollower {
        let mut past = PastFollower::default();
        for record in records {
            assert_eq!(past.link(record), Link::Next);
            past.fold(record);
        }
        past
    }

    fn asks(past: &mut PastFollower, now: u64) -> Option<u64> {
        past.ask(RUN, RobotId(0), MonotonicNs(now)).map(|request| request.from.0)
    }

    #[test]
    fn a_record_that_does_not_continue_lets_the_one_before_decide() {
        let (own, other) = (journal(Digest([1; 32]), 4), journal(Digest([2; 32]), 4));
        let mut past = followed(&own[..2]);
        assert_eq!(asks(&mut past, 1), Some(2));
        assert_eq!(past.link(&own[3]), Link::OtherDecision);
        assert_eq!(past.link(&other[1]), Link::OtherDecision, "nobody doubts");
        assert_eq!(past.link(&other[2]), Link::Broken);
        assert_eq!(asks(&mut past, 2), Some(1), "the record before is asked for at once");
        assert_eq!(asks(&mut past, 3), None);
        let mut misled = past;
        assert_eq!(past.link(&own[1]), Link::OtherDecision);
        assert_eq!(asks(&mut past, 3), Some(2), "the record before is as it was");
        assert_eq!(past.link(&own[2]), Link::Next, "that record was wrong");
        past.fold(&own[2]);
        assert_eq!(asks(&mut past, 4), Some(3));
        assert_eq!(misled.link(&other[1]), Link::PastIsLost, "what was folded is gone");
        misled.begin_anew();
        assert_eq!((misled.due(), misled.knows_its_past()), (Decision(0), false));
        assert_eq!(misled.link(&other[0]), Link::Next);
    }

    #[test]
    fn a_late_state_is_told_from_one_of_a_journal_that_has_lost_its_tail() {
        let records = journal(Digest([1; 32]), 3);
        let past = followed(&records);
        let state =
            |record: &Record, published| record.state_after(RUN, MonotonicNs(0), MonotonicNs(published));
        assert!(past.is_late(&state(&records[1], 250)), "decision 2 was executed at 300");
        assert!(!past.is_late(&state(&records[1], 350)) && !past.is_late(&state(&records[2], 250)));
        assert!(past.is_contradicted_by(&state(&records[1], 350)));
        assert!(!past.is_contradicted_by(&state(&records[2], 350)));
    }

    #[test]
    fn a_state_right_after_what_is_folded_needs_no_record() {
        let records = journal(Digest([1; 32]), 3);
        let mut past = followed(&records[..1]);
        let states = records.iter().map(|record| record.state_after(RUN, MonotonicNs(0), MonotonicNs(0)));
        let states: Vec<State> = states.collect();
        assert!(past.is_next(&states[1]) && !past.is_next(&states[2]) && !past.is_next(&states[0]));
        past.fold_state(&states[1]);
        assert_eq!(past.due(), Decision(2));
        assert_eq!(past.link(&records[2]), Link::Next);
    }

    #[test]
    fn progress_ends_the_pause_only_of_a_reader_in_haste() {
        let records = journal(Digest([1; 32]), 2);
        let mut past = PastFollower::default();
        assert_eq!(asks(&mut past, 1), Some(0));
        past.fold(&records[0]);
        let mut calm = past;
        assert_eq!(asks(&mut past, 2), Some(1));
        let later = |past: &mut PastFollower, now| {
            let request = past.ask_after(RUN, RobotId(0), MonotonicNs(now), 2 * ASK_AGAIN_NS);
            request.map(|request| request.from.0)
        };
        assert_eq!(later(&mut calm, 2), None);
        assert_eq!(later(&mut calm, 1 + 2 * ASK_AGAIN_NS), Some(1));
        calm.end_pause();
        assert_eq!(later(&mut calm, 2 + 2 * ASK_AGAIN_NS), Some(1));
    }
}
