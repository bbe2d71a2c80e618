//! Compares everything that happens with the promises, and influences nothing.
//!
//! The checker knows the truth, the journal's bytes and every message. It computes what should be true by
//! itself where it can: outcomes by executing the command again, seen cells from the sensor's formula.

mod commands;
mod dependence;
mod maps;
mod own_way;
mod pace;
mod routes;

use std::collections::{BTreeMap, BTreeSet};

use contract::protocol::peer_table::SILENCE_NS;
use contract::{
    Action, Branch, Cell, Decision, Digest, Ground, Heartbeat, Incarnation, Leader, MonotonicNs, Name,
    Origin, Pace, Pose, Record, RobotId, RunId, State, Status, Team, Term, Vetoed,
};
use hopper_sim::dynamics::Execution;
use hopper_sim::{Arbiter, Mission};
use report::Tally;

use self::dependence::Dependence;
use crate::chance::Chance;
use crate::claims::Claims;
use crate::coverage::Coverage;
use crate::expected::{Expected, design, first_digest, next_digest};
use crate::life::Life;
use crate::offers::Offers;
use crate::play::Play;
use crate::reservation::Reservations;
use crate::robots::Robots;
use crate::scouts::Scouts;
use crate::setup::{self, Setup};
use crate::tempo::Tempo;
use crate::violation::Violation;

/// Routes that a robot announces at most before it goes on: two planners may command it in turn.
const ANNOUNCEMENTS_MAX: u64 = 4;

/// What a command is known by.
type Sent = (RunId, RobotId, Incarnation, Decision, Digest, Term, u32, u64);

/// The leader that the sender of a command knows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub leader: Leader,
    /// When the sender first heard that it leads.
    pub since: MonotonicNs,
    /// Whether the sender takes its process for gone.
    pub is_gone: bool,
}

/// How landings are paced, and what was published.
#[derive(Clone, Debug)]
struct Pacing {
    tempo: Tempo,
    /// The last decision whose state was published by this life of hopper-sim.
    published: Option<Decision>,
    /// When that state was first published.
    told: MonotonicNs,
    /// The decision that was due when this life began.
    began: Decision,
}

/// Sees every message, every commit and every reader's map, and holds them to the promises.
#[derive(Debug)]
pub struct Checker {
    mission: Mission,
    opening: State,
    records: Vec<Record>,
    /// All robots after those records.
    robots: Robots,
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

impl Pacing {
    /// The pacing of a life of hopper-sim that has landed nothing yet.
    fn begin(control: bool, pace: Pace) -> Self {
        Self { tempo: Tempo::begin(control, pace), published: None, told: MonotonicNs(0), began: Decision(0) }
    }
}

impl Checker {
    /// Checks the first mission of `setup` from its start.
    #[must_use]
    pub fn new(setup: &Setup) -> Self {
        Self::of(&setup.mission, Pacing::begin(setup.control, setup.pace))
    }

    fn of(mission: &Mission, pacing: Pacing) -> Self {
        let start = *Arbiter::new(mission.clone(), None, Pace::Max, 0, MonotonicNs(0)).state();
        let opening = State { digest: first_digest(&mission.brief, mission.seed), ..start };
        let mut checker = Self {
            opening,
            records: Vec::new(),
            robots: Robots::begin(mission),
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
        checker.robots.open(&mission.brief, &mission.terrain, &mut checker.expected);
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
        self.dependence = old.dependence;
        self.offers = old.offers;
        self.sim = old.sim;
        self.violation = old.violation;
        self.robots.scouts_mut().keep_announced(old.robots.scouts());
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

    /// Whose turn it is.
    pub(crate) fn due(&self) -> RobotId {
        self.robots.scouts().due()
    }

    /// An action of the robot that is due which the guard should veto.
    pub(crate) fn blocked_action(&self) -> Option<Action> {
        self.robots.blocked_action(&self.mission)
    }

    /// Who commands the robot that is due.
    #[must_use]
    pub fn leader(&self) -> Leader {
        self.leader_of(self.due())
    }

    /// Who commands a robot.
    pub(crate) fn leader_of(&self, robot: RobotId) -> Leader {
        self.robots.leader(robot)
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
        self.robots.see(brief, terrain, record, &mut self.expected);
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
            let need = self.robots.execute(&self.mission, &before, record.action);
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
        self.robots.committed(&self.mission, record);
        self.see(record);
        let all_wait = self.scouts().is_some_and(Scouts::is_all_waiting);
        let is_last = all_wait && record.action == Action::Wait && record.outcome.branch == Branch::Held;
        self.require(!is_last, "nobody waits for others as the last one that can act", || {
            format!("robot {} did at decision {due}", record.robot)
        });
        self.goes_on(record);
    }

    /// Whoever has announced a route goes on along it: while no other robot acts, it announces no others again and again.
    fn goes_on(&mut self, record: &Record) {
        let Record { robot, action, decision, .. } = *record;
        let (last, times) = self.announcements;
        let times = match action {
            Action::Announce(_) if last == robot => times + 1,
            Action::Announce(_) => 1,
            _ => 0,
        };
        self.announcements = (robot, times);
        self.require(times <= ANNOUNCEMENTS_MAX, "who has announced a route goes on along it", || {
            format!("robot {robot} announced {times} routes one after the other up to decision {decision}")
        });
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
        if let Some(violation) = Play::new(&self.mission, arbiter, &self.robots, chance, now).run(coverage) {
            self.violate(violation.rule, || violation.detail);
        }
    }

    /// The hop of `record`, which was committed, is in the air.
    pub(crate) fn launched(&mut self, record: &Record, now: MonotonicNs) {
        let lasts_ns = self.robots.lasts_ns(&record.outcome);
        self.pacing.tempo.committed(lasts_ns, now);
    }

    /// hopper-sim has executed a command just now.
    pub(crate) fn executed(&mut self, record: &Record) {
        if let Action::Announce(_) = record.action {
            self.offers.announced(record.robot);
        }
        let leader = record.leader.incarnation;
        // The fallback leaves the command with whom it was.
        let refused = !record.origin.is_fallback() && self.foreign.contains(&leader);
        self.require(!refused, "a process of another build is not obeyed", || {
            format!("decision {} was commanded by {leader}, which is of another build", record.decision)
        });
        let hops = self.mission.brief.is_of_hopper() && record.robot == RobotId(0);
        let goes_to_own_goal = self.is_turn_of_own_way();
        self.require(
            !(goes_to_own_goal && record.origin == Origin::Policy),
            "no policy is followed where hoppers have goals of their own",
            || format!("decision {} followed one", record.decision),
        );
        if record.origin == Origin::Policy && hops {
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
    /// map alone: what anybody could know who has seen what the hopper that is due has.
    fn hazard(&self, from: Cell, action: Action) -> f64 {
        let brief = &self.mission.brief;
        let known = |cell: Cell| self.expected.cells()[brief.grid.index(cell)?].as_ref();
        let (Action::Hop(direction), Some(ground)) = (action, known(from)) else { return 0.0 };
        let due = self.mixed().and_then(|mixed| mixed.due()).unwrap_or(RobotId(0));
        let scatter = motion::transition(&design(brief, due).motion, ground, direction);
        let ruins = |branch: &Branch| {
            let to = motion::landing(&brief.grid, from, direction, *branch);
            !brief.grid.contains(to) || known(to).is_some_and(|ground| !ground.passable)
        };
        Branch::ALL.into_iter().filter(ruins).map(|branch| scatter.probability(branch)).sum()
    }

    /// Actions that the guard should veto at `from`, which is where the hopper is; of several robots, those that lead the one
    /// that is due where it cannot stand or may be trapped.
    fn to_veto(&self, from: Cell) -> Vetoed {
        if !self.robots.is_turn_of_hopper() {
            return self.robots.blocked(&self.mission);
        }
        let mixed = self.mixed().and_then(|mixed| Some((mixed.own_way()?, mixed.blocked(&self.mission))));
        let (from, blocked) = mixed.map_or((from, Vetoed::NONE), |([.., at], blocked)| (at, blocked));
        let hazard_max = self.mission.brief.guard.hazard_max;
        let hazards = Action::ALL.into_iter().filter(|&action| self.hazard(from, action) > hazard_max);
        hazards.fold(blocked, Vetoed::with)
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
        let need = if self.robots.is_turn_of_hopper() {
            self.greedy_on_own_way()
        } else {
            Some(self.robots.fallback(&self.mission))
        };
        let Some(need) = need else { return };
        let got = (record.action, record.origin);
        self.require(got == need, "at the deadline a robot goes on along its way, or holds", || {
            format!("decision {} was {got:?}, needs {need:?}", record.decision)
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
        let need = self.robots.team(team.run, team.decision, digest);
        self.require(need == *team, "the robots are where the journal leaves them", || {
            format!("told {team:?}, needs {need:?}")
        });
    }

    /// A process of another build begins to live.
    pub(crate) fn foreign_started(&mut self, incarnation: Incarnation) {
        self.foreign.insert(incarnation);
    }

    /// Whether a version is that of this build.
    pub(crate) fn is_own(&self, version: Name) -> bool {
        version == setup::version()
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
        // Beside a hopper the decisions of its helicopters are no part of its route.
        let is_of_hopper = self.mission.brief.is_of_hopper();
        let known = self.records.iter().take(due.0 as usize);
        let in_route = known.filter(|record| !is_of_hopper || record.robot == RobotId(0)).count() as u64;
        let whole = route.hops() + route.held == in_route && (due == Decision(0) || need == got);
        self.require(whole, "the monitor knows what the journal holds", || {
            format!("its tally through {due} is another's")
        });
    }
}

fn signature(record: &Record, run: RunId) -> Sent {
    let action: Action = record.action;
    let Leader { incarnation, term, .. } = record.leader;
    (run, record.robot, incarnation, record.decision, record.previous, term, action.code(), action.route())
}
