//! Compares everything that happens with the promises, and influences nothing.
//!
//! The checker knows the truth, the journal's bytes and every message. It computes what should be true by
//! itself where it can: outcomes by executing the command again, seen cells from the sensor's formula.

use std::collections::{BTreeMap, BTreeSet};

use contract::protocol::peer_table::SILENCE_NS;
use contract::{
    Action, Branch, Cell, Command, Control, Decision, Digest, Ground, Heartbeat, Incarnation, Leader,
    MapPage, MapPatch, MonotonicNs, Name, Order, Origin, Pace, PastPage, Policy, Pose, Record, RobotId, Role,
    RunId, SeenCell, State, Status, Team, Term, Vetoed,
};
use hopper_sim::dynamics::{Execution, execute};
use hopper_sim::{Arbiter, Mission};
use planner::Situation;
use planner::pilot::DEATH_SILENCE_NS;
use report::Tally;
use serde::Serialize;

use crate::expected::{Expected, first_digest, next_digest};
use crate::life::Life;
use crate::reservation::{Reservations, Standing};
use crate::rovers::Rovers;
use crate::setup::{self, Setup};

/// A promise that did not hold.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Violation {
    /// The promise that was broken, by its name in this file.
    pub rule: &'static str,
    /// What was needed, and what was seen instead.
    pub detail: String,
}

/// What a command is known by.
type Sent = (RunId, RobotId, Incarnation, Decision, Digest, Term, u32);

/// The leader that the sender of a command knows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub leader: Leader,
    /// When the sender first heard of it as such.
    pub since: MonotonicNs,
    /// Whether the sender takes its process for gone.
    pub is_gone: bool,
}

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
    /// That decision with its landing.
    landed: Option<(Decision, MonotonicNs)>,
    /// When that state was first published.
    told: MonotonicNs,
}

/// Sees every message, every commit and every reader's map, and holds them to the promises.
#[derive(Debug)]
pub struct Checker {
    mission: Mission,
    opening: State,
    records: Vec<Record>,
    /// Of a mission of rovers: all of them after those records.
    rovers: Option<Rovers>,
    /// Who led each robot in each term of the run.
    terms: BTreeMap<(RobotId, Term), Incarnation>,
    sent: BTreeSet<Sent>,
    expected: Expected,
    /// The cells and treasures that the map of each state holds.
    contents: BTreeMap<Digest, (Vec<Option<Ground>>, Vec<Cell>)>,
    /// Records that the journal held once: after the digest of each, what a reader may still take for true.
    lost: BTreeMap<Digest, (Decision, Pose, u64)>,
    /// Cells that some pose so far could see.
    visible: Vec<bool>,
    /// Fingerprint of the map that belongs to each state.
    prints: BTreeMap<Digest, u64>,
    /// When each process last heard that each other lives, and the count of that beat.
    heard: BTreeMap<(Incarnation, Incarnation), (u64, MonotonicNs)>,
    /// Lives of planners that have commanded in this run, with the robots they commanded.
    commanders: BTreeSet<(RobotId, Incarnation)>,
    /// Planners that were ordered to take over.
    handed_over: BTreeSet<Incarnation>,
    /// Lives of other builds.
    foreign: BTreeSet<Incarnation>,
    /// Which life has received a heartbeat of which life of another build.
    recognised: BTreeSet<(Incarnation, Incarnation)>,
    reservations: Reservations,
    /// The last policy that hopper-sim has received.
    policy: Option<(RunId, Name, Decision)>,
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
            landed: None,
            told: MonotonicNs(0),
        };
        Self::of(&setup.mission, pacing)
    }

    fn of(mission: &Mission, pacing: Pacing) -> Self {
        let start = *Arbiter::new(mission.clone(), None, Pace::Max, 0, MonotonicNs(0)).state();
        let opening = State { digest: first_digest(&mission.brief, mission.seed), ..start };
        let mut checker = Self {
            opening,
            records: Vec::new(),
            rovers: Rovers::begin(mission),
            terms: BTreeMap::new(),
            sent: BTreeSet::new(),
            expected: Expected::unseen(&mission.brief),
            contents: BTreeMap::new(),
            lost: BTreeMap::new(),
            visible: vec![false; mission.brief.grid.cells()],
            prints: BTreeMap::new(),
            heard: BTreeMap::new(),
            commanders: BTreeSet::new(),
            handed_over: BTreeSet::new(),
            foreign: BTreeSet::new(),
            recognised: BTreeSet::new(),
            reservations: Reservations::default(),
            policy: None,
            sim: Incarnation(0),
            pacing,
            violation: None,
            mission: mission.clone(),
        };
        match &checker.rovers {
            Some(rovers) => checker.expected.enter(&mission.brief, &mission.terrain, &rovers.views()),
            None => checker.expected.land(&mission.brief, &mission.terrain, opening.pose),
        }
        checker.mapped_at(opening.digest);
        checker
    }

    /// Another mission begins; what was seen of the old one stays valid for its stragglers.
    pub fn begin(&mut self, mission: &Mission) {
        let new = Self::of(mission, self.pacing.clone());
        let old = std::mem::replace(self, new);
        self.sent = old.sent;
        self.prints.extend(old.prints);
        self.contents.extend(old.contents);
        self.heard = old.heard;
        self.handed_over = old.handed_over;
        self.foreign = old.foreign;
        self.recognised = old.recognised;
        self.reservations = old.reservations;
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

    /// Whose turn it is.
    pub(crate) fn due(&self) -> RobotId {
        self.rovers.as_ref().map_or(RobotId(0), Rovers::due)
    }

    /// A step that the rover which is due cannot take.
    pub(crate) fn blocked_step(&self) -> Option<Action> {
        self.rovers.as_ref()?.blocked_step(&self.mission)
    }

    /// Who commands the robot that is due.
    #[must_use]
    pub fn leader(&self) -> Leader {
        self.leader_of(self.due())
    }

    /// Who commands a robot.
    pub(crate) fn leader_of(&self, robot: RobotId) -> Leader {
        let last = || self.records.last().map_or(self.opening.leader, |record| record.leader);
        self.rovers.as_ref().map_or_else(last, |rovers| rovers.leader(robot))
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

    /// A decision was executed: more may be seen.
    fn see(&mut self, record: &Record) {
        let Mission { brief, terrain, .. } = &self.mission;
        match &self.rovers {
            Some(rovers) => self.expected.enter(brief, terrain, rovers.view_after(record).as_slice()),
            None => self.expected.land(brief, terrain, record.pose),
        }
        self.mapped_at(record.digest);
    }

    /// The map that belongs to the state of `digest` is what is seen now.
    fn mapped_at(&mut self, digest: Digest) {
        for (index, visible) in self.visible.iter_mut().enumerate() {
            *visible |= self.expected.is_seen(index);
        }
        let print = self.expected.fingerprint();
        let (cells, treasures) = (self.expected.cells().to_vec(), self.expected.treasures().to_vec());
        self.contents.insert(digest, (cells, treasures));
        self.prints.insert(digest, print);
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
        let chained = record.previous == previous && record.digest == next_digest(previous, record);
        self.require(chained, "the digest chain is intact", || format!("it breaks at decision {due}"));
        if !before.status.is_over() {
            let need = match &self.rovers {
                Some(rovers) => rovers.execute(&self.mission, record.action),
                None => Some((RobotId(0), execute(&self.mission, &before, record.action))),
            };
            let Record { robot, outcome, pose, collected, steps, visits, status, .. } = *record;
            let got = Some((robot, Execution { outcome, pose, collected, steps, visits, status }));
            self.require(need == got, "the outcome depends on seed, robot and decision alone", || {
                format!("decision {due} came out as {got:?}, needs {need:?}")
            });
        }
        let leader = self.leader_of(record.robot);
        self.succession(leader, record);
        self.guarded(&before, record);
        if record.origin.is_fallback() {
            self.fell_back(leader, record);
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
        if let Some(rovers) = &mut self.rovers {
            rovers.committed(&self.mission, record);
        }
        self.see(record);
    }

    /// hopper-sim has executed a command just now.
    pub(crate) fn executed(&mut self, record: &Record) {
        let leader = record.leader.incarnation;
        // The fallback leaves the command with whom it was.
        let refused = !record.origin.is_fallback() && self.foreign.contains(&leader);
        self.require(!refused, "a process of another build is not obeyed", || {
            format!("decision {} was commanded by {leader}, which is of another build", record.decision)
        });
        if record.origin == Origin::Policy {
            // The decision after that which reached the last goal.
            let visits = self.records.last().map_or(0, |last| last.visits);
            let leg_began = self.records.iter().position(|record| record.visits == visits);
            let leg_began = if visits == 0 { 0 } else { leg_began.map_or(0, |index| index as u64 + 1) };
            let policy = self.policy;
            let run = self.mission.brief.run;
            let leads_here = policy.is_some_and(|(of, planner, decision)| {
                of == run && planner == record.leader.planner && decision.0 >= leg_began
            });
            self.require(leads_here, "the fallback follows a policy for the goal in force", || {
                format!("decision {} followed {policy:?}; its leg began at {leg_began}", record.decision)
            });
        }
    }

    /// The probability that `action` ends off the map or on ground known to be impassable, from the observed
    /// map alone: what anybody could know who has seen what the hopper has.
    fn hazard(&self, from: Cell, action: Action) -> f64 {
        let brief = &self.mission.brief;
        let known = |cell: Cell| self.expected.cells()[brief.grid.index(cell)?].as_ref();
        let (Action::Hop(direction), Some(ground)) = (action, known(from)) else { return 0.0 };
        let scatter = motion::transition(&brief.motion, ground, direction);
        let ruins = |branch: &Branch| {
            let to = motion::landing(&brief.grid, from, direction, *branch);
            !brief.grid.contains(to) || known(to).is_some_and(|ground| !ground.passable)
        };
        Branch::ALL.into_iter().filter(ruins).map(|branch| scatter.probability(branch)).sum()
    }

    /// Actions that the guard should veto at `from`, which is where the hopper is; of rovers, those that lead the one that
    /// is due where it cannot stand.
    fn to_veto(&self, from: Cell) -> Vetoed {
        if let Some(rovers) = &self.rovers {
            return rovers.blocked(&self.mission);
        }
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

    fn succession(&mut self, held: Leader, record: &Record) {
        let Record { robot, decision, leader, .. } = *record;
        let Leader { term, incarnation, planner, .. } = leader;
        let goes_on = term == held.term && (incarnation, planner) == (held.incarnation, held.planner);
        self.require(goes_on || term == held.term.next(), "terms only rise, by one", || {
            format!("decision {decision}: term {} of {} after {}", term, incarnation, held.term)
        });
        let owner = *self.terms.entry((robot, term)).or_insert(incarnation);
        self.require(owner == incarnation, "no term is shared by two planners", || {
            format!("decision {decision}: term {term} of {incarnation} was {owner}'s")
        });
        self.commanders.insert((robot, incarnation));
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

    /// The journal was replaced by one that holds `records`: an earlier state of itself, perhaps flown on elsewhere. What
    /// was told of the hops that are gone may still be heard.
    pub(crate) fn replaced(&mut self, records: &[Record]) {
        let run = self.mission.brief.run;
        let (visible, mut lost) = (self.visible.clone(), std::mem::take(&mut self.lost));
        lost.extend(
            self.records
                .iter()
                .map(|record| (record.digest, (record.decision.next(), record.pose, record.steps))),
        );
        self.sent.extend(records.iter().map(|record| signature(record, run)));
        let mission = self.mission.clone();
        self.begin(&mission);
        records.iter().for_each(|record| self.committed(record));
        self.lost = lost;
        for (index, was_visible) in visible.into_iter().enumerate() {
            self.visible[index] |= was_visible;
        }
    }

    /// hopper-sim publishes all robots.
    pub(crate) fn team_published(&mut self, team: &Team) {
        let held = self.records.len() as u64;
        // While an action is in the air the robots before it are published again; they are compared once it has landed.
        if team.decision.0 != held || team.run != self.mission.brief.run {
            let right = team.decision.0 < held || team.run != self.mission.brief.run;
            return self.require(right, "nothing is published that the journal does not hold", || {
                format!("the robots of decision {}, the journal holds {held}", team.decision)
            });
        }
        let digest = self.digest();
        let need = self.rovers.as_ref().map(|rovers| rovers.team(team.run, team.decision, digest));
        self.require(need.as_ref() == Some(team), "the robots are where the journal leaves them", || {
            format!("told {team:?}, needs {need:?}")
        });
    }

    /// hopper-sim publishes a state at `now`.
    pub fn published(&mut self, state: &State, now: MonotonicNs) {
        self.require(state.landed <= now, "no state is published before its landing", || {
            format!("state {} was published {} ns before", state.decision, state.landed.since_ns(now))
        });
        self.spaced(state);
        let Some(held) = self.state_at(state.decision).filter(|held| held.run == state.run) else {
            return self.violate("nothing is published that the journal does not hold", || {
                format!("state {} of run {}", state.decision, state.run)
            });
        };
        // While a hop is in the air the state before it is published again, with what was vetoed then.
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

    /// Landings follow each other no faster than the pace, where no order changes it.
    fn spaced(&mut self, state: &State) {
        let Pacing { control, landed, .. } = self.pacing;
        if self.records.len() as u64 > state.decision.0 {
            // What is published again while the next hop is in the air has landed before.
            return;
        }
        let Some((decision, last)) = self.pacing.landed.replace((state.decision, state.landed)) else {
            return;
        };
        let (false, Some(Pace::Hertz(hertz))) = (control, self.pacing.paces.first().copied()) else { return };
        let period_ns = (1e9 / hertz) as u64 - 1;
        let apart_ns = state.landed.since_ns(last);
        self.require(state.decision == decision || apart_ns >= period_ns, "landings keep the pace", || {
            format!("state {} landed {apart_ns} ns after {landed:?} at {hertz} Hz", state.decision)
        });
    }

    /// Landings wait while hopper-sim is paused.
    fn landed(&mut self, state: &State) {
        let pacing = &mut self.pacing;
        let last = pacing.published.replace(state.decision);
        pacing.told = state.published;
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
        // What is kept for one robot while another is due is not computed here.
        self.reservations = Reservations::default();
        self.reservations.unsure = self.rovers.is_some();
        self.policy = None;
        self.pacing = Pacing {
            control,
            paces: vec![pace],
            paused: false,
            steps: 0,
            landings: 0,
            published: None,
            landed: None,
            told: MonotonicNs(0),
        };
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
        recorded: &BTreeSet<(Decision, Digest)>,
        now: MonotonicNs,
    ) {
        let asked =
            self.heard.get(&(monitor, self.sim)).is_some_and(|&(_, at)| now.since_ns(at) < SILENCE_NS);
        let is_missing = |record: &&Record| !recorded.contains(&(record.decision, record.digest));
        let missing = self.records.iter().find(is_missing).map(|record| record.decision);
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
        // Whoever saw a journal that is gone asks beyond the end of this one.
        let is_beyond = page.records.is_empty() && from >= self.records.len();
        let right = page.run == self.mission.brief.run && (is_beyond || held == Some(&page.records[..]));
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
        let MapPatch { run, through, digest, more, after, .. } = *patch;
        self.told(run, through, &patch.cells, &patch.treasures);
        if more == 0 {
            self.right(through, digest, after);
        }
        let record = through.0.checked_sub(1).and_then(|index| self.records.get(index as usize));
        // Another past's patches, and the starts', name whom they like.
        let Some(actor) = record.filter(|record| record.digest == digest).map(|record| record.robot) else {
            return;
        };
        let named = patch.robot;
        self.require(
            run != self.mission.brief.run || named == actor,
            "a patch names the robot that sensed",
            || format!("the patch through decision {through} names robot {named}, robot {actor} acted"),
        );
    }

    /// perception answers for the map.
    pub fn paged(&mut self, page: &MapPage) {
        self.told(page.run, page.through, &page.cells, &page.treasures);
        self.right(page.through, page.digest, page.observation);
    }

    fn told(&mut self, run: RunId, through: Decision, cells: &[SeenCell], treasures: &[Cell]) {
        if run != self.mission.brief.run {
            return;
        }
        let grid = self.mission.brief.grid;
        let treasures = treasures.iter().filter_map(|cell| grid.index(*cell));
        let mut told: Vec<usize> = cells.iter().map(|cell| cell.index as usize).collect();
        told.extend(treasures);
        let unseen = told.into_iter().find(|&index| !self.visible[index]);
        self.require(unseen.is_none(), "the planner never knows an unseen cell", || {
            format!("cell {unseen:?} is on the map through decision {through}")
        });
    }

    fn right(&mut self, through: Decision, digest: Digest, observation: u64) {
        let right = self.prints.get(&digest) == Some(&observation);
        self.require(right, "the map is that of the poses so far", || {
            format!("the map through decision {through}, digest {digest}, is another")
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
        let is_right = self.contents.get(&state.digest).is_some_and(|(cells, treasures)| {
            cells == situation.map.cells() && treasures == situation.map.treasures()
        });
        self.require(is_right, "every plan is made on the map of its own past", || {
            format!("at decision {} a cell or a treasure of the map is another", state.decision)
        });
    }

    /// hopper-sim receives a command, and judges it before anything else happens.
    pub(crate) fn judged(&mut self, command: &Command, now: MonotonicNs) {
        let Some(due) = self.pacing.published.or(Some(Decision(self.records.len() as u64))) else { return };
        if self.recognised.contains(&(self.sim, command.incarnation)) {
            return;
        }
        let is_known = self.heard.contains_key(&(self.sim, command.incarnation));
        let in_the_air = self.records.len() as u64 > due.0;
        let Some(before) = self.state_at(due) else { return };
        let at = Standing {
            due,
            digest: before.digest,
            in_the_air,
            is_over: before.status.is_over(),
            leader: self.leader(),
            published: self.pacing.told,
        };
        self.reservations.judge(&self.mission.brief, command, is_known, &at, now);
    }

    /// A turn of hopper-sim ends, after `yielded` refusals in favour of a takeover in its life.
    pub(crate) fn yielded(&mut self, yielded: u64) {
        let need = self.reservations;
        self.require(
            need.unsure || need.yielded == yielded,
            "a decision is kept for a late takeover, and no other",
            || format!("{yielded} commands were refused in favour of a takeover, {} had to be", need.yielded),
        );
    }

    /// hopper-sim could not write down what it had accepted.
    pub(crate) fn append_failed(&mut self) {
        self.reservations.unsure = true;
    }

    /// What decisions were kept for in this life of hopper-sim.
    pub(crate) fn reservations(&self) -> Reservations {
        self.reservations
    }

    /// hopper-sim receives a policy.
    pub(crate) fn advised(&mut self, policy: &Policy) {
        // One that does not fit is not kept.
        let due = self.pacing.published.unwrap_or(Decision(self.records.len() as u64));
        if policy.run == self.mission.brief.run && policy.decision <= due.next() {
            self.policy = Some((policy.run, policy.planner, policy.decision));
        }
    }

    /// The number of cells in view from each pose.
    pub(crate) fn disc_cells(&self) -> &[usize] {
        &self.expected.disc_cells
    }

    /// A planner sends a command, knowing who leads. Says what it takes over for, if it does.
    pub(crate) fn sent(
        &mut self,
        command: &Command,
        life: &Life,
        known: Known,
        now: MonotonicNs,
    ) -> Option<&'static str> {
        let Command { run, robot, incarnation, decision, digest, term, action, .. } = *command;
        let Known { leader, since, is_gone } = known;
        self.sent.insert((run, robot, incarnation, decision, digest, term, action.code()));
        if leader.incarnation == incarnation && term == leader.term {
            return None;
        }
        let heard = self.heard.get(&(incarnation, leader.incarnation)).map_or(0, |&(_, at)| at.0);
        // Silence counts only while somebody listens, and from when it knows who leads.
        let silent_since = heard.max(since.0).max(life.listening_since.get().0);
        let limit_ns = if is_gone { DEATH_SILENCE_NS } else { SILENCE_NS };
        // What it asks for may be what it got, and has not heard of yet.
        let led = run == self.mission.brief.run
            && self.commanders.contains(&(robot, incarnation))
            && self.terms.get(&(robot, term)) != Some(&incarnation);
        let told = life.takeover && !led || self.handed_over.contains(&incarnation);
        let cause = if leader.term == Term(0) {
            Some("vacancy")
        } else if told {
            Some("order")
        } else if life.succeeds_pid == Some(leader.pid) {
            Some("succession")
        } else if now.0.saturating_sub(silent_since) > limit_ns {
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
    pub fn watched(&mut self, tally: &Tally, run: RunId, is_final: bool) {
        if run != self.mission.brief.run || self.violation.is_some() {
            return;
        }
        let due = tally.due();
        let need = self.state_at(due).map(|state| (state.digest, state.pose, state.steps));
        let got = tally.last.map(|last| (last.digest, last.pose, last.steps));
        // Who has not heard yet that the journal was replaced holds what it held before.
        let is_lost =
            tally.last.is_some_and(|last| self.lost.get(&last.digest) == Some(&(due, last.pose, last.steps)));
        if is_lost && !is_final {
            return;
        }
        let route = &tally.route;
        let whole = route.hops() + route.held == due.0 && (due == Decision(0) || need == got);
        self.require(whole, "the monitor knows what the journal holds", || {
            format!("its tally through {due} is another's")
        });
    }
}

fn signature(record: &Record, run: RunId) -> Sent {
    let action: Action = record.action;
    let Leader { incarnation, term, .. } = record.leader;
    (run, record.robot, incarnation, record.decision, record.previous, term, action.code())
}
