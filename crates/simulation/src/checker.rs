//! Compares everything that happens with the promises, and influences nothing.
//!
//! The checker knows the truth, the journal's bytes and every message. It computes what should be true by
//! itself where it can: outcomes by executing the command again, seen cells from the sensor's formula.

use std::collections::{BTreeMap, BTreeSet};

use contract::peer_table::SILENCE_NS;
use contract::{
    Action, Branch, Cell, Command, Control, Decision, Digest, Heartbeat, Incarnation, Leader, MapPage,
    MapPatch, MonotonicNs, Name, Order, Pace, PastPage, Pose, Record, Role, RunId, SeenCell, State, Status,
    Term, Vetoed,
};
use hopper_sim::dynamics::{Execution, execute};
use hopper_sim::{Arbiter, Mission, ROBOT};
use perception::Observation;
use planner::Situation;
use planner::pilot::DEATH_SILENCE_NS;
use report::Tally;
use serde::Serialize;

use crate::life::Life;
use crate::setup::{self, Setup};

/// A promise that did not hold.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Violation {
    /// The rule.
    pub rule: &'static str,
    /// What was seen.
    pub detail: String,
}

/// What a command is known by.
type Sent = (RunId, Incarnation, Decision, Term, u32);

/// How landings are paced, and what was ordered.
#[derive(Clone, Debug)]
struct Pacing {
    /// Whether hopper-sim obeys orders.
    control: bool,
    /// The pace of the start, and those ordered since.
    paces: Vec<Pace>,
    paused: bool,
    /// Single steps ordered, and landings published, since the pause.
    steps: u64,
    landings: u64,
    /// The last decision whose state was published by this life of hopper-sim.
    published: Option<Decision>,
}

/// Sees everything.
#[derive(Debug)]
pub struct Checker {
    mission: Mission,
    opening: State,
    records: Vec<Record>,
    /// Who led in each term of the run.
    terms: BTreeMap<Term, Incarnation>,
    sent: BTreeSet<Sent>,
    observation: Observation,
    /// Cells that some pose so far could see.
    visible: Vec<bool>,
    /// Fingerprint of the map that belongs to each state.
    prints: BTreeMap<Digest, u64>,
    /// Every map that was right at its time.
    maps: BTreeSet<(RunId, Decision, u64)>,
    /// When each process last heard that each other lives, and the count of that beat.
    heard: BTreeMap<(Incarnation, Incarnation), (u64, MonotonicNs)>,
    /// Lives of planners that have commanded in this run.
    commanders: BTreeSet<Incarnation>,
    /// Planners that were ordered to take over.
    handed_over: BTreeSet<Incarnation>,
    /// Lives of other builds.
    foreign: BTreeSet<Incarnation>,
    /// Which life has received a heartbeat of which life of another build.
    recognised: BTreeSet<(Incarnation, Incarnation)>,
    /// Commands that a life of another build sent before hopper-sim had received a heartbeat of it.
    unrecognised: BTreeSet<Sent>,
    /// The present life of hopper-sim.
    sim: Incarnation,
    pacing: Pacing,
    violation: Option<Violation>,
}

impl Checker {
    /// Checks the first mission of `setup` from its start.
    #[must_use]
    pub fn new(setup: &Setup) -> Self {
        let pacing = Pacing {
            control: setup.control,
            paces: vec![setup.pace],
            paused: false,
            steps: 0,
            landings: 0,
            published: None,
        };
        Self::of(&setup.mission, pacing)
    }

    fn of(mission: &Mission, pacing: Pacing) -> Self {
        let opening = *Arbiter::new(mission.clone(), None, Pace::Max, 0, MonotonicNs(0)).state();
        let mut checker = Self {
            opening,
            records: Vec::new(),
            terms: BTreeMap::new(),
            sent: BTreeSet::new(),
            observation: Observation::unseen(&mission.brief, ROBOT),
            visible: vec![false; mission.brief.grid.cells()],
            prints: BTreeMap::new(),
            maps: BTreeSet::new(),
            heard: BTreeMap::new(),
            commanders: BTreeSet::new(),
            handed_over: BTreeSet::new(),
            foreign: BTreeSet::new(),
            recognised: BTreeSet::new(),
            unrecognised: BTreeSet::new(),
            sim: Incarnation(0),
            pacing,
            violation: None,
            mission: mission.clone(),
        };
        checker.see(opening.pose, Decision(0), opening.digest);
        checker
    }

    /// Another mission begins; what was seen of the old one stays valid for its stragglers.
    pub fn begin(&mut self, mission: &Mission) {
        let new = Self::of(mission, self.pacing.clone());
        let old = std::mem::replace(self, new);
        self.sent = old.sent;
        self.prints.extend(old.prints);
        self.maps.extend(old.maps);
        self.heard = old.heard;
        self.handed_over = old.handed_over;
        self.foreign = old.foreign;
        self.recognised = old.recognised;
        self.unrecognised = old.unrecognised;
        self.sim = old.sim;
        self.violation = old.violation;
    }

    /// What was violated first, if anything was.
    #[must_use]
    pub fn violation(&self) -> Option<&Violation> {
        self.violation.as_ref()
    }

    /// The mission.
    #[must_use]
    pub fn mission(&self) -> &Mission {
        &self.mission
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

    /// Who commands.
    #[must_use]
    pub fn leader(&self) -> Leader {
        self.records.last().map_or(self.opening.leader, |record| record.leader)
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

    fn digest(&self) -> Digest {
        self.records.last().map_or(self.opening.digest, |record| record.digest)
    }

    /// The state that should be known to the world at `decision`.
    fn state_at(&self, decision: Decision) -> Option<State> {
        let Some(index) = decision.0.checked_sub(1) else { return Some(self.opening) };
        let record = self.records.get(index as usize)?;
        Some(record.state_after(self.mission.brief.run, MonotonicNs(0), MonotonicNs(0)))
    }

    /// A pose was taken up: more can be seen.
    fn see(&mut self, pose: Pose, decision: Decision, digest: Digest) {
        let Mission { brief, terrain, .. } = &self.mission;
        let sensor = &brief.sensor;
        let radius_m = (sensor.gain * (pose.height_m + sensor.offset_m))
            .max(sensor.radius_min_m)
            .min(sensor.radius_max_m);
        if brief.grid.contains(pose.cell) {
            for (index, cell) in brief.grid.iter().enumerate() {
                self.visible[index] |=
                    cell.distance_cells(pose.cell) * brief.grid.cell_size_m <= radius_m * (1.0 + 1e-12);
            }
        }
        self.observation.fold(brief, terrain, pose, decision);
        let print = self.observation.map().observation();
        self.prints.insert(digest, print);
        self.maps.insert((brief.run, decision, print));
    }

    /// The journal holds another record.
    pub fn committed(&mut self, record: &Record) {
        let due = Decision(self.records.len() as u64);
        self.require(record.decision == due, "one command is executed per decision", || {
            format!("decision {} was committed, {due} was due", record.decision)
        });
        let before = self.state_at(due).unwrap_or(self.opening);
        self.require(!before.status.is_over(), "nothing follows the end", || {
            format!("decision {due} was committed after {}", before.status)
        });
        let previous = self.digest();
        let chained = record.previous == previous && record.digest == previous.chain(record);
        self.require(chained, "the digest chain is intact", || format!("it breaks at decision {due}"));
        if !before.status.is_over() {
            let need = execute(&self.mission, &before, record.action);
            let Record { outcome, pose, collected, steps, visits, status, .. } = *record;
            let got = Execution { outcome, pose, collected, steps, visits, status };
            self.require(need == got, "the outcome depends on seed, robot and decision alone", || {
                format!("decision {due} came out as {got:?}, needs {need:?}")
            });
        }
        self.succession(before.leader, record.leader, due);
        self.guarded(&before, record);
        if record.origin.is_fallback() {
            self.fell_back(before.leader, record);
        } else {
            let sent = self.sent.contains(&signature(record, self.mission.brief.run));
            self.require(sent, "what is executed was commanded", || {
                format!("nobody sent decision {due} as {} of {:?}", record.action, record.leader)
            });
            let seen = self.prints.get(&previous) == Some(&record.observation);
            self.require(seen, "nobody decides before the map covers the decision", || {
                format!("decision {due} was taken on another map")
            });
        }
        self.records.push(*record);
        self.see(record.pose, due.next(), record.digest);
    }

    /// hopper-sim has executed a command just now.
    pub(crate) fn executed(&mut self, record: &Record) {
        let leader = record.leader.incarnation;
        // The fallback leaves the command with whom it was.
        let refused = !record.origin.is_fallback()
            && self.foreign.contains(&leader)
            && !self.unrecognised.contains(&signature(record, self.mission.brief.run));
        self.require(!refused, "a process of another build is not obeyed", || {
            format!("decision {} was commanded by {leader}, which is of another build", record.decision)
        });
    }

    /// The probability that `action` ends off the map or on ground known to be impassable, from the observed
    /// map alone: what anybody could know who has seen what the hopper has.
    fn hazard(&self, from: Cell, action: Action) -> f64 {
        let (brief, map) = (&self.mission.brief, self.observation.map());
        let (Action::Hop(direction), Some(ground)) = (action, map.ground(from)) else { return 0.0 };
        let scatter = motion::transition(&brief.motion, ground, direction);
        let ruins = |branch: &Branch| {
            let to = motion::landing(&brief.grid, from, direction, *branch);
            !brief.grid.contains(to) || map.ground(to).is_some_and(|ground| !ground.passable)
        };
        Branch::ALL.into_iter().filter(ruins).map(|branch| scatter.probability(branch)).sum()
    }

    /// Actions that the guard should veto at `from`, which is where the hopper is.
    fn to_veto(&self, from: Cell) -> Vetoed {
        let hazard_max = self.mission.brief.guard.hazard_max;
        let hazards = Action::ALL.into_iter().filter(|&action| self.hazard(from, action) > hazard_max);
        hazards.fold(Vetoed::NONE, Vetoed::with)
    }

    /// The guard did its duty at the decision of `record`, and no more.
    fn guarded(&mut self, before: &State, record: &Record) {
        let (due, action) = (record.decision, record.action);
        let need = self.to_veto(before.pose.cell);
        self.require(!need.has(action), "nothing dangerous is executed", || {
            format!("decision {due} was {action} from {}", before.pose.cell)
        });
        self.require(
            record.vetoed.union(need) == need,
            "only what is seen to be dangerous is vetoed",
            || format!("decision {due}: {:?} were vetoed, {need:?} are dangerous", record.vetoed),
        );
    }

    /// The fallback acted when it should, and left the command where it was.
    fn fell_back(&mut self, leader: Leader, record: &Record) {
        let deadline_ns = self.mission.brief.guard.deadline_ns;
        let timing = &record.timing;
        let waited_ns = timing.accepted.since_ns(timing.state_published);
        let due = deadline_ns > 0 && waited_ns >= deadline_ns && record.leader == leader;
        self.require(due, "nobody falls back before the deadline", || {
            format!("decision {} after {waited_ns} of {deadline_ns} ns", record.decision)
        });
    }

    fn succession(&mut self, held: Leader, leader: Leader, decision: Decision) {
        let Leader { term, incarnation, planner, .. } = leader;
        let goes_on = term == held.term && (incarnation, planner) == (held.incarnation, held.planner);
        self.require(goes_on || term == held.term.next(), "terms only rise, by one", || {
            format!("decision {decision}: term {} of {} after {}", term, incarnation, held.term)
        });
        let owner = *self.terms.entry(term).or_insert(incarnation);
        self.require(owner == incarnation, "no term is shared by two planners", || {
            format!("decision {decision}: term {term} of {incarnation} was {owner}'s")
        });
        self.commanders.insert(incarnation);
    }

    /// hopper-sim has opened the journal, which holds `records`; `may_have_lost` after a loss of power
    /// without --sync.
    pub fn reopened(&mut self, records: &[Record], may_have_lost: bool) {
        let known = self.records.len().min(records.len());
        let (kept, more) = records.split_at(known);
        let whole = kept == &self.records[..known] && (may_have_lost || known == self.records.len());
        let (held, got) = (self.records.len(), records.len());
        self.require(whole, "what is committed is never lost", || {
            format!("the journal held {held} records, and was opened again with {got}")
        });
        self.require(more.len() <= 1, "one command is executed per decision", || {
            format!("{} records appeared in the journal by themselves", more.len())
        });
        if known < self.records.len() {
            self.rewind(known);
        }
        for record in more {
            self.committed(record);
        }
    }

    /// The journal has lost its tail, as it may.
    fn rewind(&mut self, kept: usize) {
        let kept: Vec<Record> = self.records[..kept].to_vec();
        let mission = self.mission.clone();
        self.begin(&mission);
        for record in &kept {
            self.committed(record);
        }
    }

    /// hopper-sim publishes a state.
    pub fn published(&mut self, state: &State) {
        let Some(held) = self.state_at(state.decision).filter(|held| held.run == state.run) else {
            return self.violate("nothing is published that the journal does not hold", || {
                format!("state {} of run {}", state.decision, state.run)
            });
        };
        // While a hop is in the air the state before it is told again, with what was vetoed then.
        let need = match self.records.get(state.decision.0 as usize) {
            Some(record) => record.vetoed,
            None if state.status.is_over() => Vetoed::NONE,
            None => self.to_veto(held.pose.cell),
        };
        let told = state.vetoed.union(need) == need;
        self.require(told, "only what is seen to be dangerous is vetoed", || {
            format!("state {}: {:?} are vetoed, {need:?} are dangerous", state.decision, state.vetoed)
        });
        let timeless = State {
            vetoed: Vetoed::NONE,
            landed: MonotonicNs(0),
            published: MonotonicNs(0),
            last_timing: held.last_timing,
            ..*state
        };
        self.require(timeless == held, "nothing is published that the journal does not hold", || {
            format!("state {} is {timeless:?}, the journal has {held:?}", state.decision)
        });
        self.landed(state);
    }

    /// Landings wait while hopper-sim is paused.
    fn landed(&mut self, state: &State) {
        let pacing = &mut self.pacing;
        let last = pacing.published.replace(state.decision);
        if pacing.paused && last.is_some_and(|last| state.decision > last) {
            pacing.landings += 1;
        }
        let (landings, steps) = (pacing.landings, pacing.steps);
        self.require(landings <= steps, "landings wait while the mission is paused", || {
            format!("{landings} landings were published during a pause with {steps} single steps")
        });
    }

    /// A life of hopper-sim begins: a pause does not outlive the one before.
    pub(crate) fn sim_started(&mut self, incarnation: Incarnation, pace: Pace) {
        self.sim = incarnation;
        let control = self.pacing.control;
        let (paused, steps, landings, published) = (false, 0, 0, None);
        self.pacing = Pacing { control, paces: vec![pace], paused, steps, landings, published };
    }

    /// A process of another build begins to live.
    pub(crate) fn foreign_started(&mut self, incarnation: Incarnation) {
        self.foreign.insert(incarnation);
    }

    /// Whether a version is that of this build.
    pub(crate) fn is_own(&self, version: Name) -> bool {
        version == setup::version()
    }

    /// hopper-sim publishes how landings are paced.
    pub(crate) fn paced(&mut self, message: &contract::Pacing) {
        let Pacing { control, paces, .. } = &self.pacing;
        let obeyed =
            message.obeys == *control && (*control || !message.paused) && paces.contains(&message.pace);
        let control = *control;
        self.require(
            obeyed,
            "orders are obeyed by a hopper-sim started with --control, and by no other",
            || format!("with control {control} the pacing is {message:?}"),
        );
        let pacing = &mut self.pacing;
        // A step may have been ordered in the turn of the pause, before this message.
        if !message.paused {
            (pacing.steps, pacing.landings) = (0, 0);
        }
        pacing.paused = message.paused;
    }

    /// A process receives an order.
    pub(crate) fn ordered(&mut self, life: &Life, control: &Control) {
        let is_sim = life.role == Role::HopperSim && control.run == self.mission.brief.run;
        match control.order {
            // Resumed and paused again in one turn, it lets one landing come, and no pacing message says so.
            Order::Step | Order::Resume if is_sim => self.pacing.steps += 1,
            Order::Pace(pace) if is_sim && self.pacing.control => {
                self.pacing.paces.push(pace);
            }
            // A planner may still be in the run before.
            Order::HandOver(incarnation) if incarnation == life.incarnation => {
                self.handed_over.insert(incarnation);
            }
            _ => {}
        }
    }

    /// A planner publishes its policy.
    pub(crate) fn policy_published(&mut self, readers: usize) {
        self.require(readers > 0, "policies are made for readers alone", || "nobody reads them".into());
    }

    /// A monitor that records acknowledges the end of the mission, with these decisions on record.
    pub(crate) fn recorded(
        &mut self,
        monitor: Incarnation,
        decisions: &BTreeSet<Decision>,
        now: MonotonicNs,
    ) {
        let asked =
            self.heard.get(&(monitor, self.sim)).is_some_and(|&(_, at)| now.since_ns(at) < SILENCE_NS);
        let missing =
            (0..self.records.len() as u64).map(Decision).find(|decision| !decisions.contains(decision));
        let held = self.records.len();
        self.require(
            !asked || missing.is_none(),
            "the end is acknowledged once every decision is recorded",
            || format!("decision {missing:?} of {held} is missing in the recording"),
        );
    }

    /// hopper-sim answers for the past.
    pub fn served(&mut self, page: &PastPage) {
        let from = page.from.0 as usize;
        let held = self.records.get(from..from + page.records.len());
        let right = page.run == self.mission.brief.run && held == Some(&page.records[..]);
        self.require(right, "nothing is published that the journal does not hold", || {
            format!("the past from decision {from} is not that of the journal")
        });
        let landed = self.pacing.published;
        let in_the_air = page.records.iter().find(|record| landed.is_some_and(|due| record.decision >= due));
        self.require(in_the_air.is_none(), "the past holds landed hops only", || {
            format!("decision {:?} was served before it landed", in_the_air.map(|record| record.decision))
        });
    }

    /// perception publishes a patch.
    pub fn mapped(&mut self, patch: &MapPatch) {
        let MapPatch { run, through, more, after, .. } = *patch;
        self.told(run, through, &patch.cells, &patch.treasures);
        if more == 0 {
            self.right(run, through, after);
        }
    }

    /// perception answers for the map.
    pub fn paged(&mut self, page: &MapPage) {
        self.told(page.run, page.through, &page.cells, &page.treasures);
        self.right(page.run, page.through, page.observation);
    }

    fn told(&mut self, run: RunId, through: Decision, cells: &[SeenCell], treasures: &[Cell]) {
        if run != self.mission.brief.run {
            return;
        }
        let grid = self.mission.brief.grid;
        let treasures = treasures.iter().filter_map(|cell| grid.index(*cell));
        let mut told = cells.iter().map(|cell| cell.index as usize).chain(treasures);
        let unseen = told.find(|&index| !self.visible[index]);
        self.require(unseen.is_none(), "the planner never knows an unseen cell", || {
            format!("cell {unseen:?} is on the map through decision {through}")
        });
    }

    fn right(&mut self, run: RunId, through: Decision, observation: u64) {
        let right = self.maps.contains(&(run, through, observation));
        self.require(right, "the map is that of the poses so far", || {
            format!("the map of run {run} through decision {through} is another")
        });
    }

    /// A planner is about to plan for `situation`.
    pub fn plans(&mut self, situation: &Situation<'_>) {
        let state = situation.state;
        let covered = self.prints.get(&state.digest) == Some(&situation.map.observation())
            && situation.map.through == Some(state.decision)
            && situation.brief.run == state.run;
        self.require(covered, "nobody decides before the map covers the decision", || {
            format!("at decision {} the map goes through {:?}", state.decision, situation.map.through)
        });
    }

    /// A planner sends a command, knowing `leader` as the one in command. Says what it takes over for, if
    /// it does.
    pub(crate) fn sent(
        &mut self,
        command: &Command,
        life: &Life,
        leader: Leader,
        now: MonotonicNs,
    ) -> Option<&'static str> {
        let Command { run, incarnation, decision, term, action, .. } = *command;
        self.sent.insert((run, incarnation, decision, term, action.code()));
        if !self.recognised.contains(&(self.sim, incarnation)) {
            self.unrecognised.insert((run, incarnation, decision, term, action.code()));
        }
        if leader.incarnation == incarnation && term == leader.term {
            return None;
        }
        let silent_since = self.heard.get(&(incarnation, leader.incarnation)).map_or(0, |&(_, at)| at.0);
        // What it asks for may be what it got, and has not heard of yet.
        let led = run == self.mission.brief.run
            && self.commanders.contains(&incarnation)
            && self.terms.get(&term) != Some(&incarnation);
        let told = life.takeover && !led || self.handed_over.contains(&incarnation);
        let cause = if leader.term == Term(0) {
            Some("vacancy")
        } else if told {
            Some("order")
        } else if life.succeeds_pid == Some(leader.pid) {
            Some("succession")
        } else if now.0.saturating_sub(silent_since) > DEATH_SILENCE_NS {
            Some("silence")
        } else {
            None
        };
        self.require(
            cause.is_some() && term == leader.term.next(),
            "nobody takes over without a cause",
            || format!("{incarnation} asks for term {term} after {}, whose leader beats", leader.term),
        );
        cause
    }

    /// A process has heard that another lives.
    pub(crate) fn heard(&mut self, listener: &Life, beat: &Heartbeat, now: MonotonicNs) {
        if beat.version != listener.version {
            // It proves nothing to a process of this build but that the other is none.
            self.recognised.insert((listener.incarnation, beat.incarnation));
            return;
        }
        let last = self.heard.entry((listener.incarnation, beat.incarnation)).or_insert((0, now));
        if beat.counter > last.0 {
            *last = (beat.counter, now);
        }
    }

    /// The watcher has taken account of everything up to `tally`.
    pub fn watched(&mut self, tally: &Tally, run: RunId) {
        if run != self.mission.brief.run || self.violation.is_some() {
            return;
        }
        let due = tally.due();
        let need = self.state_at(due).map(|state| (state.digest, state.pose, state.steps));
        let got = tally.last.map(|last| (last.digest, last.pose, last.steps));
        let route = &tally.route;
        let whole = route.hops() + route.held == due.0 && (due == Decision(0) || need == got);
        self.require(whole, "the monitor knows what the journal holds", || {
            format!("its tally through {due} is another's")
        });
    }
}

fn signature(record: &Record, run: RunId) -> Sent {
    let action: Action = record.action;
    (run, record.leader.incarnation, record.decision, record.leader.term, action.code())
}
