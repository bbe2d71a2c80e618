//! The processes one after the other in one thread: direct calls, no faults, no shared memory.
//!
//! A mission flown here has the digest of the same mission flown by four processes, bit for bit. No time
//! passes here, so no deadline does: a mission in which the guard's fallback acted is repeated by its journal.

#![warn(clippy::disallowed_methods)]

mod ports;

use std::collections::BTreeMap;

use contract::{
    Decision, Incarnation, MonotonicNs, Name, ObservedMap, PastPage, PolicyCell, Record, RefusalCounts,
    RobotId, RunId, State,
};
use hopper_sim::process::{HopperSim, RecordStore, SimTerms};
use hopper_sim::{Fallback, JournalError, Mission, Pace};
use perception::Cartographer;
use perception::process::Perception;
use planner::process::{Claim, PlannerProcess};
use planner::{Planner, PlannerError};
use process::{Failure, Process, Terms, Turn, block_on};
use tracing::subscriber::{NoSubscriber, with_default};

use ports::{Bus, DirectPorts};

/// Rounds without a decision after which lockstep has stalled; the pages of the largest map take a few hundred.
const ROUNDS_MAX: u64 = 10_000;

/// Which algorithm commands from which decision on, and what the fallback did between them.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct PlannerSchedule {
    /// Algorithms by the first decision that each commands.
    planners: BTreeMap<Decision, Name>,
    fallbacks: BTreeMap<Decision, Fallback>,
}

impl PlannerSchedule {
    /// One algorithm from start to end.
    #[must_use]
    pub fn single(planner: Name) -> Self {
        Self { planners: BTreeMap::from([(Decision(0), planner)]), ..Self::default() }
    }

    /// The schedule that a journal's records show. A planner that is followed by another of the same algorithm, under
    /// another term, is one entry.
    ///
    /// # Errors
    /// The first error of `records`.
    pub fn from_records<E>(records: impl Iterator<Item = Result<Record, E>>) -> Result<Self, E> {
        let Self { mut planners, mut fallbacks } = Self::default();
        for record in records {
            let Record { decision, action, origin, leader, .. } = record?;
            if origin.is_fallback() {
                fallbacks.insert(decision, Fallback { action, origin });
            } else if planners.last_key_value().is_none_or(|(_, last)| *last != leader.planner) {
                planners.insert(decision, leader.planner);
            }
        }
        Ok(Self { planners, fallbacks })
    }

    /// Whether nobody decides anything in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.planners.is_empty() && self.fallbacks.is_empty()
    }
}

/// How a mission ended.
#[derive(Debug)]
pub struct Flown {
    /// The last state.
    pub state: State,
    /// The map at the end.
    pub map: ObservedMap,
    /// Policy behind the last decision, if its planner has one.
    pub policy: Option<Vec<PolicyCell>>,
    /// What the arbiter refused; nothing, unless something is wrong.
    pub refusals: RefusalCounts,
}

/// Flies `mission` to its end, telling `observe` of each executed decision.
///
/// `clock` is read for the timing of decisions only; no result depends on it.
///
/// # Errors
/// If the schedule names an unknown algorithm.
///
/// # Panics
/// If the processes stall, which would be a defect of the protocol.
pub fn fly(
    mission: Mission,
    schedule: &PlannerSchedule,
    clock: &mut dyn FnMut() -> MonotonicNs,
    observe: &mut dyn FnMut(&Record),
) -> Result<Flown, PlannerError> {
    // What the processes log belongs to processes: a campaign flies a thousand missions a second.
    with_default(NoSubscriber::default(), || fly_silently(mission, schedule, clock, observe))
}

fn fly_silently(
    mission: Mission,
    schedule: &PlannerSchedule,
    clock: &mut dyn FnMut() -> MonotonicNs,
    observe: &mut dyn FnMut(&Record),
) -> Result<Flown, PlannerError> {
    let bus = Bus::new(clock);
    let mut host = Host::join(&bus, mission, schedule, observe)?;
    let mut rounds = 0;
    let mut decision = Decision(0);
    while !host.round()? {
        rounds += 1;
        let reached = host.sim.arbiter().state().decision;
        if reached > decision {
            (rounds, decision) = (0, reached);
        }
        assert!(rounds < ROUNDS_MAX, "lockstep stalls at decision {decision}");
    }
    let refusals = host.sim.arbiter().refusals().clone();
    let expected: u64 = ["repeated_decision", "vetoed"].map(|reason| refusals.of(reason)).iter().sum();
    debug_assert_eq!(
        refusals.0.values().sum::<u64>(),
        expected,
        "lockstep refuses only what is repeated or vetoed"
    );
    Ok(Flown {
        state: *host.sim.arbiter().state(),
        map: host.perception.cartographer().map().expect("a flown mission has a map").clone(),
        policy: host.planner.planner().policy(),
        refusals,
    })
}

/// Records go nowhere: what lockstep flies can be flown again.
struct NoRecords(RunId);

impl RecordStore for NoRecords {
    fn run(&self) -> RunId {
        self.0
    }

    fn append(&mut self, _record: &Record) -> Result<(), JournalError> {
        Ok(())
    }

    fn page(&self, from: Decision) -> Result<PastPage, JournalError> {
        Ok(PastPage { run: self.0, robot: RobotId(0), from, records: Vec::new() })
    }
}

type Observe<'a> = &'a mut dyn FnMut(&Record);

/// The processes of one mission.
struct Host<'b, 'c, 'o> {
    bus: &'b Bus<'c>,
    sim: HopperSim<DirectPorts<'b, 'c>, NoRecords, Observe<'o>>,
    perception: Perception<DirectPorts<'b, 'c>>,
    planner: PlannerProcess<DirectPorts<'b, 'c>>,
    ports: [DirectPorts<'b, 'c>; 3],
    /// Who commands later.
    planners: BTreeMap<Decision, Name>,
    fallbacks: BTreeMap<Decision, Fallback>,
    lives: u64,
}

impl<'b, 'c, 'o> Host<'b, 'c, 'o> {
    fn join(
        bus: &'b Bus<'c>,
        mission: Mission,
        schedule: &PlannerSchedule,
        observe: Observe<'o>,
    ) -> Result<Self, PlannerError> {
        let PlannerSchedule { mut planners, fallbacks } = schedule.clone();
        let first = planners.pop_first().map_or_else(|| "hold".parse().expect("a name"), |(_, name)| name);
        let planner = algorithm(first, &mission)?;
        let terms = SimTerms {
            pace: Pace::Max,
            linger_ns: 0,
            control: false,
            deadlines: false,
            terms: Terms::default(),
        };
        let records = NoRecords(mission.brief.run);
        bus.look_at_clock();
        let mut ports = [1, 2, 3].map(|life| bus.ports(Incarnation(life)));
        let [of_sim, of_perception, of_planner] = &mut ports;
        let never = "direct ports always open";
        Ok(Self {
            bus,
            sim: block_on(HopperSim::join(of_sim, mission, (records, None), observe, terms)).expect(never),
            perception: block_on(Perception::join(
                of_perception,
                Cartographer::new(RobotId(0)),
                Terms::default(),
            ))
            .expect(never),
            planner: block_on(PlannerProcess::join(of_planner, planner, TAKES_OVER, Terms::default()))
                .expect(never),
            ports,
            planners,
            fallbacks,
            lives: 3,
        })
    }

    /// Lets every process take its turn; whether the mission is over.
    fn round(&mut self) -> Result<bool, PlannerError> {
        let over = matches!(self.turn_of_sim(), Turn::Leave(_));
        self.turn_of_perception();
        if over {
            return Ok(true);
        }
        while let Some(fallback) = self.due_fallback() {
            // Nobody commanded it: the planner does not even see its state.
            self.bus.look_at_clock();
            block_on(self.sim.repeat(fallback, &mut self.ports[0])).expect("direct ports always have room");
            self.turn_of_perception();
        }
        self.hand_over()?;
        self.bus.look_at_clock();
        done(block_on(self.planner.turn(&mut self.ports[2])));
        Ok(false)
    }

    fn turn_of_sim(&mut self) -> Turn {
        self.bus.look_at_clock();
        done(block_on(self.sim.turn(&mut self.ports[0])))
    }

    fn turn_of_perception(&mut self) {
        done(block_on(self.perception.turn(&mut self.ports[1])));
    }

    /// What the fallback did at the decision that is due, once its landing is mapped.
    fn due_fallback(&mut self) -> Option<Fallback> {
        let state = self.sim.arbiter().state();
        let mapped = self.perception.cartographer().map().and_then(|map| map.through);
        let due = mapped == Some(state.decision) && !state.status.is_over();
        if due { self.fallbacks.remove(&state.decision) } else { None }
    }

    /// Hands over to the next planner of the schedule if its first decision is due.
    fn hand_over(&mut self) -> Result<(), PlannerError> {
        let decision = self.sim.arbiter().state().decision;
        let Some(next) = self.planners.first_entry().filter(|next| *next.key() <= decision) else {
            return Ok(());
        };
        let name = next.remove();
        self.lives += 1;
        let planner = algorithm(name, self.sim.arbiter().mission())?;
        self.ports[2] = self.bus.ports(Incarnation(self.lives));
        let joined =
            block_on(PlannerProcess::join(&mut self.ports[2], planner, TAKES_OVER, Terms::default()));
        self.planner = joined.expect("direct ports always open");
        Ok(())
    }
}

const TAKES_OVER: Claim = Claim { takeover: true, succeeds_pid: None };

fn done(turn: Result<Turn, Failure>) -> Turn {
    turn.unwrap_or_else(|failure| panic!("a process in lockstep fails: {failure}"))
}

/// A fresh planner by name; here alone, where one thread holds the truth anyway, also the clairvoyant.
fn algorithm(name: Name, mission: &Mission) -> Result<Box<dyn Planner>, PlannerError> {
    if name.as_str() != planner::CLAIRVOYANT {
        return planner::algorithm(name.as_str());
    }
    if mission.brief.patrol.is_some() {
        return Err(PlannerError::Unsuited {
            reason: "the clairvoyant plans for one goal, not for a patrol".into(),
        });
    }
    let clairvoyant = clairvoyant::Clairvoyant::new(&mission.brief, &mission.terrain);
    let unsuited =
        |error: clairvoyant::ClairvoyantError| PlannerError::Unsuited { reason: error.to_string() };
    Ok(Box::new(clairvoyant.map_err(unsuited)?))
}
