//! The state machine of the monitor: public messages in, progress out.
//!
//! A fold: states that were missed are filled in from `hop/past`, so that a monitor killed and started
//! again knows what an undisturbed one knows, save that a record's `committed` is the moment its
//! append was asked for, a state's the moment it was done.

use std::collections::BTreeMap;

use contract::protocol::peer_table::SILENCE_NS;
use contract::{
    Brief, Decision, Heartbeat, MapPatch, Member, MonotonicNs, PastPage, PastRequest, PeerTable, Refusal,
    RefusalCounts, RobotId, RobotSet, Role, RunId, State, Status, Team,
};
use follow::{Link, PastFollower};
use report::{Executed, LatencyReport, Tally};

use crate::progress::{Health, Progress, Pulse, TeamMeasure};

/// Pause between two looks at progress.
const PROGRESS_PERIOD_NS: u64 = 100_000_000;

/// How long the end of a mission waits for the last map, nanoseconds.
const LAST_MAP_NS: u64 = 300_000_000;

/// The roles a monitor looks after: not its own.
const OTHERS: [Role; 3] = [Role::HopperSim, Role::Perception, Role::Planner];

/// What the monitor receives.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "an event is made, taken, and gone")]
pub enum Event {
    /// The brief; one of a new run drops all that was known.
    Brief(Brief),
    /// The state.
    State(State),
    /// All robots of a mission that is not a single hopper's.
    Team(Team),
    /// What a landing changed in the observed map; of it the monitor needs the counts alone.
    Map(MapPatch),
    /// A heartbeat.
    Heartbeat(Heartbeat),
    /// Records that were asked for.
    Past(PastPage),
    /// A message was malformed.
    Refused(Refusal),
    /// Time passes.
    Tick,
}

/// What the monitor wants done.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Ask for the past.
    RequestPast(PastRequest),
    /// Show this: ten times a second, and at the mission's end.
    Progress(Box<Progress>),
    /// The mission is over, and all of it is taken account of or nobody is left to ask.
    Finished(Status),
}

/// Watches the mission of one robot.
#[derive(Clone, Debug)]
pub struct Watcher {
    robot: RobotId,
    mission: Option<Mission>,
    peer_table: PeerTable,
    /// Process of each role that was heard last, and when.
    heard: BTreeMap<Role, (u32, MonotonicNs)>,
    /// Since when it listens.
    began: Option<MonotonicNs>,
    shown: Option<MonotonicNs>,
}

/// What is known of one run.
#[derive(Clone, Debug)]
struct Mission {
    brief: Brief,
    tally: Tally,
    /// The decisions of the tally, and those that are missing.
    past: PastFollower,
    state: Option<State>,
    /// As last published; empty where there is a single hopper.
    robots: Vec<Member>,
    coverage: Option<f64>,
    mapped: Option<Decision>,
    /// When its end was first heard of.
    ended: Option<MonotonicNs>,
    finished: bool,
    silences: BTreeMap<Role, Silence>,
    refusals: RefusalCounts,
}

/// How often and how long a role fell silent while the mission was under way.
#[derive(Clone, Copy, Debug, Default)]
struct Silence {
    now: bool,
    count: u64,
    longest_ns: u64,
}

impl Watcher {
    /// A watcher who knows nothing yet.
    #[must_use]
    pub fn new(robot: RobotId) -> Self {
        let (peer_table, heard) = (PeerTable::default(), BTreeMap::new());
        Self { robot, mission: None, peer_table, heard, began: None, shown: None }
    }

    /// Takes note of `event` at `now` and says what is to be done.
    pub fn on(&mut self, event: Event, now: MonotonicNs) -> Vec<Effect> {
        self.began.get_or_insert(now);
        match event {
            Event::Brief(brief) => self.brief(brief),
            Event::State(state) => return self.state(state, now),
            Event::Team(team) => {
                let mission = self.mission.as_mut().filter(|mission| mission.brief.run == team.run);
                mission.into_iter().for_each(|mission| mission.robots = team.members.to_vec());
            }
            Event::Map(map) => self.map(&map),
            Event::Heartbeat(beat) => self.heartbeat(beat, now),
            Event::Past(page) => return self.past(&page, now),
            Event::Refused(refusal) => {
                if let Some(mission) = &mut self.mission {
                    mission.refusals.count(&refusal);
                }
            }
            Event::Tick => return self.tick(now),
        }
        Vec::new()
    }

    /// How the mission stands at `now`; `None` before the first brief.
    #[must_use]
    pub fn progress(&self, now: MonotonicNs) -> Option<Progress> {
        let mission = self.mission.as_ref()?;
        let Mission { brief, tally, coverage, refusals, .. } = mission;
        let total = tally.latency.total();
        Some(Progress {
            run: brief.run,
            scenario: brief.scenario,
            status: mission.status(),
            decision: mission.decision(),
            missing: mission.missing(),
            steps: mission.state.map_or(tally.steps(), |state| state.steps.max(tally.steps())),
            steps_max: brief.limits.steps_max,
            distance_to_goal_m: mission.distance_to_goal_m(),
            start_to_goal_m: tally.start_to_goal_m(),
            stray_hops: tally.route.stray(),
            treasures: tally.treasures(),
            visits: mission.visits(),
            hops_max: brief.visits().map(|visit| visit.hops_max),
            vetoes: tally.vetoes,
            fallbacks: tally.fallbacks,
            coverage: *coverage,
            latency: Pulse {
                decisions: tally.latency.decisions(),
                last_us: tally.last.map_or(0.0, |last| last.timing.total_ns() as f64 / 1e3),
                p50_us: total.p50_us,
                p99_us: total.p99_us,
                budget_us: brief.limits.decision_budget_ns as f64 / 1e3,
                misses: tally.latency.misses(),
            },
            planners: tally.planners.clone(),
            measure: TeamMeasure::of(brief),
            robots: mission.robots.clone(),
            health: OTHERS.map(|role| self.health(mission, role, now)).into(),
            unplanned: self.unplanned(now).iter().collect(),
            refusals: refusals.clone(),
        })
    }

    /// Everything folded so far; `None` before the first brief.
    #[must_use]
    pub fn tally(&self) -> Option<&Tally> {
        self.mission.as_ref().map(|mission| &mission.tally)
    }

    /// Latency by stage so far; `None` before the first brief.
    #[must_use]
    pub fn latency(&self) -> Option<LatencyReport> {
        self.tally().map(|tally| tally.latency.report())
    }

    /// The run, decision and status for the heartbeat: only what is taken account of, so that
    /// hopper-sim lingers until the past has answered; and the end only once it was shown ([`Effect::Finished`]),
    /// since `hopper run` stops its monitor soon after hopper-sim has left.
    #[must_use]
    pub fn seen(&self) -> (RunId, Decision, Status) {
        match &self.mission {
            Some(mission) if mission.state.is_some() => {
                let is_shown = mission.finished || !mission.status().is_over();
                let status =
                    if mission.missing() == 0 && is_shown { mission.status() } else { Status::Underway };
                (mission.brief.run, mission.tally.due(), status)
            }
            _ => (RunId::default(), Decision(0), Status::Underway),
        }
    }

    /// What is missing, if anything.
    #[must_use]
    pub fn waits_for(&self) -> Option<&'static str> {
        match &self.mission {
            None => Some("hopper-sim: no brief yet"),
            Some(mission) if mission.state.is_none() => Some("hopper-sim: no state yet"),
            Some(_) => None,
        }
    }

    /// Processes whose heartbeat has not run out.
    #[must_use]
    pub fn peer_table(&self) -> &PeerTable {
        &self.peer_table
    }

    fn brief(&mut self, brief: Brief) {
        if self.mission.as_ref().is_some_and(|mission| mission.brief.run == brief.run) {
            return;
        }
        self.mission = Some(Mission {
            brief: brief.clone(),
            tally: Tally::new(&brief),
            past: PastFollower::default(),
            state: None,
            robots: Vec::new(),
            coverage: None,
            mapped: None,
            ended: None,
            finished: false,
            silences: BTreeMap::new(),
            refusals: RefusalCounts::default(),
        });
    }

    fn heartbeat(&mut self, beat: Heartbeat, now: MonotonicNs) {
        self.peer_table.observe(beat, now);
        // A counter that stands still is not heard.
        if self.peer_table.peer(beat.incarnation).is_some_and(|peer| peer.advanced == now) {
            self.heard.insert(beat.role, (beat.pid, now));
        }
    }

    fn state(&mut self, state: State, now: MonotonicNs) -> Vec<Effect> {
        let robot = self.robot;
        let Some(mission) = self.mission.as_mut().filter(|mission| mission.brief.run == state.run) else {
            return Vec::new();
        };
        if !state.is_news(mission.brief.robots.count(), mission.state.as_ref()) {
            return Vec::new();
        }
        let was_whole = mission.missing() == 0;
        if mission.past.is_contradicted_by(&state) && !mission.past.is_late(&state) {
            mission.begin_anew();
        }
        mission.state = Some(state);
        if mission.past.is_next(&state)
            && let Some(executed) = Executed::before(&state)
        {
            mission.tally.fold(&executed);
            mission.past.fold_state(&state);
        }
        let mut effects = Vec::new();
        // A gap is asked for when it opens, then at the ticks.
        if was_whole && mission.missing() > 0 {
            effects.extend(mission.request(robot, now));
        }
        effects.extend(self.finish(now));
        effects
    }

    fn map(&mut self, patch: &MapPatch) {
        let Some(mission) = self.mission.as_mut().filter(|mission| mission.brief.run == patch.run) else {
            return;
        };
        let whole = patch.more == 0
            && patch.robot.0 < mission.brief.robots.count()
            && patch.grid == mission.brief.grid;
        if whole && mission.mapped.is_none_or(|mapped| patch.through >= mapped) {
            mission.mapped = Some(patch.through);
            mission.coverage = Some(f64::from(patch.seen_cells) / patch.grid.cells() as f64);
        }
    }

    fn past(&mut self, page: &PastPage, now: MonotonicNs) -> Vec<Effect> {
        let robot = self.robot;
        let Some(mission) = self.mission.as_mut().filter(|mission| mission.brief.run == page.run) else {
            return Vec::new();
        };
        if page.robot != robot {
            return Vec::new();
        }
        let due = mission.tally.due();
        let robots = mission.brief.robots.count();
        for record in page.records.iter().filter(|record| record.robot.0 < robots) {
            match mission.past.link(record) {
                Link::Next => {
                    mission.tally.fold(&Executed::from(record));
                    mission.past.fold(record);
                }
                Link::OtherDecision => {}
                Link::Broken => {
                    let need = mission.tally.last.map_or_else(String::new, |last| {
                        format!("{} of decision {}", last.digest, last.decision)
                    });
                    mission.refusals.count(&Refusal::malformed("past.previous", &need, record.previous));
                    break;
                }
                Link::PastIsLost => {
                    mission.begin_anew();
                    break;
                }
            }
        }
        // An answer without news is asked for again at a later tick, not at once.
        let mut effects = Vec::new();
        if mission.tally.due() > due && mission.missing() > 0 {
            effects.extend(mission.request(robot, now));
        }
        effects.extend(self.finish(now));
        effects
    }

    fn tick(&mut self, now: MonotonicNs) -> Vec<Effect> {
        self.listen(now);
        let mut effects = Vec::new();
        if let Some(mission) =
            self.mission.as_mut().filter(|mission| mission.missing() > 0 && !mission.finished)
        {
            effects.extend(mission.request(self.robot, now));
        }
        let finish = self.finish(now);
        let due = self.shown.is_none_or(|shown| now.since_ns(shown) >= PROGRESS_PERIOD_NS);
        if finish.is_empty() && due {
            self.shown = Some(now);
            effects.extend(self.progress(now).map(|progress| Effect::Progress(Box::new(progress))));
        }
        effects.extend(finish);
        effects
    }

    /// Ends the mission once it is over and whole, or over, not whole, and hopper-sim is gone.
    fn finish(&mut self, now: MonotonicNs) -> Vec<Effect> {
        let sim_lives = self.peer_table.has(Role::HopperSim, now);
        let Some(mission) = self.mission.as_mut().filter(|mission| mission.status().is_over()) else {
            return Vec::new();
        };
        let ended = *mission.ended.get_or_insert(now);
        let given_up = !sim_lives && now.since_ns(ended) > SILENCE_NS;
        let whole = mission.missing() == 0;
        // The last map is a nicety: perception may be gone, or may never have been there.
        let mapped = mission.mapped.is_none_or(|mapped| mapped == mission.decision())
            || now.since_ns(ended) > LAST_MAP_NS;
        if mission.finished || !(whole && mapped || given_up) {
            return Vec::new();
        }
        mission.finished = true;
        let status = mission.status();
        let progress = self.progress(now).map(|progress| Effect::Progress(Box::new(progress)));
        progress.into_iter().chain([Effect::Finished(status)]).collect()
    }

    /// Takes note of roles that fall silent while the mission is under way, and for how long.
    fn listen(&mut self, now: MonotonicNs) {
        let Some(mission) = self.mission.as_mut().filter(|mission| !mission.status().is_over()) else {
            return;
        };
        for (&role, &(_, heard)) in &self.heard {
            let silent_ns = now.since_ns(heard);
            let silence = mission.silences.entry(role).or_default();
            let silent = silent_ns > SILENCE_NS;
            silence.count += u64::from(silent && !silence.now);
            silence.now = silent;
            if silent {
                silence.longest_ns = silence.longest_ns.max(silent_ns);
            }
        }
    }

    /// The robots that act, as the living hopper-sim tells, and for which no planner plans; none if there is no planner at all,
    /// and while not everybody can have been heard.
    fn unplanned(&self, now: MonotonicNs) -> RobotSet {
        let has_listened = self.began.is_some_and(|began| now.since_ns(began) >= SILENCE_NS);
        let sim = self.peer_table.live(now).find(|peer| peer.beat.role == Role::HopperSim);
        match sim {
            Some(sim) if has_listened && self.peer_table.has(Role::Planner, now) => {
                self.peer_table.without_planner(sim.beat.robots, now)
            }
            _ => RobotSet::NONE,
        }
    }

    fn health(&self, mission: &Mission, role: Role, now: MonotonicNs) -> Health {
        let heard = self.heard.get(&role);
        let silence = mission.silences.get(&role).copied().unwrap_or_default();
        Health {
            role,
            alive: self.peer_table.live(now).filter(|peer| peer.beat.role == role).count(),
            pid: heard.map(|&(pid, _)| pid),
            silent_ms: heard.map(|&(_, heard)| heard).or(self.began).map_or(0, |since| now.since_ns(since))
                / 1_000_000,
            silences: silence.count,
            longest_silence_ms: silence.longest_ns / 1_000_000,
        }
    }
}

impl Mission {
    /// Drops the decisions of a past that is no longer the journal's.
    fn begin_anew(&mut self) {
        self.tally = Tally::new(&self.brief);
        self.past = PastFollower::default();
        (self.ended, self.finished) = (None, false);
    }

    /// Where the hopper is known to stand: the state or, where the past is ahead of it, the tally.
    fn decision(&self) -> Decision {
        self.state.map_or(self.tally.due(), |state| state.decision.max(self.tally.due()))
    }

    /// Decisions executed that are not in the tally yet.
    fn missing(&self) -> u64 {
        self.decision().0 - self.tally.due().0
    }

    fn status(&self) -> Status {
        let state = self.state.filter(|state| state.decision >= self.tally.due());
        state.map_or(self.tally.status(), |state| state.status)
    }

    fn distance_to_goal_m(&self) -> Option<f64> {
        let state = self.state.filter(|state| state.decision >= self.tally.due());
        let cell = state.map_or(self.tally.cell(), |state| state.pose.cell);
        self.tally.distance_m(cell, self.visits())
    }

    fn visits(&self) -> u64 {
        let state = self.state.filter(|state| state.decision >= self.tally.due());
        state.map_or(self.tally.visits(), |state| state.visits)
    }

    fn request(&mut self, robot: RobotId, now: MonotonicNs) -> Option<Effect> {
        self.past.ask(self.brief.run, robot, now).map(Effect::RequestPast)
    }
}
