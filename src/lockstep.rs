//! The processes' own state machines in one thread: direct calls, no faults, no shared memory.
//!
//! A mission flown here has the digest of the same mission flown by four processes, bit for bit. No time
//! passes here, so no deadline does: a mission in which the guard's fallback acted is repeated by its journal.

use std::collections::{BTreeMap, VecDeque};

use contract::{
    Command, Decision, Incarnation, MapPatch, MonotonicNs, Name, ObservedMap, PolicyCell, Record, Refusal,
    RefusalCounts, RobotId, State,
};
use hopper_sim::{Arbiter, Fallback, Mission, Pace};
use perception::Cartographer;
use planner::pilot::{Commission, Pilot};
use planner::{Budget, Planner, PlannerError};

/// Who commands from which decision on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shift {
    /// First decision of the shift.
    pub from: Decision,
    /// Algorithm in command.
    pub planner: Name,
}

/// The whole roster of shifts, the first from decision 0, and what the fallback did between them.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Crew {
    shifts: Vec<Shift>,
    fallbacks: BTreeMap<Decision, Fallback>,
}

impl Crew {
    /// One algorithm from start to end.
    #[must_use]
    pub fn single(planner: Name) -> Self {
        Self { shifts: vec![Shift { from: Decision(0), planner }], ..Self::default() }
    }

    /// The shifts and fallbacks that a journal's records tell of.
    pub fn from_records<E>(records: impl Iterator<Item = Result<Record, E>>) -> Result<Self, E> {
        let Self { mut shifts, mut fallbacks } = Self::default();
        for record in records {
            let record = record?;
            let Record { decision, action, origin, .. } = record;
            if origin.is_fallback() {
                fallbacks.insert(decision, Fallback { action, origin });
                continue;
            }
            let planner = record.leader.planner;
            if shifts.last().is_none_or(|last| last.planner != planner) {
                shifts.push(Shift { from: record.decision, planner });
            }
        }
        Ok(Self { shifts, fallbacks })
    }

    /// The shifts in order.
    #[must_use]
    pub fn shifts(&self) -> &[Shift] {
        &self.shifts
    }

    /// What the fallback did, by decision.
    #[must_use]
    pub fn fallbacks(&self) -> &BTreeMap<Decision, Fallback> {
        &self.fallbacks
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
/// If a shift names an unknown algorithm.
///
/// # Panics
/// If the machines stall, which would be a defect of the protocol.
pub fn fly(
    mission: Mission,
    crew: &Crew,
    clock: &mut dyn FnMut() -> MonotonicNs,
    observe: &mut dyn FnMut(&Record),
) -> Result<Flown, PlannerError> {
    let mut host = Host::new(mission, crew, clock(), observe)?;
    let now = clock();
    host.arbitrate(hopper_sim::Event::Tick, now);
    while let Some(message) = host.inbox.pop_front() {
        host.deliver(message, clock)?;
    }
    let state = *host.arbiter.state();
    assert!(state.status.is_over(), "lockstep stalled at decision {}", state.decision);
    Ok(Flown {
        state,
        map: host.cartographer.map().expect("a flown mission has a map").clone(),
        policy: host.planner.policy(),
        refusals: host.arbiter.refusals().clone(),
    })
}

/// What is on its way from one machine to another.
enum Message {
    State(State),
    Patch(MapPatch),
    Command(Command),
}

struct Host<'a> {
    arbiter: Arbiter,
    cartographer: Cartographer,
    pilot: Pilot,
    planner: Box<dyn Planner>,
    crew: VecDeque<Shift>,
    fallbacks: BTreeMap<Decision, Fallback>,
    lives: u64,
    inbox: VecDeque<Message>,
    observe: &'a mut dyn FnMut(&Record),
}

impl<'a> Host<'a> {
    fn new(
        mission: Mission,
        crew: &Crew,
        now: MonotonicNs,
        observe: &'a mut dyn FnMut(&Record),
    ) -> Result<Self, PlannerError> {
        let fallbacks = crew.fallbacks.clone();
        let mut crew: VecDeque<Shift> = crew.shifts.iter().cloned().collect();
        let first = crew.pop_front().map_or_else(|| "hold".parse().expect("a name"), |shift| shift.planner);
        let mut cartographer = Cartographer::new(RobotId(0));
        let (brief, terrain) = (mission.brief, mission.terrain.clone());
        cartographer.on(perception::Event::Terrain(brief.run, terrain), now);
        cartographer.on(perception::Event::Brief(brief), now);
        let planner = enlist(first, &mission)?;
        let mut host = Self {
            arbiter: Arbiter::new(mission, None, Pace::Max, 0, now),
            cartographer,
            pilot: Pilot::new(commission(first, 1)),
            planner,
            crew,
            fallbacks,
            lives: 1,
            inbox: VecDeque::new(),
            observe,
        };
        host.pilot.on(planner::pilot::Event::Brief(brief), now);
        Ok(host)
    }

    fn deliver(
        &mut self,
        message: Message,
        clock: &mut dyn FnMut() -> MonotonicNs,
    ) -> Result<(), PlannerError> {
        match message {
            Message::State(state) => {
                self.relieve(state.decision, clock())?;
                match self.fallbacks.remove(&state.decision) {
                    // Nobody commanded it: the pilot does not even hear of it.
                    Some(fallback) => self.arbitrate(hopper_sim::Event::Repeat(fallback), clock()),
                    None => self.fly(planner::pilot::Event::State(state), clock),
                }
                for effect in self.cartographer.on(perception::Event::State(state), clock()) {
                    if effect == perception::Effect::PublishMap {
                        let sensed = clock();
                        let patches = self.cartographer.patches(sensed, clock);
                        self.inbox.extend(patches.into_iter().map(Message::Patch));
                    }
                }
            }
            Message::Patch(patch) => self.fly(planner::pilot::Event::Patch(patch), clock),
            Message::Command(command) => self.arbitrate(hopper_sim::Event::Command(Ok(command)), clock()),
        }
        Ok(())
    }

    /// Hands over to the next shift if it begins at `decision`.
    fn relieve(&mut self, decision: Decision, now: MonotonicNs) -> Result<(), PlannerError> {
        let Some(shift) = self.crew.pop_front_if(|shift| shift.from <= decision) else { return Ok(()) };
        self.lives += 1;
        self.planner = enlist(shift.planner, self.arbiter.mission())?;
        self.pilot = Pilot::new(commission(shift.planner, self.lives));
        self.pilot.on(planner::pilot::Event::Brief(self.arbiter.mission().brief), now);
        Ok(())
    }

    fn fly(&mut self, event: planner::pilot::Event, clock: &mut dyn FnMut() -> MonotonicNs) {
        let mut effects: VecDeque<_> = self.pilot.on(event, clock()).into();
        while let Some(effect) = effects.pop_front() {
            match effect {
                planner::pilot::Effect::Plan => {
                    let Some(situation) = self.pilot.situation() else { continue };
                    let started = clock();
                    let plan = self.planner.plan(&situation, &Budget::default());
                    let ended = clock();
                    let planned = planner::pilot::Event::Planned(plan, started, ended);
                    effects.extend(self.pilot.on(planned, ended));
                }
                planner::pilot::Effect::RequestMap(request) => {
                    // Unanswered, it is the next patch that will be asked about.
                    if let Some(page) = self.cartographer.page(&request) {
                        effects.extend(self.pilot.on(planner::pilot::Event::Page(page), clock()));
                    }
                }
                planner::pilot::Effect::Send(command) => self.inbox.push_back(Message::Command(command)),
                _ => {}
            }
        }
    }

    fn arbitrate(&mut self, event: hopper_sim::Event, now: MonotonicNs) {
        let mut effects: VecDeque<_> = self.arbiter.on(event, now).into();
        while let Some(effect) = effects.pop_front() {
            match effect {
                hopper_sim::Effect::Append(record) => {
                    (self.observe)(&record);
                    effects.extend(self.arbiter.on(hopper_sim::Event::Appended, now));
                }
                hopper_sim::Effect::Publish(state) => self.inbox.push_back(Message::State(state)),
                hopper_sim::Effect::Refused(Refusal::RepeatedDecision { .. } | Refusal::Vetoed { .. }) => {}
                hopper_sim::Effect::Refused(refusal) => debug_assert!(false, "lockstep refused: {refusal}"),
                hopper_sim::Effect::Announce | hopper_sim::Effect::Finished(_) => {}
            }
        }
    }
}

/// A fresh planner by name; here alone, where one thread holds the truth anyway, also the clairvoyant.
fn enlist(name: Name, mission: &Mission) -> Result<Box<dyn Planner>, PlannerError> {
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

fn commission(planner: Name, life: u64) -> Commission {
    Commission {
        robot: RobotId(0),
        incarnation: Incarnation(life),
        pid: 0,
        planner,
        takeover: true,
        succeeds_pid: None,
    }
}
