//! Which moment each stamp should name, as the world saw it pass.
//!
//! Digests leave stamps out, so nothing else would notice one that is taken from another moment, another robot or another
//! process, or that changes when a message is sent again. What is expected here comes from virtual time alone: when a
//! message was first published, when a computation began, when an append was over.

use std::collections::{BTreeMap, BTreeSet};

use contract::mission::pace::Launch;
use contract::{
    Command, Decision, Digest, Incarnation, MapPage, MapPatch, MonotonicNs, Pace, Record, RobotId, RunId,
    State, Timing,
};
use recording::RecordedMessage;

/// Where a message stands in the digest chain.
type At = (RunId, Decision, Digest);

/// What a life of hopper-sim has done.
#[derive(Clone, Copy, Debug, Default)]
struct Sim {
    /// The state that it published last, as it was first published.
    told: Option<State>,
    /// When it received a command last.
    heard: MonotonicNs,
    /// The decision whose command it accepted last, and when it first did.
    accepted: Option<(Decision, MonotonicNs)>,
    /// What it appended last, with the moment at which that was over.
    appended: Option<Record>,
}

/// What a life of perception has done.
#[derive(Clone, Copy, Debug)]
struct Mapper {
    /// When the last landing was folded in.
    sensed: MonotonicNs,
    /// The landing that it published last, with its two moments.
    told: Option<(At, MonotonicNs, MonotonicNs)>,
    /// Whether the journal was replaced or another run was heard of since, so that it may map the same landing anew.
    may_begin_anew: bool,
}

impl Mapper {
    fn at(now: MonotonicNs) -> Self {
        Self { sensed: now, told: None, may_begin_anew: false }
    }
}

/// A plan of a life of a planner.
#[derive(Clone, Copy, Debug)]
struct Planned {
    /// When the map that the plan was given was sensed.
    sensed: MonotonicNs,
    map_published: MonotonicNs,
    started: MonotonicNs,
    ended: MonotonicNs,
}

impl Planned {
    fn moments(&self) -> [MonotonicNs; 4] {
        [self.sensed, self.map_published, self.started, self.ended]
    }

    fn is_of(&self, command: &Command) -> bool {
        self.moments()
            == [command.sensed, command.map_published, command.planning_started, command.planning_ended]
    }
}

/// A landing of the mission, as the journal and its states tell of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Landing {
    /// The robot whose turn it was.
    pub robot: RobotId,
    /// The times in the journal, in which the commit is the moment at which the append was
    /// requested.
    pub journalled: Timing,
    /// With the true moment of the commit; `None` if nobody lived to see it.
    pub committed: Option<MonotonicNs>,
}

impl Landing {
    /// The timings that others may have of it.
    pub fn timings(&self) -> impl Iterator<Item = Timing> + '_ {
        let true_one = self.committed.map(|committed| Timing { committed, ..self.journalled });
        [Some(self.journalled), true_one].into_iter().flatten()
    }
}

/// The moments of a simulation.
#[derive(Debug, Default)]
pub(crate) struct Stamps {
    sims: BTreeMap<Incarnation, Sim>,
    mappers: BTreeMap<Incarnation, Mapper>,
    /// The moments under which a landing was published, by any life of perception.
    mapped: BTreeMap<At, BTreeSet<[MonotonicNs; 2]>>,
    plans: BTreeMap<(Incarnation, At), Planned>,
    /// What each planner plans at present.
    planning: BTreeMap<Incarnation, At>,
    /// Commands that were sent, by who sent them, what they answer, and the robot.
    sent: BTreeMap<(Incarnation, At, RobotId), Vec<Planned>>,
    landings: BTreeMap<Digest, Landing>,
    /// The moments under which each state was published, by any life of hopper-sim.
    told: BTreeMap<At, BTreeSet<[MonotonicNs; 2]>>,
    /// Whether decisions were flown again that others may hold as they were flown before.
    is_flown_again: bool,
}

/// What a stamp is called in a violation.
fn named(what: &str, at: Decision, need: impl std::fmt::Debug, got: impl std::fmt::Debug) -> String {
    format!("{what} of decision {at} is {got:?}, needs {need:?}")
}

fn same<T: PartialEq + std::fmt::Debug>(what: &str, at: Decision, need: T, got: T) -> Result<(), String> {
    if need == got { Ok(()) } else { Err(named(what, at, need, got)) }
}

impl Stamps {
    /// The journal was replaced, or lost its tail: what was mapped may be built anew.
    pub fn rewound(&mut self) {
        self.mappers.values_mut().for_each(|mapper| mapper.may_begin_anew = true);
        self.is_flown_again = true;
    }

    /// A life of perception hears of a run: another than that of its map makes it begin anew, and come back later.
    pub fn briefed(&mut self, life: Incarnation, run: RunId) {
        if let Some(mapper) = self.mappers.get_mut(&life) {
            mapper.may_begin_anew |= mapper.told.is_some_and(|((of, ..), ..)| of != run);
        }
    }

    /// The landings that led to the states after `records`; `None` if the world saw one of them not at all, or more than once.
    pub fn landings(&self, records: &[Record]) -> Option<Vec<Landing>> {
        if self.is_flown_again {
            return None;
        }
        records.iter().map(|record| self.landings.get(&record.digest).copied()).collect()
    }

    /// Whether a message of a recording has the stamps with which the world saw it published.
    pub fn recorded(&self, message: &RecordedMessage) -> Result<(), String> {
        let (what, decision, is_known) = match message {
            RecordedMessage::State(state) => {
                let told = self.told.get(&(state.run, state.decision, state.digest));
                let is_known = told.is_some_and(|told| told.contains(&[state.landed, state.published]));
                ("a recorded state", state.decision, is_known)
            }
            RecordedMessage::Patch(patch) => {
                let mapped = self.mapped.get(&(patch.run, patch.through, patch.digest));
                let is_known = mapped.is_some_and(|mapped| mapped.contains(&[patch.sensed, patch.published]));
                ("a recorded patch", patch.through, is_known)
            }
            RecordedMessage::Page(page) => {
                let mapped = self.mapped.get(&(page.run, page.through, page.digest));
                let is_known = mapped.is_some_and(|mapped| mapped.contains(&[page.sensed, page.published]));
                ("a recorded page", page.through, is_known)
            }
            RecordedMessage::Command(command) => {
                let &Command { run, robot, decision, digest, incarnation, .. } = command;
                let sent = self.sent.get(&(incarnation, (run, decision, digest), robot));
                let is_known = sent.is_some_and(|sent| sent.iter().any(|planned| planned.is_of(command)));
                // A forged one was sent by nobody.
                ("a recorded command", decision, is_known || sent.is_none())
            }
            _ => return Ok(()),
        };
        if is_known {
            Ok(())
        } else {
            Err(format!("{what} of decision {decision} has stamps that nobody gave it"))
        }
    }

    /// A record with the true moment of its commit, if somebody lived to see it: so a living hopper-sim counts it.
    pub fn as_flown(&self, record: &Record) -> Record {
        let landing = self.landings.get(&record.digest).filter(|landing| landing.journalled == record.timing);
        let mut flown = *record;
        flown.timing.committed =
            landing.and_then(|landing| landing.committed).unwrap_or(record.timing.committed);
        flown
    }

    /// A life of hopper-sim publishes a state; `pace` unless orders may change it. `last` is the journal's last record.
    pub fn state(
        &mut self,
        life: Incarnation,
        state: &State,
        pace: Option<Pace>,
        last: Option<&Record>,
        now: MonotonicNs,
    ) -> Result<(), String> {
        let sim = self.sims.entry(life).or_default();
        let at = |state: &State| (state.run, state.decision, state.digest);
        if let Some(told) = sim.told.as_ref().filter(|told| at(told) == at(state)) {
            let stamps = |state: &State| (state.landed, state.published, state.last_timing);
            return same("a state published again", state.decision, stamps(told), stamps(state));
        }
        same("state.published", state.decision, now, state.published)?;
        match sim.appended.as_ref().filter(|record| record.digest == state.digest) {
            Some(record) => {
                same("state.last_timing", state.decision, record.timing, state.last_timing)?;
                let committed = record.timing.committed;
                let in_order = committed <= state.landed && state.landed <= now;
                if !in_order {
                    return Err(named("state.landed", state.decision, (committed, now), state.landed));
                }
                let need = match (pace, &sim.told) {
                    (Some(pace @ (Pace::Max | Pace::Hertz(_))), Some(told)) => {
                        pace.landing(&Launch { last_landed: told.landed, committed, lasts_s: 0.0 })
                    }
                    _ => state.landed,
                };
                same("state.landed", state.decision, need, state.landed)?;
            }
            // It begins, or goes on where another life ended.
            None => {
                same("state.landed of a life that begins", state.decision, now, state.landed)?;
                let need = last.map_or_else(Timing::default, |last| last.timing);
                same("state.last_timing of a life that begins", state.decision, need, state.last_timing)?;
            }
        }
        sim.told = Some(*state);
        self.told.entry(at(state)).or_default().insert([state.landed, state.published]);
        Ok(())
    }

    /// A life of hopper-sim receives a command.
    pub fn heard(&mut self, life: Incarnation, now: MonotonicNs) {
        self.sims.entry(life).or_default().heard = now;
    }

    /// A life of hopper-sim is about to append the record of a decision: it has accepted the command that it received last.
    pub fn accepted(&mut self, life: Incarnation, due: Decision) {
        let sim = self.sims.entry(life).or_default();
        // An append that failed is tried again with the same record.
        if sim.accepted.is_none_or(|(decision, _)| decision != due) {
            sim.accepted = Some((due, sim.heard));
        }
    }

    /// The journal has taken a record.
    pub fn appended(&mut self, life: Incarnation, run: RunId, record: &Record) -> Result<(), String> {
        let sim = self.sims.entry(life).or_default();
        let Record { decision, timing, robot, leader, previous, .. } = *record;
        sim.appended = Some(*record);
        let landing = Landing { robot, journalled: timing, committed: None };
        self.landings.insert(record.digest, landing);
        same("record.committed", decision, timing.accepted, timing.committed)?;
        let accepted = sim.accepted.filter(|(due, _)| *due == decision).map(|(_, at)| at);
        let told = sim.told.filter(|told| told.digest == previous);
        let need = told.map(|told| (told.landed, told.published));
        same(
            "record.landed and state_published",
            decision,
            need,
            Some((timing.landed, timing.state_published)),
        )?;
        if record.origin.is_fallback() {
            // It acts in the turn in which the deadline passes; the state may be published before, in the same turn.
            let bare = Timing {
                landed: timing.landed,
                state_published: timing.state_published,
                accepted: timing.accepted,
                committed: timing.committed,
                ..Timing::default()
            };
            return same("what a fallback measures", decision, bare, timing);
        }
        same("record.accepted", decision, accepted, Some(timing.accepted))?;
        let key = (leader.incarnation, (run, decision, previous), robot);
        let got = [timing.sensed, timing.map_published, timing.planning_started, timing.planning_ended];
        let is_of = |planned: &Planned| planned.moments() == got;
        match self.sent.get(&key) {
            Some(sent) if sent.iter().any(is_of) => Ok(()),
            sent => Err(named("the planner's part of the record", decision, sent, timing)),
        }
    }

    /// The append is over, whatever happened meanwhile.
    pub fn committed(&mut self, life: Incarnation, now: MonotonicNs) {
        let Some(record) = self.sims.entry(life).or_default().appended.as_mut() else { return };
        record.timing.committed = now;
        if let Some(landing) = self.landings.get_mut(&record.digest) {
            landing.committed = Some(now);
        }
    }

    /// hopper-sim tells its host of an executed decision.
    pub fn executed(&self, life: Incarnation, record: &Record) -> Result<(), String> {
        let need = self.sims.get(&life).and_then(|sim| sim.appended);
        same("what the host is told", record.decision, need.map(|need| need.timing), Some(record.timing))
    }

    /// A life of perception has folded a landing in.
    pub fn sensed(&mut self, life: Incarnation, now: MonotonicNs) {
        self.mappers.entry(life).or_insert(Mapper::at(now)).sensed = now;
    }

    /// A life of perception publishes a patch, or a reminder of the last.
    pub fn patch(&mut self, life: Incarnation, patch: &MapPatch, now: MonotonicNs) -> Result<(), String> {
        let MapPatch { run, through, digest, sensed, published, .. } = *patch;
        let mapper = self.mappers.entry(life).or_insert(Mapper::at(now));
        let at = (run, through, digest);
        let is_new = (mapper.sensed, now) == (sensed, published);
        if let Some((_, first_sensed, first_published)) = mapper.told.filter(|(told, ..)| *told == at)
            && !(mapper.may_begin_anew && is_new)
        {
            let need = (first_sensed, first_published);
            return same("a landing published again", through, need, (sensed, published));
        }
        same("patch.sensed and published", through, (mapper.sensed, now), (sensed, published))?;
        // A perception that publishes the next landing has not begun anew yet.
        let goes_on = mapper.told.is_some_and(|((of, before, _), ..)| of == run && before < through);
        mapper.may_begin_anew &= goes_on;
        mapper.told = Some((at, sensed, published));
        self.mapped.entry(at).or_default().insert([sensed, published]);
        Ok(())
    }

    /// A life of perception answers for the map.
    pub fn page(&self, life: Incarnation, page: &MapPage) -> Result<(), String> {
        let MapPage { run, through, digest, sensed, published, .. } = *page;
        let told = self.mappers.get(&life).and_then(|mapper| mapper.told);
        same("a page's", through, told, Some(((run, through, digest), sensed, published)))
    }

    /// A life of a planner plans for a state, on a map.
    pub fn plans(
        &mut self,
        life: Incarnation,
        state: &State,
        [sensed, map_published]: [MonotonicNs; 2],
        now: MonotonicNs,
    ) -> Result<(), String> {
        let at = (state.run, state.decision, state.digest);
        self.planning.insert(life, at);
        self.plans.insert((life, at), Planned { sensed, map_published, started: now, ended: now });
        match self.mapped.get(&at) {
            Some(mapped) if mapped.contains(&[sensed, map_published]) => Ok(()),
            mapped => Err(named("the planner's map", state.decision, mapped, [sensed, map_published])),
        }
    }

    /// A life of a planner has its plan.
    pub fn planned(&mut self, life: Incarnation, now: MonotonicNs) {
        if let Some(at) = self.planning.get(&life)
            && let Some(planned) = self.plans.get_mut(&(life, *at))
        {
            planned.ended = now;
        }
    }

    /// A life of a planner sends a command, once or again.
    pub fn command(&mut self, life: Incarnation, command: &Command) -> Result<(), String> {
        let Command { run, robot, decision, digest, .. } = *command;
        let at = (run, decision, digest);
        let planned = self.plans.get(&(life, at)).copied();
        if !planned.is_some_and(|planned| planned.is_of(command)) {
            return Err(named("the command", decision, planned, command));
        }
        self.sent.entry((life, at, robot)).or_default().extend(planned);
        Ok(())
    }
}
