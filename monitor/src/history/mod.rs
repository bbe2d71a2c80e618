//! The history of a mission, for page and terminal: public messages in, frames out.
//!
//! It only grows: hops in order, cells in the order they were seen, processes that joined or fell silent. A reader
//! holds a [`Cursor`] into it and takes [`Frame`]s at its own speed, so late, slow and fast readers share one
//! mechanism without a queue that could fill.

mod announcements;
mod details;
mod frame;
mod hops;
mod layers;
mod peers;
pub mod reason;
mod seen_cells;
mod speeds;

use contract::{
    Brief, Cell, Collected, Decision, DetailPage, DetailRequest, Heartbeat, Incarnation, MapPage, MapPatch,
    MapRequest, MissingPeer, MonotonicNs, Name, ObservedMap, Pacing, PastPage, Policy, PriorPage,
    PriorRequest, RobotId, Role, RoutePage, RouteRequest, State, TablePage, TableRequest, Team,
};
use follow::{Link, PastFollower, Replica, TableFollower};
use report::layers::Value;
use report::{Executed, Layer};
use speed_layer::SpeedLayer;

pub use announcements::{Announced, Announcements};
pub use details::{DETAILS_KEPT, Details, Told};
pub use frame::{CELLS_A_FRAME, Cursor, Frame, HOPS_A_FRAME, POLICY_SIDE_MAX};
pub use hops::{HOPS_KEPT, Hop, Hops, LeaderChange};
pub use peers::{EVENTS_KEPT, Peer, PeerChange, PeerEvent, PeerHistory};
pub use reason::{Chances, HopReason, Reason};
pub use seen_cells::{Seen, SeenCells};

use crate::Progress;
use speeds::Speeds;

/// Shortest time between two requests for the whole map, nanoseconds: a monitor that cannot follow the patches must
/// not keep perception busy.
const SNAPSHOT_PERIOD_NS: u64 = 1_000_000_000;

/// A message for the history, or the passing of time.
#[derive(Clone, Debug)]
pub enum Input<'a> {
    /// The brief of a run; a new run begins a new history.
    Brief(&'a Brief),
    /// The state after a decision.
    State(&'a State),
    /// A page of executed decisions that was requested.
    Past(&'a PastPage),
    /// Cells of the observed map that a landing changed.
    Patch(MapPatch),
    /// A page of the observed map; pass all patches received before it first.
    Page(&'a MapPage),
    /// All robots at one decision.
    Team(&'a Team),
    /// A page of the prior that was requested.
    Prior(PriorPage),
    /// A page of the motion table that was requested.
    Table(TablePage),
    /// A route that was requested.
    Route(&'a RoutePage),
    /// What the motion model tells of a decision, as requested.
    Detail(&'a DetailPage),
    /// A sign of life of a process.
    Heartbeat(&'a Heartbeat),
    /// Policy of the planner in command.
    Policy(Policy),
    /// How hopper-sim paces landings.
    Pacing(Pacing),
    /// Time has passed.
    Tick,
}

/// What the history needs of hopper-sim beside what is published: see [`History::wanted`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// A page of the prior.
    pub prior: Option<PriorRequest>,
    /// A page of the motion table that planners believe.
    pub table: Option<TableRequest>,
    /// The points of a route.
    pub route: Option<RouteRequest>,
    /// What the motion model tells of a decision.
    pub detail: Option<DetailRequest>,
}

/// The history of one robot's mission.
#[derive(Debug)]
pub struct History {
    robot: RobotId,
    /// The instance that the processes are in, where that is not the default.
    instance: Option<String>,
    /// Number of runs so far; a cursor of another run starts over.
    epoch: u64,
    run: Option<RunHistory>,
    peers: PeerHistory,
    pacing: Option<Pacing>,
    /// Newest progress report, with its number.
    progress: (u64, Option<Progress>),
    /// Whether the mission is read from a file, and no process adds to it.
    past: bool,
}

/// The history of one run.
#[derive(Debug)]
struct RunHistory {
    brief: Brief,
    state: Option<State>,
    hops: Hops,
    /// The decisions of the hops.
    past: PastFollower,
    replica: Replica,
    seen_cells: SeenCells,
    /// Whether the map was complete when last checked, and when it last became complete.
    whole: (bool, Option<MonotonicNs>),
    /// Newest policy, with its number.
    policy: (u64, Option<Policy>),
    /// All robots as of their newest message; `None` where there is a single hopper.
    team: Option<Team>,
    announcements: Announcements,
    details: Details,
    speeds: Speeds,
    table: TableFollower,
}

impl History {
    /// Knows nothing but whom to follow.
    #[must_use]
    pub fn new(robot: RobotId) -> Self {
        Self {
            robot,
            instance: None,
            epoch: 0,
            run: None,
            peers: PeerHistory::default(),
            pacing: None,
            progress: (0, None),
            past: false,
        }
    }

    /// This history, with the name of the instance that the processes are in; `None` for the
    /// default.
    #[must_use]
    pub fn in_instance(self, instance: Option<&str>) -> Self {
        Self { instance: instance.map(str::to_owned), ..self }
    }

    /// Adds `input`, received at `now`. Returns the request to send to perception, if one is due.
    pub fn on(&mut self, input: Input<'_>, now: MonotonicNs) -> Option<MapRequest> {
        match input {
            Input::Brief(brief) => self.begin_run(brief),
            Input::Heartbeat(beat) => self.peers.heartbeat(beat, self.decision(), now),
            Input::Pacing(pacing) => self.pacing = Some(pacing),
            Input::Tick => {
                let over = self.progress.1.as_ref().is_some_and(|progress| progress.status.is_over());
                self.peers.mark_silent(self.decision(), over, now);
                return self.run.as_mut().and_then(|run| run.catch_up(now));
            }
            Input::State(state) => {
                if self.of_run(state.run)?.is_contradicted_by(state) {
                    self.begin_anew();
                }
                self.of_run(state.run)?.state(state);
            }
            Input::Past(page) => {
                if !self.of_run(page.run)?.past(page) {
                    self.begin_anew();
                }
            }
            Input::Patch(patch) => return self.of_run(patch.run)?.patch(patch, now),
            Input::Page(page) => return self.of_run(page.run)?.page(page, now),
            Input::Team(team) => self.of_run(team.run)?.team(team),
            Input::Prior(page) => self.of_run(page.run)?.prior(page),
            // What is no page of the brief's table is asked for again.
            Input::Table(page) => drop(self.of_run(page.run)?.table.page(page)),
            Input::Route(page) => self.of_run(page.run)?.announcements.page(page),
            Input::Detail(page) => self.of_run(page.run)?.details.page(page),
            Input::Policy(policy) => {
                let known = &mut self.of_run(policy.run)?.policy;
                *known = (known.0 + 1, Some(policy));
            }
        }
        None
    }

    /// What is missing of the prior, of the motion table, of announced routes and of details, if it is to be requested at `now`.
    /// Nothing where a hopper goes alone under the law.
    pub fn wanted(&mut self, now: MonotonicNs) -> Wanted {
        let Some(run) = &mut self.run else { return Wanted::default() };
        let route = run.announcements.ask(run.brief.run, now);
        Wanted { prior: run.speeds.ask(now), table: run.table.ask(now), route, detail: run.details.ask(now) }
    }

    /// Whether what the motion model told of some decision is missing.
    #[must_use]
    pub fn lacks_details(&self) -> bool {
        self.run.as_ref().is_some_and(|run| run.details.is_missing())
    }

    /// Whether rows of the motion table are missing that planners believe.
    #[must_use]
    pub fn lacks_table(&self) -> bool {
        self.run.as_ref().is_some_and(|run| run.table.is_missing())
    }

    /// Whether part of the prior or of the announced routes is missing.
    #[must_use]
    pub fn lacks_pages(&self) -> bool {
        let lacks = |run: &RunHistory| {
            run.brief.sampling.is_some() && run.speeds.layer().is_none() || run.announcements.lacks_points()
        };
        self.run.as_ref().is_some_and(lacks)
    }

    /// Whether the mission is over and the map of its end is not there.
    #[must_use]
    pub fn lacks_last_map(&self) -> bool {
        self.run.as_ref().is_some_and(RunHistory::lacks_last_map)
    }

    /// Replaces the progress report.
    pub fn set_progress(&mut self, progress: Progress) {
        self.progress = (self.progress.0 + 1, Some(progress));
    }

    /// Nothing more will come: a mission without an outcome was interrupted.
    pub fn end(&mut self) {
        self.past = true;
    }

    /// Whether nothing more will come although the mission has no outcome.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        let over = self.progress().is_some_and(|progress| progress.status.is_over());
        self.past && !over
    }

    /// Brief of the current run; `None` before the first.
    #[must_use]
    pub fn brief(&self) -> Option<&Brief> {
        self.run.as_ref().map(|run| &run.brief)
    }

    /// Newest state of the run.
    #[must_use]
    pub fn state(&self) -> Option<&State> {
        self.run.as_ref()?.state.as_ref()
    }

    /// Executed decisions of the run.
    #[must_use]
    pub fn hops(&self) -> Option<&Hops> {
        self.run.as_ref().map(|run| &run.hops)
    }

    /// Cells seen in the run.
    #[must_use]
    pub fn seen_cells(&self) -> Option<&SeenCells> {
        self.run.as_ref().map(|run| &run.seen_cells)
    }

    /// Treasures that were seen but not collected when decision `at` was due.
    #[must_use]
    pub fn treasures(&self, at: Decision) -> Vec<Cell> {
        let Some(RunHistory { brief, hops, seen_cells, .. }) = &self.run else { return Vec::new() };
        let at = at.max(hops.first());
        // Nothing is known about hops before the first one kept.
        let known = at.0.checked_sub(1).map(|before| hops.get(Decision(before)).or_else(|| hops.get(at)));
        let mut collected = known.flatten().map_or(Collected::default(), |hop| hop.collected);
        let mut lying = seen_cells.treasures().to_vec();
        for hop in hops.from(at) {
            if hop.collected != collected && !lying.contains(&hop.to) {
                lying.push(hop.to);
            }
            collected = hop.collected;
        }
        let seen = |cell: &Cell| brief.grid.index(*cell).and_then(|index| seen_cells.get(index));
        lying.retain(|cell| seen(cell).is_some_and(|seen| u64::from(seen.at) <= at.0));
        lying
    }

    /// Expected speeds of uncertain ground; `None` elsewhere, and until the prior is gathered.
    #[must_use]
    pub fn speeds(&self) -> Option<&SpeedLayer> {
        self.run.as_ref()?.speeds.layer()
    }

    /// What a layer with a scale shows of the cell at `index`, of which `seen` is known, in the layer's unit.
    #[must_use]
    pub fn value(&self, layer: Layer, index: usize, seen: Option<&Seen>) -> Option<f64> {
        match layer.scale()?.value {
            Value::Speed { of, .. } => {
                let (speed, reading) = seen.map_or((None, None), |seen| (seen.speed, seen.reading));
                let estimate = self.speeds()?.estimate(index, speed, reading)?;
                Some(of(estimate.mean_and_sd_m_per_sol()))
            }
            Value::Ground { .. } => {
                seen?;
                self.seen_cells()?.value(layer, index)
            }
        }
    }

    /// All robots as last published; `None` where there is a single hopper.
    #[must_use]
    pub fn team(&self) -> Option<&Team> {
        self.run.as_ref()?.team.as_ref()
    }

    /// The robots that a life commands, by the last state or, of several robots, the last team.
    #[must_use]
    pub fn led_by(&self, life: Incarnation) -> Vec<RobotId> {
        let alone = self.state().filter(|state| state.leader.incarnation == life).map(|state| state.robot);
        self.team().map_or_else(|| alone.into_iter().collect(), |team| team.led_by(life).collect())
    }

    /// A living planner that commands no robot, if there is one.
    #[must_use]
    pub fn stand_by(&self) -> Option<Peer> {
        let peers = self.peers.peers().into_iter();
        let mut planners = peers.filter(|peer| peer.beat.role == Role::Planner && !peer.silent);
        planners.find(|peer| self.led_by(peer.beat.incarnation).is_empty())
    }

    /// Routes that were announced in the run.
    #[must_use]
    pub fn announcements(&self) -> Option<&Announcements> {
        self.run.as_ref().map(|run| &run.announcements)
    }

    /// What the motion model told of the hops of the run.
    #[must_use]
    pub fn details(&self) -> Option<&Details> {
        self.run.as_ref().map(|run| &run.details)
    }

    /// Newest policy of the run.
    #[must_use]
    pub fn policy(&self) -> Option<&Policy> {
        self.run.as_ref()?.policy.1.as_ref()
    }

    /// Processes that were heard, and when they joined or fell silent.
    #[must_use]
    pub fn peers(&self) -> &PeerHistory {
        &self.peers
    }

    /// The process without which the mission cannot go on although hopper-sim lives: a perception, else a planner of robots
    /// that still act; `None` once the mission is over.
    #[must_use]
    pub fn missing_peer(&self) -> Option<MissingPeer> {
        if self.progress().is_none_or(|progress| progress.status.is_over()) {
            return None;
        }
        self.peers.missing()
    }

    /// What starts [`History::missing_peer`].
    #[must_use]
    pub fn remedy(&self) -> Option<String> {
        let missing = self.missing_peer()?;
        Some(missing.command(self.instance.as_deref()) + missing.and_others())
    }

    /// How hopper-sim paces landings; `None` until it says so.
    #[must_use]
    pub fn pacing(&self) -> Option<&Pacing> {
        self.pacing.as_ref()
    }

    /// The newest that was set; `None` before the first.
    #[must_use]
    pub fn progress(&self) -> Option<&Progress> {
        self.progress.1.as_ref()
    }

    fn of_run(&mut self, run: contract::RunId) -> Option<&mut RunHistory> {
        self.run.as_mut().filter(|known| known.brief.run == run)
    }

    fn decision(&self) -> Decision {
        self.run.as_ref().map_or(Decision(0), RunHistory::decision)
    }

    fn begin_run(&mut self, brief: &Brief) {
        if self.run.as_ref().is_some_and(|run| run.brief.run == brief.run) {
            return;
        }
        self.epoch += 1;
        self.progress.1 = None;
        self.peers.forget_events();
        self.run = Some(RunHistory::new(self.robot, brief));
    }

    /// Begins the history of the run again: the journal has lost its tail, or was flown on elsewhere.
    fn begin_anew(&mut self) {
        if let Some(run) = self.run.take() {
            self.begin_run(&run.brief);
        }
    }
}

impl RunHistory {
    fn new(robot: RobotId, brief: &Brief) -> Self {
        let mut replica = Replica::new(robot);
        replica.begin(brief);
        let mut speeds = Speeds::default();
        speeds.begin(brief);
        let mut details = Details::default();
        details.begin(brief.run);
        let mut table = TableFollower::default();
        table.begin(brief);
        Self {
            brief: brief.clone(),
            state: None,
            hops: Hops::default(),
            past: PastFollower::default(),
            replica,
            seen_cells: SeenCells::new(brief),
            whole: (false, None),
            policy: (0, None),
            team: None,
            announcements: Announcements::default(),
            details,
            speeds,
            table,
        }
    }

    /// The planner that commanded `robot` at the executed decision `at`; `None` while it is due.
    fn planner_of(&self, robot: RobotId, at: Decision) -> Option<Name> {
        self.hops.get(at)?;
        let mut changes = self.hops.leader_changes().rev();
        changes.find(|change| change.robot == robot && change.from <= at).map(|change| change.planner)
    }

    fn decision(&self) -> Decision {
        self.state.map_or(self.hops.due(), |state| state.decision.max(self.hops.due()))
    }

    /// Whether `state` proves that hops of this history are no longer in the journal.
    fn is_contradicted_by(&self, state: &State) -> bool {
        let is_news =
            state.is_news(self.brief.robots.count(), self.state.as_ref()) && !self.past.is_late(state);
        is_news && self.past.is_contradicted_by(state)
    }

    fn state(&mut self, state: &State) {
        if !state.is_news(self.brief.robots.count(), self.state.as_ref()) {
            return;
        }
        self.state = Some(*state);
        if self.past.is_next(state)
            && let Some(executed) = Executed::before(state)
        {
            self.hops.fold(&executed);
            self.past.fold_state(state);
            self.details.state(&self.brief.robots, state);
        }
    }

    /// Adds the records that are due. False if the hops so far are not in the journal.
    fn past(&mut self, page: &PastPage) -> bool {
        let robots = self.brief.robots.count();
        for record in page.records.iter().filter(|record| record.robot.0 < robots) {
            if record.decision < self.hops.due() {
                self.announcements.record(record);
            }
            match self.past.link(record) {
                Link::Next => {
                    self.hops.fold(&Executed::from(record));
                    self.past.fold(record);
                    self.announcements.record(record);
                    self.details.record(record);
                }
                Link::OtherDecision => {}
                Link::Broken => return true,
                Link::PastIsLost => return false,
            }
        }
        true
    }

    fn team(&mut self, team: &Team) {
        self.announcements.team(team);
        self.team = Some(team.clone());
    }

    fn prior(&mut self, page: PriorPage) {
        self.speeds.page(page, &self.brief.robots);
    }

    fn patch(&mut self, patch: MapPatch, now: MonotonicNs) -> Option<MapRequest> {
        let request = self.replica.patch(patch, now);
        self.allowed(request, now)
    }

    fn page(&mut self, page: &MapPage, now: MonotonicNs) -> Option<MapRequest> {
        let request = self.replica.page(page, now);
        self.allowed(request, now)
    }

    /// Whether the mission is over and the map of its end is not there.
    fn lacks_last_map(&self) -> bool {
        let is_there = |state: &State| self.replica.map().is_some_and(|map| map.is_of(state));
        self.state.as_ref().is_some_and(|state| state.status.is_over() && !is_there(state))
    }

    /// The request, unless the map became complete a moment ago. At the end of the mission there is no time to wait.
    fn allowed(&mut self, request: Option<MapRequest>, now: MonotonicNs) -> Option<MapRequest> {
        let (was_whole, since) = self.whole;
        let is_whole = self.replica.map().is_some();
        self.whole = (is_whole, if is_whole && !was_whole { Some(now) } else { since });
        let is_late = self.whole.1.is_none_or(|since| now.since_ns(since) >= SNAPSHOT_PERIOD_NS);
        if is_late || self.lacks_last_map() { request } else { None }
    }

    /// Adds newly seen cells once the hops they were seen from are known.
    fn catch_up(&mut self, now: MonotonicNs) -> Option<MapRequest> {
        let through = |map: &ObservedMap| map.through.map_or(u64::MAX, |through| through.0);
        if let Some(map) = self.replica.map().filter(|map| through(map) <= self.hops.due().0) {
            self.seen_cells.learn(map, &self.hops);
        }
        let request = self.replica.ask(now);
        self.allowed(request, now)
    }
}
