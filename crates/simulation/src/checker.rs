//! Compares everything that happens with the promises, and influences nothing.
//!
//! The checker knows the truth, the journal's bytes and every message. It computes what should be true by
//! itself where it can: outcomes by executing the command again, seen cells from the sensor's formula.

mod acquaintance;
mod commands;
mod dependence;
mod guard;
mod journal;
mod known;
mod maps;
mod monitors;
mod own_way;
mod pace;
mod pacing;
mod routes;
mod seen_maps;
mod succession;

use std::collections::{BTreeMap, BTreeSet};

use contract::{
    Action, Decision, Digest, Heartbeat, Incarnation, Leader, MonotonicNs, Name, Pace, Pose, Record, RobotId,
    RunId, State, Status, Term,
};
use hopper_sim::{Arbiter, Mission};

pub(crate) use self::known::Known;

use self::acquaintance::Acquaintance;
use self::dependence::Dependence;
use self::pacing::Pacing;
use self::seen_maps::SeenMaps;
use self::succession::Succession;
use crate::chance::Chance;
use crate::claims::Claims;
use crate::coverage::Coverage;
use crate::expected::first_digest;
use crate::life::Life;
use crate::model::{Counter, Model};
use crate::offers::Offers;
use crate::play::Play;
use crate::reservation::Reservations;
use crate::setup::{self, Missions, Setup};
use crate::violation::Violation;

/// What a command is known by.
type Sent = (RunId, RobotId, Incarnation, Decision, Digest, Term, u32, u64);

/// Sees every message, every commit and every reader's map, and holds them to the promises.
#[derive(Debug)]
pub(crate) struct Checker {
    mission: Mission,
    opening: State,
    records: Vec<Record>,
    /// All robots after those records.
    model: Box<dyn Model>,
    succession: Succession,
    sent: BTreeSet<Sent>,
    maps: SeenMaps,
    /// Records that the journal held once: after the digest of each, what a reader may still take for true.
    lost: BTreeMap<Digest, (Decision, Pose, u64)>,
    acquaintance: Acquaintance,
    reservations: Reservations,
    dependence: Dependence,
    offers: Offers,
    claims: Claims,
    /// The landing up to which perception has published the map.
    mapped: Option<(RunId, Decision)>,
    /// The robot that acted last, and the routes that it has announced since any robot did anything else.
    announcements: (RobotId, u64),
    /// The last policy that hopper-sim has received.
    policy: Option<(RunId, Name, Decision)>,
    /// The present life of hopper-sim.
    sim: Incarnation,
    pacing: Pacing,
    violation: Option<Violation>,
}

impl Checker {
    /// Checks the first mission of `setup` from its start, by its model.
    #[must_use]
    pub fn new(setup: &Setup, model: Box<dyn Model>) -> Self {
        Self::of(&setup.mission, model, Pacing::begin(setup.control, setup.pace))
    }

    fn of(mission: &Mission, model: Box<dyn Model>, pacing: Pacing) -> Self {
        let start = *Arbiter::new(mission.clone(), None, Pace::Max, 0, MonotonicNs(0)).state();
        let opening = State { digest: first_digest(&mission.brief, mission.seed), ..start };
        let mut checker = Self {
            opening,
            records: Vec::new(),
            model,
            succession: Succession::default(),
            sent: BTreeSet::new(),
            maps: SeenMaps::unseen(&mission.brief),
            lost: BTreeMap::new(),
            acquaintance: Acquaintance::default(),
            reservations: Reservations::default(),
            dependence: Dependence::default(),
            offers: Offers::default(),
            claims: Claims::default(),
            mapped: None,
            announcements: (RobotId(0), 0),
            policy: None,
            sim: Incarnation(0),
            pacing,
            violation: None,
            mission: mission.clone(),
        };
        checker.model.see(None, &mut checker.maps.expected);
        checker.maps.mapped_at(opening.digest);
        checker
    }

    /// Another mission begins; what was seen of the old one stays valid for its stragglers.
    pub fn begin(&mut self, mission: &Mission) {
        let new = Self::of(mission, self.model.anew(mission), self.pacing.clone());
        let old = std::mem::replace(self, new);
        self.sent = old.sent;
        self.maps.keep(old.maps);
        self.acquaintance = old.acquaintance;
        self.reservations = old.reservations;
        self.dependence = old.dependence;
        self.offers = old.offers;
        self.sim = old.sim;
        self.violation = old.violation;
    }

    /// What was violated first, if anything was.
    #[must_use]
    pub fn violation(&self) -> Option<&Violation> {
        self.violation.as_ref()
    }

    /// The one that all processes are to fly.
    #[must_use]
    pub fn mission(&self) -> &Mission {
        &self.mission
    }

    /// The run of that mission.
    pub(crate) fn run(&self) -> RunId {
        self.mission.brief.run
    }

    /// Every record of the run so far.
    #[must_use]
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// How the mission stands.
    #[must_use]
    pub fn status(&self) -> Status {
        self.records.last().map_or(self.opening.status, |record| record.status)
    }

    /// All robots after the records so far.
    pub(crate) fn model(&self) -> &dyn Model {
        &*self.model
    }

    /// Rare events that `record` shows, which is about to be committed.
    pub(crate) fn events(&self, missions: Missions, record: &Record) -> Vec<Counter> {
        self.model.events(missions, record, &self.records)
    }

    /// Whose turn it is.
    pub(crate) fn due(&self) -> RobotId {
        self.model.due()
    }

    /// An action of the robot that is due which the guard should veto.
    pub(crate) fn blocked_action(&self) -> Option<Action> {
        self.model.blocked_action()
    }

    /// Who commands the robot that is due.
    #[must_use]
    pub fn leader(&self) -> Leader {
        self.leader_of(self.due())
    }

    /// Who commands a robot.
    pub(crate) fn leader_of(&self, robot: RobotId) -> Leader {
        self.model.leader(robot)
    }

    /// Takes note of a violation; the first counts.
    pub fn violate(&mut self, rule: &'static str, detail: impl FnOnce() -> String) {
        if self.violation.is_none() {
            self.violation = Some(Violation { rule, detail: detail() });
        }
    }

    fn require(&mut self, holds: bool, rule: &'static str, detail: impl FnOnce() -> String) {
        if !holds {
            self.violate(rule, detail);
        }
    }

    pub(crate) fn digest(&self) -> Digest {
        self.records.last().map_or(self.opening.digest, |record| record.digest)
    }

    /// The state that should be known to the world at `decision`.
    fn state_at(&self, decision: Decision) -> Option<State> {
        let Some(index) = decision.0.checked_sub(1) else { return Some(self.opening) };
        let record = self.records.get(index as usize)?;
        Some(record.state_after(self.mission.brief.run, MonotonicNs(0), MonotonicNs(0)))
    }

    /// Plays some decisions on a copy of the arbiter, if nothing is under way.
    pub(crate) fn play(
        &mut self,
        arbiter: &Arbiter,
        chance: &mut Chance,
        coverage: &mut Coverage,
        now: MonotonicNs,
    ) {
        let state = arbiter.state();
        let rests = state.decision.0 == self.records.len() as u64 && !self.pacing.tempo.is_flying();
        if !rests
            || self.pacing.tempo.paused
            || self.reservations.unsure
            || state.run != self.mission.brief.run
        {
            return;
        }
        let chance = Chance::new(chance.bits(), "play");
        if let Some(violation) =
            Play::new(&self.mission, arbiter, self.model.copy(), chance, now).run(coverage)
        {
            self.violate(violation.rule, || violation.detail);
        }
    }

    /// The hop of `record`, which was committed, is in the air.
    pub(crate) fn launched(&mut self, record: &Record, now: MonotonicNs) {
        let lasts_ns = self.model.lasts_ns(&record.outcome);
        self.pacing.tempo.committed(lasts_ns, now);
    }

    /// A process of another build begins to live.
    pub(crate) fn foreign_started(&mut self, incarnation: Incarnation) {
        self.acquaintance.foreign.insert(incarnation);
    }

    /// Whether a version is that of this build.
    pub(crate) fn is_own(&self, version: Name) -> bool {
        version == setup::version()
    }

    /// A planner publishes its policy.
    pub(crate) fn policy_published(&mut self, readers: usize) {
        self.require(readers > 0, "policies are made for readers alone", || "nobody reads them".into());
    }

    /// A process has heard that another lives.
    pub(crate) fn heard(&mut self, listener: &Life, beat: &Heartbeat, now: MonotonicNs) {
        self.acquaintance.heard(listener, beat, now);
    }
}
