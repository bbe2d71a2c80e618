//! The processes one after the other in one thread: direct calls, no faults, no shared memory.
//!
//! A mission flown here has the digest of the same mission flown by four processes, bit for bit. No time
//! passes here, so no deadline does: a mission in which the guard's fallback acted is repeated by its journal.

#![warn(clippy::disallowed_methods)]

mod ports;

use std::collections::{BTreeMap, VecDeque};

use contract::limits::PAST_PAGE_RECORDS;
use contract::{
    Decision, Incarnation, MonotonicNs, Name, ObservedMap, PastPage, PolicyCell, Record, RefusalCounts,
    RobotId, RobotSet, Route, RunId, State,
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
    /// In the order of their first decisions.
    planners: Vec<Successor>,
    fallbacks: BTreeMap<Decision, Fallback>,
}

/// Who commands which robots from a decision on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Successor {
    from: Decision,
    robots: RobotSet,
    planner: Name,
}

impl PlannerSchedule {
    /// One algorithm from start to end, for all robots.
    #[must_use]
    pub fn single(planner: Name) -> Self {
        let first = Successor { from: Decision(0), robots: RobotSet::ALL, planner };
        Self { planners: vec![first], ..Self::default() }
    }

    /// An algorithm from start to end for each robot, in the order of their numbers.
    #[must_use]
    pub fn of_robots(planners: &[Name]) -> Self {
        let mut schedule = Self::default();
        for (robot, planner) in (0..).map(RobotId).zip(planners) {
            match schedule.planners.iter_mut().find(|hosted| hosted.planner == *planner) {
                Some(hosted) => hosted.robots = hosted.robots.with(robot),
                None => {
                    let robots = RobotSet(0).with(robot);
                    schedule.planners.push(Successor { from: Decision(0), robots, planner: *planner });
                }
            }
        }
        schedule
    }

    /// The planners of `records`, each relieved by a fresh one of its own algorithm at every decision of its robot.
    #[must_use]
    pub fn relieved(records: &[Record]) -> Self {
        let successor = |record: &Record| Successor {
            from: record.decision,
            robots: RobotSet(0).with(record.robot),
            planner: record.leader.planner,
        };
        Self { planners: records.iter().map(successor).collect(), ..Self::default() }
    }

    /// The schedule that a journal's records show. A planner that is followed by another of the same algorithm, under
    /// another term, is one entry.
    ///
    /// # Errors
    /// The first error of `records`.
    pub fn from_records<E>(records: impl Iterator<Item = Result<Record, E>>) -> Result<Self, E> {
        let Self { mut planners, mut fallbacks } = Self::default();
        let mut commands = BTreeMap::<RobotId, Name>::new();
        for record in records {
            let Record { robot, decision, action, origin, leader, .. } = record?;
            if origin.is_fallback() {
                fallbacks.insert(decision, Fallback { action, origin });
            } else if commands.insert(robot, leader.planner) != Some(leader.planner) {
                let robots = RobotSet(0).with(robot);
                planners.push(Successor { from: decision, robots, planner: leader.planner });
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
    /// After the last decision; its status is over.
    pub state: State,
    /// The map at the end.
    pub map: ObservedMap,
    /// Policy behind the last decision, if its planner has one.
    pub policy: Option<Vec<PolicyCell>>,
    /// What the arbiter refused; nothing, unless something is wrong.
    pub refusals: RefusalCounts,
    /// The routes that robots announced, in no order.
    pub routes: Vec<Route>,
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
    fly_with(mission, schedule, &mut algorithm, clock, observe)
}

/// Returns a fresh planner of the name that a schedule asks for.
pub type Make<'m> = &'m mut dyn FnMut(Name, &Mission) -> Result<Box<dyn Planner>, PlannerError>;

/// As [`fly`], with the planners that `make` returns in place of those that come with Hopper.
///
/// # Errors
/// The first error of `make`.
///
/// # Panics
/// As [`fly`].
pub fn fly_with(
    mission: Mission,
    schedule: &PlannerSchedule,
    make: Make<'_>,
    clock: &mut dyn FnMut() -> MonotonicNs,
    observe: &mut dyn FnMut(&Record),
) -> Result<Flown, PlannerError> {
    // What the processes log belongs to processes: a campaign flies a thousand missions a second.
    with_default(NoSubscriber::default(), || fly_silently(mission, schedule, make, clock, observe))
}

fn fly_silently(
    mission: Mission,
    schedule: &PlannerSchedule,
    make: Make<'_>,
    clock: &mut dyn FnMut() -> MonotonicNs,
    observe: &mut dyn FnMut(&Record),
) -> Result<Flown, PlannerError> {
    let bus = Bus::new(clock);
    let mut host = Host::join(&bus, mission, schedule, (make, observe))?;
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
    let expected: u64 =
        ["repeated_decision", "vetoed", "occupied"].map(|reason| refusals.of(reason)).iter().sum();
    debug_assert_eq!(
        refusals.0.values().sum::<u64>(),
        expected,
        "lockstep refuses only what is repeated or vetoed"
    );
    Ok(Flown {
        state: *host.sim.arbiter().state(),
        map: host.perception.cartographer().map().expect("a flown mission has a map").clone(),
        policy: host.planners.last_mut().and_then(|hosted| hosted.process.planner().policy()),
        refusals,
        routes: host.routes(),
    })
}

/// Records go nowhere: what lockstep flies can be flown again. They are kept only where robots go from point to point,
/// since perception then folds records.
struct Records {
    run: RunId,
    is_kept: bool,
    kept: Vec<Record>,
}

impl RecordStore for Records {
    fn run(&self) -> RunId {
        self.run
    }

    fn append(&mut self, record: &Record) -> Result<(), JournalError> {
        if self.is_kept {
            self.kept.push(*record);
        }
        Ok(())
    }

    fn page(&self, from: Decision) -> Result<PastPage, JournalError> {
        let kept = self.kept.iter().skip(from.0 as usize).take(PAST_PAGE_RECORDS);
        Ok(PastPage { run: self.run, robot: RobotId(0), from, records: kept.copied().collect() })
    }
}

type Observe<'a> = &'a mut dyn FnMut(&Record);

/// The processes of one mission.
struct Host<'b, 'c, 'o> {
    bus: &'b Bus<'c>,
    sim: HopperSim<DirectPorts<'b, 'c>, Records, Observe<'o>>,
    perception: Perception<DirectPorts<'b, 'c>>,
    planners: Vec<HostedPlanner<'b, 'c>>,
    make: Make<'o>,
    /// Those of hopper-sim and perception.
    ports: [DirectPorts<'b, 'c>; 2],
    /// Who commands later.
    successors: VecDeque<Successor>,
    fallbacks: BTreeMap<Decision, Fallback>,
    lives: u64,
}

/// A planner with its ports.
struct HostedPlanner<'b, 'c> {
    robots: RobotSet,
    process: PlannerProcess<DirectPorts<'b, 'c>>,
    ports: DirectPorts<'b, 'c>,
}

impl<'b, 'c> HostedPlanner<'b, 'c> {
    fn join(bus: &'b Bus<'c>, life: u64, robots: RobotSet, planner: Box<dyn Planner>) -> Self {
        let mut ports = bus.ports(Incarnation(life));
        let claim = Claim { robots, takeover: true, succeeds_pid: None };
        let process = block_on(PlannerProcess::join(&mut ports, planner, claim, Terms::default()));
        Self { robots, process: process.expect("direct ports always open"), ports }
    }
}

impl<'b, 'c, 'o> Host<'b, 'c, 'o> {
    fn join(
        bus: &'b Bus<'c>,
        mission: Mission,
        schedule: &PlannerSchedule,
        (make, observe): (Make<'o>, Observe<'o>),
    ) -> Result<Self, PlannerError> {
        let PlannerSchedule { planners, fallbacks } = schedule.clone();
        let mut successors = VecDeque::from(planners);
        let nobody = || Successor {
            from: Decision(0),
            robots: RobotSet::ALL,
            planner: "hold".parse().expect("a name"),
        };
        let first = successors.pop_front().unwrap_or_else(nobody);
        let robots = first.robots.of(mission.brief.robots);
        let planner = make(first.planner, &mission)?;
        let terms = SimTerms {
            pace: Pace::Max,
            linger_ns: 0,
            control: false,
            deadlines: false,
            terms: Terms::default(),
        };
        let brief = &mission.brief;
        let records = Records { run: brief.run, is_kept: brief.scout.is_some(), kept: Vec::new() };
        bus.look_at_clock();
        let mut ports = [1, 2].map(|life| bus.ports(Incarnation(life)));
        let [of_sim, of_perception] = &mut ports;
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
            planners: vec![HostedPlanner::join(bus, 3, robots, planner)],
            make,
            ports,
            successors,
            fallbacks,
            lives: 3,
        })
    }

    /// The routes that robots announced.
    fn routes(&self) -> Vec<Route> {
        self.sim.arbiter().routes().cloned().collect()
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
        for HostedPlanner { process, ports, .. } in &mut self.planners {
            done(block_on(process.turn(ports)));
        }
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

    /// Hands over to the next planners of the schedule if their first decision is due.
    fn hand_over(&mut self) -> Result<(), PlannerError> {
        let decision = self.sim.arbiter().state().decision;
        while let Some(next) = self.successors.pop_front_if(|next| next.from <= decision) {
            let mission = self.sim.arbiter().mission();
            let robots = next.robots.of(mission.brief.robots);
            let planner = (self.make)(next.planner, mission)?;
            self.lives += 1;
            // Whoever commands other robots too goes on with them.
            self.planners.retain(|hosted| hosted.robots != robots);
            self.planners.push(HostedPlanner::join(self.bus, self.lives, robots, planner));
        }
        Ok(())
    }
}

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
