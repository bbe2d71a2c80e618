//! The state machine of perception: poses in, maps out.
//!
//! It needs the brief, the terrain and the state of one run, in any order; poses it has missed come
//! from `hop/past`. What a landing reveals is published as patches, and whoever has missed one asks for the
//! map in pages. Nobody downstream decides before [`ObservedMap::through`] equals the state's decision, so
//! publishing late is safe, and publishing twice is harmless.
//!
//! Patches are numbered as a function of the poses alone: a cartographer that began anew goes on where the
//! one before it ended.

mod effect;
mod event;

use std::sync::Arc;

use contract::limits::{MAP_PAGE_CELLS, MAP_PAGE_SPAN, MAP_PATCH_CELLS};
use contract::{
    Account, Brief, Cell, Decision, Digest, Goal, MapPage, MapPatch, MapRequest, MonotonicNs, ObservedMap,
    PastPage, Pose, Record, Robot, RobotId, RunId, SeenCell, State, Status, TruthPage,
};
use follow::{Heard, Link, Mission, PastFollower, TruthFollower};
use terrain::Terrain;

pub use effect::Effect;
pub use event::Event;

use crate::sensing::{around, reports};
use crate::{Observation, Tracks};

/// While the hopper stands still, a reminder is published after this long, for whoever missed the last patch.
pub const REPUBLISH_NS: u64 = 100_000_000;

/// Folds poses into the observed map of a mission.
#[derive(Debug)]
pub struct Cartographer {
    robot: RobotId,
    /// Most cells of a patch.
    patch_cells: usize,
    mission: Mission,
    /// The robot whose pose was folded in last.
    actor: RobotId,
    terrain: Option<(RunId, Arc<Terrain>)>,
    truth: TruthFollower,
    observation: Option<Observation>,
    /// Where robots are that go from point to point.
    tracks: Tracks,
    /// Poses 0..folded are in the map.
    folded: u64,
    /// Which decisions led to those poses, and what is missing of the past.
    past: PastFollower,
    /// The decision whose landing is published; its map has its moment of sensing.
    stamped: Option<Decision>,
    published: Option<MonotonicNs>,
    finished: bool,
}

impl Cartographer {
    /// A cartographer who knows nothing yet.
    #[must_use]
    pub fn new(robot: RobotId) -> Self {
        Self {
            robot,
            patch_cells: MAP_PATCH_CELLS,
            mission: Mission::default(),
            actor: robot,
            terrain: None,
            truth: TruthFollower::default(),
            observation: None,
            tracks: Tracks::default(),
            folded: 0,
            past: PastFollower::default(),
            stamped: None,
            published: None,
            finished: false,
        }
    }

    /// This cartographer, publishing patches of at most `cells` cells: small ones make several of a
    /// landing on a small map. All lives of perception in a run need the same number.
    ///
    /// # Panics
    /// If that is none, or more than [`MAP_PATCH_CELLS`].
    #[must_use]
    pub fn with_patches_of(self, cells: usize) -> Self {
        assert!(
            (1..=MAP_PATCH_CELLS).contains(&cells),
            "a patch has 1 to {MAP_PATCH_CELLS} cells, not {cells}"
        );
        Self { patch_cells: cells, ..self }
    }

    /// Takes note of `event` at `now` and says what is to be done.
    pub fn on(&mut self, event: Event, now: MonotonicNs) -> Vec<Effect> {
        match event {
            Event::Brief(brief) => self.brief(brief),
            Event::Terrain(run, terrain) => {
                self.terrain = Some((run, terrain));
                self.truth = TruthFollower::default();
            }
            // By reference: a state is large, and copied once.
            Event::State(ref state) => {
                if self.mission.hear_state(state) == Heard::Nothing {
                    return Vec::new();
                }
            }
            Event::Past(page) => return self.past(&page, now),
            Event::Route(page) => {
                if !self.tracks.routes().page(page) {
                    return Vec::new();
                }
                // The record that needs it may be asked for at once.
                self.past.end_pause();
            }
            Event::Truth(page) => return self.truth(page, now),
            Event::Tick => return self.tick(now),
        }
        self.advance(now)
    }

    /// What is to be published: the patches of the last landing, or a reminder if they are out already. The
    /// `clock` is read once they are made.
    ///
    /// # Panics
    /// If nothing has been folded yet; only [`Effect::PublishMap`] asks for it.
    pub fn patches(&mut self, sensed: MonotonicNs, clock: &mut dyn FnMut() -> MonotonicNs) -> Vec<MapPatch> {
        let observation = self.observation.as_mut().expect("a map is published only once it exists");
        let map = observation.map_mut();
        let news = self.stamped != map.through;
        if news {
            self.stamped = map.through;
            map.sensed = sensed;
        }
        let map = observation.map();
        let reminder = MapPatch {
            run: map.run,
            robot: self.actor,
            through: map.through.expect("a map is published only once it exists"),
            digest: map.digest,
            more: 0,
            sequence: map.sequence,
            before: map.observation(),
            after: map.observation(),
            sensed: map.sensed,
            published: map.published,
            grid: map.grid,
            seen_cells: map.seen_cells() as u32,
            treasures: map.treasures().to_vec(),
            cells: Vec::new(),
        };
        let mut patches: Vec<MapPatch> = if news {
            let parts = observation.parts();
            let count = parts.len();
            parts
                .enumerate()
                .map(|(part, ([before, after], seen_cells, indices))| {
                    let more = (count - 1 - part) as u32;
                    let sequence = map.sequence - u64::from(more);
                    let mut cells = Vec::with_capacity(indices.len());
                    cells.extend(indices.iter().filter_map(|&index| seen_cell(map, index as usize)));
                    let treasures = if more == 0 { map.treasures() } else { observation.treasures_before() };
                    let treasures = treasures.to_vec();
                    MapPatch { more, sequence, before, after, seen_cells, treasures, cells, ..reminder }
                })
                .collect()
        } else {
            vec![reminder]
        };
        if news {
            // A reminder keeps the moments of its landing: who waits for a planner does not wait for the map.
            let published = clock();
            observation.map_mut().published = published;
            patches.iter_mut().for_each(|patch| patch.published = published);
        }
        patches
    }

    /// The page that answers `request`; `None` while it cannot be answered, because the map is not up to the
    /// state or its last landing is not published yet.
    #[must_use]
    pub fn page(&self, request: &MapRequest) -> Option<MapPage> {
        let map = self.observation.as_ref()?.map();
        let through = map.through?;
        if !self.caught_up() || self.stamped != map.through {
            return None;
        }
        if (request.run, request.robot) != (map.run, map.robot) {
            return None;
        }
        let whole = map.grid.cells();
        let from = (request.from as usize).min(whole);
        let mut next = from;
        let mut cells = Vec::new();
        if request.observation == map.observation() {
            next = whole;
        } else {
            while next < whole && next < from + MAP_PAGE_SPAN && cells.len() < MAP_PAGE_CELLS {
                cells.extend(seen_cell(map, next));
                next += 1;
            }
        }
        Some(MapPage {
            run: map.run,
            robot: map.robot,
            through,
            digest: map.digest,
            sequence: map.sequence,
            observation: map.observation(),
            sensed: map.sensed,
            published: map.published,
            grid: map.grid,
            from: from as u32,
            next: next as u32,
            treasures: map.treasures().to_vec(),
            cells,
        })
    }

    /// The map so far.
    #[must_use]
    pub fn map(&self) -> Option<&ObservedMap> {
        self.observation.as_ref().map(Observation::map)
    }

    /// The map so far, of a cartographer who is no longer needed.
    #[must_use]
    pub fn into_map(self) -> Option<ObservedMap> {
        self.observation.map(Observation::into_map)
    }

    /// The run, decision and status last seen, for the heartbeat. A run is known once its terrain is.
    #[must_use]
    pub fn seen(&self) -> (RunId, Decision, Status) {
        match (self.mission.state(), self.current()) {
            (Some(state), true) => (state.run, state.decision, state.status),
            _ => (self.grounded().unwrap_or_default(), Decision(0), Status::Underway),
        }
    }

    /// What is missing, if anything.
    #[must_use]
    pub fn waits_for(&self) -> Option<&'static str> {
        if self.mission.brief().is_none() {
            Some("hopper-sim: no brief yet")
        } else if self.terrain.is_none() {
            Some("hopper-sim: no terrain yet")
        } else if self.mission.state().is_none() {
            Some("hopper-sim: no state yet")
        } else if !self.current() {
            Some("hopper-sim: brief, terrain and state of one run")
        } else if !self.caught_up() {
            Some("hopper-sim: the past of this run")
        } else {
            None
        }
    }

    fn brief(&mut self, brief: Brief) {
        // Another brief of the same run is somebody's error; the map of the one is none of the other.
        let before = self.mission.hear_brief(brief.clone());
        if before.as_ref() != Some(&brief) {
            if self.terrain.as_ref().is_none_or(|(run, _)| *run != brief.run) {
                self.truth.begin(brief.run);
            }
            self.forget();
        }
    }

    fn truth(&mut self, page: TruthPage, now: MonotonicNs) -> Vec<Effect> {
        match self.truth.page(page) {
            Ok(Some(truth)) => {
                let (grid, cells, treasures) = (truth.grid, truth.cells, truth.treasures);
                let terrain = Terrain { grid, cells, treasures, prior: Vec::new() };
                self.terrain = Some((truth.run, terrain.into()));
                self.advance(now)
            }
            Ok(None) => self.truth.ask(now).map(Effect::RequestTruth).into_iter().collect(),
            Err(refusal) => vec![Effect::Refused(refusal)],
        }
    }

    /// Begins the map of the brief's run anew.
    fn forget(&mut self) {
        let unseen = |brief| Observation::unseen(brief, self.robot).cut_to(self.patch_cells);
        self.observation = self.mission.brief().map(unseen);
        self.tracks.forget();
        self.folded = 0;
        self.past = PastFollower::default();
        self.stamped = None;
        self.published = None;
        self.finished = false;
    }

    /// The run of which both brief and terrain are known.
    fn grounded(&self) -> Option<RunId> {
        let (brief, (run, terrain)) = (self.mission.brief()?, self.terrain.as_ref()?);
        (brief.run == *run && terrain.grid == brief.grid).then_some(*run)
    }

    /// Whether brief, terrain and state belong to one run.
    fn current(&self) -> bool {
        self.mission.state().is_some_and(|state| self.grounded() == Some(state.run))
    }

    /// Whether the map covers the state's pose.
    fn caught_up(&self) -> bool {
        self.current() && self.mission.state().is_some_and(|state| self.folded == state.decision.0 + 1)
    }

    /// Whether robots go from point to point. What they see then follows from the points, which only records have: the map is
    /// a fold over records alone, also of what a hopper among them sees.
    fn has_tracks(&self) -> bool {
        self.mission.brief().is_some_and(Brief::has_routes)
    }

    /// Folds in what all robots see from their starts, which are in the brief. Only the state of the start has its `digest`; without
    /// it no map of the start is published.
    fn fold_starts(&mut self, digest: Digest) {
        let (Some(brief), Some((_, terrain)), Some(observation)) =
            (self.mission.brief(), &self.terrain, &mut self.observation)
        else {
            return;
        };
        let on_tracks = if brief.has_routes() { self.tracks.begin(brief, terrain) } else { Vec::new() };
        let start = |cell: Cell| {
            let height_m = terrain.ground(cell).map_or(0.0, |ground| ground.height_m);
            Pose { cell, height_m }
        };
        let around_all = brief.robots.iter().flat_map(|robot| {
            let pose = start(robot.start.cell);
            around(brief.grid, robot.sensor, pose)
        });
        for robot in brief.robots.iter() {
            observation.note_reports(reports(brief.grid, robot.sensor, start(robot.start.cell)));
        }
        let covering = brief.robots.iter().filter(|robot| counts_visits(robot));
        let entered: Vec<Cell> = covering.map(|robot| robot.start.cell).collect();
        let landed = (brief.account == Account::Hopper).then_some(brief.robots[0].start.cell);
        let seen = on_tracks.into_iter().chain(around_all);
        observation.sense(terrain, seen, &entered, landed, Decision(0));
        observation.map_mut().digest = digest;
        self.actor = self.robot;
        self.folded = 1;
    }

    /// Folds in what `robot` sees around it at `pose`, and what it has seen `on_way` there. If a rover that covers ground
    /// `has_moved`, it visits the cell.
    fn fold(&mut self, robot: RobotId, pose: Pose, has_moved: bool, on_way: &[usize], digest: Digest) {
        let (Some(brief), Some((_, terrain)), Some(observation)) =
            (self.mission.brief(), &self.terrain, &mut self.observation)
        else {
            return;
        };
        let decision = Decision(self.folded);
        let here = pose.cell;
        let visits = has_moved && brief.robots.at(robot).is_some_and(counts_visits);
        let lands = brief.robots.at(robot).is_some_and(|robot| robot.body.hops());
        match brief.robots.at(robot).map(|robot| robot.sensor) {
            Some(sensor) => {
                observation.note_reports(reports(brief.grid, sensor, pose));
                let seen = on_way.iter().copied().chain(around(brief.grid, sensor, pose));
                if sensor.accuracy().is_some() {
                    observation.read(terrain, seen, decision);
                } else {
                    let entered = if visits { &[here][..] } else { &[] };
                    observation.sense(terrain, seen, entered, lands.then_some(here), decision);
                }
            }
            None => observation.sense(terrain, [], &[], None, decision),
        }
        observation.map_mut().digest = digest;
        self.actor = robot;
        self.folded += 1;
    }

    /// Folds in a record; false if the points of a route are missing, which is then asked for.
    fn fold_record(&mut self, record: &Record) -> bool {
        let on_way = if self.has_tracks() { self.tracks.fold(record) } else { Some(Vec::new()) };
        let Some(on_way) = on_way else { return false };
        let Record { robot, pose, outcome, digest, .. } = *record;
        self.fold(robot, pose, outcome.from != outcome.to, &on_way, digest);
        true
    }

    fn advance(&mut self, now: MonotonicNs) -> Vec<Effect> {
        if !self.current() {
            return Vec::new();
        }
        let Some(&state) = self.mission.state() else { return Vec::new() };
        // A start that was folded for a later state has no digest yet, and this state may be its own.
        let is_start_without_digest = !self.past.knows_its_past() && state.decision == Decision(0);
        if self.folded > 0 && (self.past.is_contradicted_by(&state) || is_start_without_digest) {
            // The journal has lost its tail, or was flown on elsewhere.
            self.forget();
        }
        if self.folded > state.decision.0 {
            return self.finish(state);
        }
        if self.folded == 0 {
            let is_start = state.decision == Decision(0);
            self.fold_starts(if is_start { state.digest } else { Digest::default() });
            if is_start {
                self.past.fold_state(&state);
            }
        }
        if self.folded == state.decision.0 && !self.has_tracks() {
            let has_moved = state.last.is_some_and(|outcome| outcome.from != outcome.to);
            self.fold(state.robot, state.pose, has_moved, &[], state.digest);
            self.past.fold_state(&state);
        }
        if self.caught_up() {
            return self.publish(&state, now);
        }
        if let Some(request) = self.tracks.routes().ask(now) {
            return vec![Effect::RequestRoute(request)];
        }
        self.request(state.run, now).into_iter().collect()
    }

    fn publish(&mut self, state: &State, now: MonotonicNs) -> Vec<Effect> {
        self.published = Some(now);
        let mut effects = vec![Effect::PublishMap];
        effects.extend(self.finish(*state));
        effects
    }

    /// Asks for the records whose poses are missing: record k leads to pose k + 1, and the brief has pose 0.
    fn request(&mut self, run: RunId, now: MonotonicNs) -> Option<Effect> {
        self.past.ask(run, self.robot, now).map(Effect::RequestPast)
    }

    fn past(&mut self, page: &PastPage, now: MonotonicNs) -> Vec<Effect> {
        let Some(&state) = self.mission.state() else { return Vec::new() };
        let is_wanted = self.current() && (page.run, page.robot) == (state.run, self.robot);
        if !is_wanted || self.caught_up() {
            return Vec::new();
        }
        let folded = self.folded;
        for record in &page.records {
            // Record k leads to pose k + 1; the state brings its own pose, but not the points of a way.
            let last = if self.has_tracks() { state.decision.0 } else { state.decision.0.saturating_sub(1) };
            if self.folded == 0 || self.folded > last {
                continue;
            }
            match self.past.link(record) {
                Link::Next => {}
                Link::OtherDecision => continue,
                Link::Broken => return Vec::new(),
                Link::PastIsLost => {
                    self.forget();
                    return Vec::new();
                }
            }
            if !self.fold_record(record) {
                return self.advance(now);
            }
            self.past.fold(record);
        }
        if self.has_tracks() && self.caught_up() && !self.past.is_contradicted_by(&state) {
            return self.publish(&state, now);
        }
        // What an answer without news left open is asked for again later, not at once.
        if self.folded > folded { self.advance(now) } else { Vec::new() }
    }

    fn finish(&mut self, state: State) -> Vec<Effect> {
        if !state.status.is_over() || self.finished {
            return Vec::new();
        }
        self.finished = true;
        vec![Effect::Finished(state.status)]
    }

    fn tick(&mut self, now: MonotonicNs) -> Vec<Effect> {
        if let Some(request) = self.truth.ask(now) {
            return vec![Effect::RequestTruth(request)];
        }
        if !self.caught_up() {
            return self.advance(now);
        }
        if self.published.is_some_and(|published| now.since_ns(published) < REPUBLISH_NS) {
            return Vec::new();
        }
        self.published = Some(now);
        vec![Effect::PublishMap]
    }
}

/// Whether a robot's visits are counted: those of rovers that cover ground.
fn counts_visits(robot: &Robot) -> bool {
    matches!(robot.goal, Goal::Cover(_))
}

/// A cell of the map, if it is seen.
fn seen_cell(map: &ObservedMap, index: usize) -> Option<SeenCell> {
    map.cells()[index].map(|ground| SeenCell { index: index as u32, visits: map.visits(index), ground })
}
