//! The processes one after the other in one thread: direct calls, no faults, no shared memory.
//!
//! A mission flown here has the digest of the same mission flown by four processes, bit for bit. No time
//! passes here, so no deadline does: a mission in which the guard's fallback acted is repeated by its journal.
//!
//! ```
//! use contract::{MonotonicNs, Status};
//! use lockstep::{Mission, PlannerSchedule, fly};
//!
//! let world = scenario::load("hard")?.resolve()?;
//! let mission = Mission::of(&world, 3);
//! let schedule = PlannerSchedule::single("mdp".parse()?);
//! let mut hops = 0;
//! let flown = fly(mission, &schedule, &mut MonotonicNs::default, &mut |_record| hops += 1)?;
//! assert_eq!(flown.state.status, Status::Goal);
//! assert_eq!(flown.state.decision.0, hops);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(clippy::disallowed_methods)]

mod flight;
mod ports;
mod records;

use std::collections::BTreeMap;

use contract::{
    Account, Action, Decision, Detail, MonotonicNs, Name, ObservedMap, PolicyCell, Record, RefusalCounts,
    RobotId, RobotSet, Route, State, Team,
};
use hopper_sim::{Attachment, Fallback};
use planner::{Planner, PlannerError};
use tracing::subscriber::{NoSubscriber, with_default};

pub use hopper_sim::Mission;

pub use flight::{Flight, Hooks, Tempo};
pub use ports::{Clock, DirectPorts};

/// Rounds without a decision after which lockstep has stalled; the pages of the largest map take a few hundred.
const ROUNDS_MAX: u64 = 3_000;

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

    /// One algorithm after the other for all robots, each from its decision on, in the order of these.
    #[must_use]
    pub fn in_turn(turnovers: &[(Decision, Name)]) -> Self {
        let successor =
            |&(from, planner): &(Decision, Name)| Successor { from, robots: RobotSet::ALL, planner };
        Self { planners: turnovers.iter().map(successor).collect(), ..Self::default() }
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
    /// All robots after the last decision; `None` where there is a single hopper.
    pub team: Option<Team>,
    /// The map at the end.
    pub map: ObservedMap,
    /// Policy behind the last decision, if its planner has one.
    pub policy: Option<Vec<PolicyCell>>,
    /// What the arbiter refused; nothing, unless something is wrong.
    pub refusals: RefusalCounts,
    /// The routes that robots announced, in no order.
    pub routes: Vec<Route>,
    /// What the motion model told of decisions, in their order; nothing under the law.
    pub details: Vec<(Decision, Detail)>,
}

impl Flown {
    /// What `record` of this mission names.
    #[must_use]
    pub fn attachment(&self, record: &Record) -> Option<Attachment> {
        let detail = self.details.binary_search_by_key(&record.decision, |(decision, _)| *decision).ok();
        let route = self.routes.iter().find(|route| record.action == Action::Announce(route.id()));
        let detail = detail.map(|at| Attachment::Detail(self.details[at].1.clone()));
        detail.or_else(|| route.cloned().map(Attachment::Route))
    }
}

/// Flies `mission` to its end, telling `observe` of each executed decision.
///
/// `clock` is read for the timing of decisions only; no result depends on it.
///
/// # Errors
/// If the schedule names an unknown algorithm, or the mission stands still: a planner does not suit it, or insists on what is
/// refused.
///
/// # Panics
/// If a process fails, which would be a defect of the protocol.
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
/// The first error of `make`, or if the mission stands still.
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
    let hooks = Hooks { make: Box::new(make), clock: Box::new(clock), observe: Box::new(observe) };
    let mut flight = Flight::begin(mission, schedule, Tempo::default(), hooks)?;
    let mut rounds = 0;
    let mut decision = Decision(0);
    while !flight.round()? {
        rounds += 1;
        let reached = flight.state().decision;
        if reached > decision {
            (rounds, decision) = (0, reached);
        }
        if rounds == ROUNDS_MAX {
            return Err(PlannerError::StandsStill { decision, reason: flight.why_it_stands_still() });
        }
    }
    let refusals = flight.arbiter().refusals().clone();
    let expected: u64 =
        ["repeated_decision", "vetoed", "occupied"].map(|reason| refusals.of(reason)).iter().sum();
    debug_assert_eq!(
        refusals.0.values().sum::<u64>(),
        expected,
        "lockstep refuses only what is repeated or vetoed"
    );
    Ok(Flown {
        state: *flight.state(),
        team: flight.arbiter().team().cloned(),
        policy: flight.policy(),
        refusals,
        routes: flight.routes(),
        details: flight.details(),
        map: flight.into_map().expect("a flown mission has a map"),
    })
}

/// A fresh planner by name; here alone, where one thread holds the truth anyway, also the clairvoyant.
///
/// # Errors
/// If there is none of that name, or it does not suit the mission.
pub fn algorithm(name: Name, mission: &Mission) -> Result<Box<dyn Planner>, PlannerError> {
    if name.as_str() != planner::CLAIRVOYANT {
        return planner::algorithm(name.as_str());
    }
    let unsuited = |reason: &str| PlannerError::Unsuited { reason: reason.into() };
    if mission.brief.account != Account::Hopper {
        return Err(unsuited("the clairvoyant plans for the mission of one hopper"));
    }
    if mission.brief.visits().is_some() {
        return Err(unsuited("the clairvoyant plans for one goal, not for a patrol"));
    }
    let clairvoyant =
        clairvoyant::Clairvoyant::new(&mission.brief.leg(0), &mission.terrain, mission.table.as_deref());
    Ok(Box::new(clairvoyant.map_err(|error| unsuited(&error.to_string()))?))
}
