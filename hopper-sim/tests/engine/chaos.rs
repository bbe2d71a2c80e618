//! Whatever comes in whatever order: every decision once, in order, told after it is durable.

use contract::{Action, Command, Decision, Incarnation, MonotonicNs, Record, Role, RunId, Status, Term};
use hopper_sim::arbiter::BID_GRACE_NS;
use hopper_sim::{Arbiter, Effect, Event, Pace};
use proptest::prelude::*;

use crate::fixture::{LINGER_NS, beat, command, mission};

/// One thing that may happen, with every number relative to what would be right.
#[derive(Clone, Debug)]
enum Happening {
    Command { run: u8, decision: i64, term: i64, life: u64, action: u32 },
    Answer { ok: bool },
    Beat { role: u32, life: u64, counter: u64, over: bool },
    Tick,
    Death,
}

fn happening() -> impl Strategy<Value = Happening> {
    let near = prop_oneof![6 => Just(0_i64), 1 => -2..3_i64, 1 => Just(i64::from(i32::MAX))];
    let command =
        (0..8_u8, near.clone(), prop_oneof![3 => Just(0_i64), 1 => -1..3_i64], 1..4_u64, 0..5_u32).prop_map(
            |(run, decision, term, life, action)| Happening::Command { run, decision, term, life, action },
        );
    prop_oneof![
        6 => command,
        4 => any::<bool>().prop_map(|ok| Happening::Answer { ok }),
        1 => (1..5_u32, 1..5_u64, 0..9_u64, any::<bool>())
            .prop_map(|(role, life, counter, over)| Happening::Beat { role, life, counter, over }),
        3 => Just(Happening::Tick),
        1 => Just(Happening::Death),
    ]
}

/// The host of one mission, checking every effect as it comes.
struct Witness {
    arbiter: Arbiter,
    pace: Pace,
    now: MonotonicNs,
    records: Vec<Record>,
    pending: Option<Record>,
    finished: bool,
}

impl Witness {
    fn new(pace: Pace, records: Vec<Record>, now: MonotonicNs) -> Self {
        let arbiter = Arbiter::new(mission(), records.last(), pace, LINGER_NS, now);
        Self { arbiter, pace, now, records, pending: None, finished: false }
    }

    fn on(&mut self, event: Event) {
        for effect in self.arbiter.on(event, self.now) {
            match effect {
                Effect::Append(record) => {
                    assert_eq!(record.decision, Decision(self.records.len() as u64), "in order, each once");
                    let previous = self.records.last().map_or(mission().genesis(), |last| last.digest);
                    assert_eq!(record.previous, previous);
                    if let Some(pending) = self.pending.replace(record) {
                        assert_eq!(pending, record, "a retry is the very record");
                    }
                }
                Effect::Publish(state) => {
                    let executed = state.decision.0.checked_sub(1).map(|last| self.records[last as usize]);
                    let digest = executed.map_or(mission().genesis(), |record| record.digest);
                    assert_eq!(state.digest, digest, "only what is durable is told");
                    assert!(state.landed <= state.published && state.published <= self.now);
                }
                Effect::Announce => {}
                Effect::Refused(refusal) => assert!(self.arbiter.refusals().of(refusal.reason()) > 0),
                Effect::Finished(status) => {
                    assert!(status.is_over() && !self.finished, "once, and only when over");
                    self.finished = true;
                }
            }
        }
    }

    fn answer(&mut self, ok: bool) {
        let Some(record) = self.pending else { return };
        // After a failure the arbiter asks again at the next tick; before that nothing is to be answered.
        if ok {
            self.records.push(record);
            self.pending = None;
            self.on(Event::Appended);
        } else {
            self.on(Event::AppendFailed);
            self.on(Event::Tick);
        }
    }

    fn happen(&mut self, happening: &Happening) {
        self.now = self.now.plus_ns(7_000_000);
        match *happening {
            Happening::Command { run, decision, term, life, action } => {
                let state = *self.arbiter.state();
                let offset = |right: u64, by: i64| right.saturating_add_signed(by);
                self.on(Event::Command(Ok(Command {
                    run: if run == 0 { RunId(3) } else { state.run },
                    decision: Decision(offset(state.decision.0, decision)),
                    term: Term(offset(state.leader.term.0.max(1), term)),
                    incarnation: Incarnation(life),
                    ..command(&state, Action::from_code(action).unwrap())
                })));
            }
            Happening::Answer { ok } => self.answer(ok),
            Happening::Beat { role, life, counter, over } => {
                let status = if over { self.arbiter.state().status } else { Status::Underway };
                self.on(Event::Heartbeat(beat(Role::from_code(role).unwrap(), life, counter, status)));
            }
            Happening::Tick => self.on(Event::Tick),
            // Whatever was not appended is forgotten.
            Happening::Death => *self = Self::new(self.pace, std::mem::take(&mut self.records), self.now),
        }
    }

    /// The journal works again, a fresh planner takes the next term: the mission must move on.
    fn proves_alive(&mut self) {
        self.on(Event::Tick);
        self.answer(true);
        while self.arbiter.state().decision.0 < self.records.len() as u64
            && let Some(wake) = self.arbiter.wake_at()
        {
            self.now = self.now.max(wake);
            self.on(Event::Tick);
        }
        let state = *self.arbiter.state();
        if state.status.is_over() {
            self.now = self.now.plus_ns(LINGER_NS);
            self.on(Event::Tick);
            assert!(self.finished);
            return;
        }
        let heir = Command {
            term: state.leader.term.next(),
            incarnation: Incarnation(77),
            ..command(&state, Action::Hold)
        };
        // The decision may be kept a while for another planner that asked for it and fell silent.
        self.now = self.now.plus_ns(2 * BID_GRACE_NS);
        self.on(Event::Command(Ok(heir)));
        self.answer(true);
        assert_eq!(
            self.records.last().map(|record| record.decision),
            Some(state.decision),
            "the heir is heard"
        );
    }
}

proptest! {
    #[test]
    fn every_decision_is_executed_once_and_the_arbiter_stays_alive(
        happenings in prop::collection::vec(happening(), 0..120),
        pace in prop_oneof![Just(Pace::Max), Just(Pace::Real), Just(Pace::Hertz(50.0))],
    ) {
        let mut witness = Witness::new(pace, Vec::new(), MonotonicNs(1_000));
        for happening in &happenings {
            witness.happen(happening);
        }
        witness.proves_alive();
        let terms: Vec<_> = witness.records.iter().map(|record| record.leader.term).collect();
        prop_assert!(terms.is_sorted(), "terms only rise: {:?}", terms);
    }
}
