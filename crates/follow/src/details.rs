//! Details of executed decisions, requested until they arrive.
//!
//! A record names its detail. A state does not, but its digest shows whether there is one, and whether a given one is it. Under the law
//! decisions have no details, so nothing is requested.

use std::collections::BTreeMap;

use contract::{
    Decision, Detail, DetailId, DetailPage, DetailRequest, MonotonicNs, Record, Robots, RunId, State,
};

use crate::page_cursor::OneByOne;

/// Answers in a row of which none is the detail that was told of, after which that is taken to be of a past that the journal has lost.
const UNPROVEN_MAX: u32 = 3;

/// The details of one run that are missing. The first one is asked for first.
#[derive(Clone, Debug, Default)]
pub struct DetailFollower {
    run: RunId,
    missing: BTreeMap<Decision, Proof>,
    asked: OneByOne<Decision>,
    /// Answers to the present question that were not what was told of.
    unproven: u32,
}

/// What proves that a detail is that of a decision.
#[derive(Clone, Debug)]
enum Proof {
    Record(DetailId),
    State(Box<State>),
}

impl DetailFollower {
    /// Begins to follow the details of `run`, and forgets those of any other.
    pub fn begin(&mut self, run: RunId) {
        if self.run != run {
            *self = Self { run, ..Self::default() };
        }
    }

    /// Takes note of an executed decision, for whose detail is asked if it has one. Decisions are told of in their order: one that
    /// comes again begins a past in which those after it were not executed yet.
    pub fn record(&mut self, record: &Record) {
        let proof = if record.detail.is_none() { None } else { Some(Proof::Record(record.detail)) };
        self.tell(record.decision, proof);
    }

    /// Takes note of the decision that led to `state`, as of a record. Of `robots` only those that hop have details.
    pub fn state(&mut self, robots: &Robots, state: &State) {
        let Some(decision) = state.decision.0.checked_sub(1) else { return };
        let hops = robots.at(state.robot).is_some_and(|robot| robot.body.hops());
        let has_one = hops && !state.names_detail(DetailId::NONE);
        self.tell(Decision(decision), has_one.then(|| Proof::State(Box::new(*state))));
    }

    fn tell(&mut self, decision: Decision, proof: Option<Proof>) {
        drop(self.missing.split_off(&decision));
        self.missing.extend(proof.map(|proof| (decision, proof)));
    }

    /// Needs no more details than those of the last `most` decisions.
    pub fn keep_last(&mut self, most: usize) {
        while self.missing.len() > most {
            self.missing.pop_first();
        }
    }

    /// Takes an answer; the decision and its detail, if it was missing. Any other is asked for again, a few times.
    pub fn page(&mut self, page: DetailPage) -> Option<(Decision, Detail)> {
        let DetailPage { run, decision, detail } = page;
        let proof = self.missing.get(&decision).filter(|_| run == self.run)?;
        let is_proven = match proof {
            Proof::Record(id) => *id == detail.id(),
            Proof::State(state) => state.names_detail(detail.id()),
        };
        if !is_proven {
            self.unproven += u32::from(self.asked.is_for(&decision));
            if self.unproven >= UNPROVEN_MAX {
                self.missing.remove(&decision);
            }
            return None;
        }
        self.missing.remove(&decision);
        Some((decision, detail))
    }

    /// Needs no detail until its decision is told of again, since the journal may have lost those decisions.
    pub fn forget_missing(&mut self) {
        self.missing.clear();
    }

    /// Whether no detail is missing.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.missing.is_empty()
    }

    /// What to ask for at `now`: the first detail that is missing, and again if it does not come.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<DetailRequest> {
        let first = *self.missing.first_key_value()?.0;
        if !self.asked.is_for(&first) {
            self.unproven = 0;
        }
        let decision = self.asked.ask(first, now)?;
        Some(DetailRequest { run: self.run, decision })
    }
}

#[cfg(test)]
mod tests {
    use contract::limits::ASK_AGAIN_NS;
    use contract::motion_model::FIGURES;
    use contract::{
        Action, Branch, Cell, Collected, Digest, Direction, Flight, GradientSource, Grid, Leader,
        MotionModel, MotionParameters, Origin, Outcome, PathPoint, Pose, Robot, RobotId, SensorParameters,
        SoilMotion, Status, Timing, Vetoed,
    };

    use super::*;

    const RUN: RunId = RunId(3);

    fn hopper() -> Robots {
        let soil = SoilMotion { intended: 0.8, stuck: 0.1, sideways: 0.05, flights: 1 };
        let (hard, sand, gravity_mps2) = (soil, soil, 3.72);
        let motion = MotionParameters {
            hard,
            sand,
            slope_limit_rad: 0.5,
            launch_angle_rad: 0.8,
            gravity_mps2,
            vertical: false,
            table: 0,
        };
        let gradient = GradientSource::Measured;
        let sensor =
            SensorParameters { gain: 2.0, offset_m: 1.0, radius_min_m: 1.0, radius_max_m: 9.0, gradient };
        let grid = Grid::new(4, 4, 1.0, 1).unwrap();
        Robots::new(&[Robot::hopper(&grid, motion, sensor, [Cell::new(0, 0), Cell::new(3, 3)])]).unwrap()
    }

    fn detail(east_m: f64) -> Detail {
        let path = vec![PathPoint { seconds: 0.0, at_m: [0.5; 3], leaves_mps: [1.0, 0.0, 1.0] }];
        Detail { model: MotionModel::Contact, rest_m: [east_m, 0.5, 0.0], figures: [0.0; FIGURES], path }
    }

    fn record(decision: u64, detail: Option<&Detail>) -> Record {
        let to = Cell::new(1, 0);
        let mut record = Record {
            robot: RobotId(0),
            decision: Decision(decision),
            leader: Leader::default(),
            action: Action::Hop(Direction::East),
            origin: Origin::Planner,
            vetoed: Vetoed::NONE,
            observation: 0,
            work: 0,
            cut: false,
            outcome: Outcome {
                branch: Branch::Intended,
                from: Cell::new(0, 0),
                to,
                flight: Flight::default(),
            },
            pose: Pose { cell: to, height_m: 0.5 },
            detail: detail.map_or(DetailId::NONE, Detail::id),
            collected: Collected::default(),
            visits: 0,
            steps: 2,
            status: Status::Underway,
            timing: Timing::default(),
            previous: Digest([decision as u8; 32]),
            digest: Digest::default(),
        };
        record.digest = record.previous.chain(&record);
        record
    }

    fn state(record: &Record) -> State {
        record.state_after(RUN, MonotonicNs(1), MonotonicNs(2))
    }

    fn page(decision: u64, detail: &Detail) -> DetailPage {
        DetailPage { run: RUN, decision: Decision(decision), detail: detail.clone() }
    }

    /// P-DETAILS-FOLLOWED: A reader asks for the detail of each decision that has one, by its record or its state, until
    /// it comes, and takes no other. Under the law it asks for nothing.
    #[test]
    fn a_detail_is_asked_for_until_it_comes_whether_a_record_or_a_state_told_of_it() {
        let details = [detail(1.25), detail(1.5)];
        let mut follower = DetailFollower::default();
        follower.begin(RUN);
        follower.record(&record(0, Some(&details[0])));
        follower.state(&hopper(), &state(&record(1, Some(&details[1]))));
        let asks = |decision| Some(DetailRequest { run: RUN, decision: Decision(decision) });
        assert_eq!(follower.ask(MonotonicNs(5)), asks(0));
        assert_eq!(follower.ask(MonotonicNs(4 + ASK_AGAIN_NS)), None, "one request at a time");
        assert_eq!(follower.ask(MonotonicNs(5 + ASK_AGAIN_NS)), asks(0), "the answer was lost");
        assert_eq!(follower.page(page(0, &details[1])), None, "that of another decision");
        assert_eq!(follower.page(DetailPage { run: RunId(4), ..page(0, &details[0]) }), None, "another run");
        assert_eq!(follower.page(page(0, &details[0])), Some((Decision(0), details[0].clone())));
        assert_eq!(follower.page(page(0, &details[0])), None, "late, and there already");
        assert_eq!(follower.ask(MonotonicNs(6 + ASK_AGAIN_NS)), asks(1), "another need not wait");
        assert_eq!(follower.page(page(1, &details[0])), None, "its digest names another");
        assert!(!follower.is_whole());
        assert_eq!(follower.page(page(1, &details[1])), Some((Decision(1), details[1].clone())));
        assert!(follower.is_whole() && follower.ask(MonotonicNs(u64::MAX)).is_none());
    }

    /// P-DETAILS-FOLLOWED. What the journal has lost is not asked for for ever, and blocks nothing that was told of after it.
    #[test]
    fn a_detail_of_a_lost_past_is_given_up() {
        let mut follower = DetailFollower::default();
        follower.begin(RUN);
        let (lost, new) = (detail(1.25), detail(1.5));
        for decision in 0..3 {
            follower.record(&record(decision, Some(&lost)));
        }
        // Decision 1 was executed again, decision 0 too, of which nothing was heard.
        follower.record(&record(1, Some(&new)));
        let mut now = MonotonicNs(5);
        for _ in 0..UNPROVEN_MAX {
            assert_eq!(follower.ask(now), Some(DetailRequest { run: RUN, decision: Decision(0) }));
            assert_eq!(follower.page(page(0, &new)), None);
            now = now.plus_ns(ASK_AGAIN_NS);
        }
        assert_eq!(follower.ask(now), Some(DetailRequest { run: RUN, decision: Decision(1) }));
        assert_eq!(follower.page(page(1, &new)), Some((Decision(1), new)));
        assert!(follower.is_whole(), "decision 2 is not executed yet");
        for decision in 2..9 {
            follower.record(&record(decision, Some(&lost)));
            follower.keep_last(3);
        }
        assert_eq!(follower.ask(now), Some(DetailRequest { run: RUN, decision: Decision(6) }));
    }

    #[test]
    fn nothing_is_asked_for_where_nothing_is_told() {
        let mut follower = DetailFollower::default();
        follower.begin(RUN);
        follower.record(&record(0, None));
        follower.state(&hopper(), &state(&record(1, None)));
        assert!(follower.is_whole() && follower.ask(MonotonicNs(5)).is_none());
        // Of another timeline, the same decision may have none.
        follower.record(&record(2, Some(&detail(1.5))));
        follower.record(&record(2, None));
        assert!(follower.is_whole());
        follower.state(&hopper(), &state(&record(2, Some(&detail(1.5)))));
        assert!(!follower.is_whole());
        follower.state(&hopper(), &state(&record(2, None)));
        assert!(follower.is_whole());
        // The journal has lost its tail.
        follower.record(&record(2, Some(&detail(1.5))));
        follower.forget_missing();
        assert!(follower.is_whole() && follower.ask(MonotonicNs(6)).is_none());
    }
}
