//! The state machine of perception: poses in, maps out.
//!
//! It needs the brief, the terrain and the state of one run, in any order; poses it has missed come
//! from `hop/past`. What a landing reveals is published as patches, and whoever has missed one asks for the
//! map in pages. Nobody downstream decides before [`ObservedMap::through`] equals the state's decision, so
//! publishing late is safe, and publishing twice is harmless.
//!
//! Patches are numbered as a function of the poses alone: a cartographer that began anew goes on where the
//! one before it ended.

use contract::limits::{MAP_PAGE_CELLS, MAP_PAGE_SPAN, MAP_PATCH_CELLS};
use contract::{
    Brief, Decision, Gathering, MapPage, MapPatch, MapRequest, MonotonicNs, ObservedMap, PageCursor,
    PastPage, PastRequest, Pose, Refusal, RobotId, RunId, SeenCell, State, Status, Timeline, TruthPage,
    TruthRequest,
};
use terrain::Terrain;

use crate::Observation;

/// While the hopper stands still, a reminder is published after this long, for whoever missed the last patch.
pub const REPUBLISH_NS: u64 = 100_000_000;

/// What perception hears.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "an event is made, taken, and gone")]
pub enum Event {
    /// The brief; another than before drops all that was known.
    Brief(Brief),
    /// The terrain of a run, whole.
    Terrain(RunId, Terrain),
    /// A page of the terrain that was asked for.
    Truth(TruthPage),
    /// The state.
    State(State),
    /// Records that were asked for.
    Past(PastPage),
    /// Time passes.
    Tick,
}

/// What perception wants done.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Ask for the past.
    RequestPast(PastRequest),
    /// Ask for the terrain.
    RequestTruth(TruthRequest),
    /// Publish [`Cartographer::patches`].
    PublishMap,
    /// A message was refused.
    Refused(Refusal),
    /// The mission is over and its last map is out.
    Finished(Status),
}

/// Folds poses into the observed map of one robot.
#[derive(Debug)]
pub struct Cartographer {
    robot: RobotId,
    /// Most cells of a patch.
    patch_cells: usize,
    brief: Option<Brief>,
    terrain: Option<(RunId, Terrain)>,
    gathering: Gathering,
    state: Option<State>,
    observation: Option<Observation>,
    /// Poses 0..folded are in the map.
    folded: u64,
    /// Where the last of those poses stands in the digest chain.
    timeline: Timeline,
    /// The records of the past that are missing.
    past: PageCursor,
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
            brief: None,
            terrain: None,
            gathering: Gathering::default(),
            state: None,
            observation: None,
            folded: 0,
            timeline: Timeline::default(),
            past: PageCursor::default(),
            stamped: None,
            published: None,
            finished: false,
        }
    }

    /// The same, publishing patches of at most `cells` cells: small ones make several of a landing on a small
    /// map. All lives of perception in a run need the same.
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
                self.gathering = Gathering::default();
            }
            Event::State(state) => {
                if state.robot != self.robot || self.state.is_some_and(|known| state.is_older_than(&known)) {
                    return Vec::new();
                }
                self.state = Some(state);
            }
            Event::Past(page) => return self.past(&page, now),
            Event::Truth(page) => return self.truth(&page, now),
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
            robot: map.robot,
            through: map.through.expect("a map is published only once it exists"),
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
        let published = clock();
        observation.map_mut().published = published;
        patches.iter_mut().for_each(|patch| patch.published = published);
        patches
    }

    /// The page that answers `request`; `None` while it cannot be answered, because the map is not up to the
    /// state or its last landing is not published yet.
    #[must_use]
    pub fn page(&self, request: &MapRequest) -> Option<MapPage> {
        let map = self.observation.as_ref()?.map();
        let through = map.through.filter(|_| self.caught_up() && self.stamped == map.through)?;
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

    /// The run, decision and status last seen, for the heartbeat. A run is known once its terrain is.
    #[must_use]
    pub fn seen(&self) -> (RunId, Decision, Status) {
        match (&self.state, self.current()) {
            (Some(state), true) => (state.run, state.decision, state.status),
            _ => (self.grounded().unwrap_or_default(), Decision(0), Status::Underway),
        }
    }

    /// What is missing, if anything.
    #[must_use]
    pub fn waits_for(&self) -> Option<&'static str> {
        if self.brief.is_none() {
            Some("hopper-sim: no brief yet")
        } else if self.terrain.is_none() {
            Some("hopper-sim: no terrain yet")
        } else if self.state.is_none() {
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
        let news = self.brief != Some(brief);
        self.brief = Some(brief);
        if news {
            if self.terrain.as_ref().is_none_or(|(run, _)| *run != brief.run) {
                self.gathering.begin(brief.run);
            }
            self.forget();
        }
    }

    fn truth(&mut self, page: &TruthPage, now: MonotonicNs) -> Vec<Effect> {
        match self.gathering.page(page) {
            Ok(Some(truth)) => {
                let (grid, cells, treasures) = (truth.grid, truth.cells, truth.treasures);
                let terrain = Terrain { grid, cells, treasures };
                self.terrain = Some((truth.run, terrain));
                self.advance(now)
            }
            Ok(None) => self.gathering.ask(now).map(Effect::RequestTruth).into_iter().collect(),
            Err(refusal) => vec![Effect::Refused(refusal)],
        }
    }

    /// Begins the map of the brief's run anew.
    fn forget(&mut self) {
        let unseen = |brief| Observation::unseen(&brief, self.robot).cut_to(self.patch_cells);
        self.observation = self.brief.map(unseen);
        self.folded = 0;
        self.timeline = Timeline::default();
        self.past = PageCursor::default();
        self.stamped = None;
        self.published = None;
        self.finished = false;
    }

    /// The run of which both brief and terrain are known.
    fn grounded(&self) -> Option<RunId> {
        let (brief, (run, terrain)) = (self.brief.as_ref()?, self.terrain.as_ref()?);
        (brief.run == *run && terrain.grid == brief.grid).then_some(*run)
    }

    /// Whether brief, terrain and state belong to one run.
    fn current(&self) -> bool {
        self.state.is_some_and(|state| self.grounded() == Some(state.run))
    }

    /// Whether the map covers the state's pose.
    fn caught_up(&self) -> bool {
        self.current() && self.state.is_some_and(|state| self.folded == state.decision.0 + 1)
    }

    fn fold(&mut self, pose: Pose) {
        let (Some(brief), Some((_, terrain)), Some(observation)) =
            (&self.brief, &self.terrain, &mut self.observation)
        else {
            return;
        };
        observation.fold(brief, terrain, pose, Decision(self.folded));
        self.folded += 1;
    }

    fn advance(&mut self, now: MonotonicNs) -> Vec<Effect> {
        let Some(state) = self.state.filter(|_| self.current()) else { return Vec::new() };
        if self.folded > 0 && self.timeline.is_contradicted_by(&state) {
            // The journal has lost its tail, or was flown on elsewhere.
            self.forget();
        }
        if self.folded > state.decision.0 {
            return self.finish(state);
        }
        if self.folded < state.decision.0 {
            self.fold_start();
        }
        if self.folded == state.decision.0 {
            self.fold(state.pose);
            self.timeline = Timeline::through(&state);
            self.published = Some(now);
            let mut effects = vec![Effect::PublishMap];
            effects.extend(self.finish(state));
            return effects;
        }
        self.request(state.run, now).into_iter().collect()
    }

    /// The start is in the brief, so that the past is needed from decision 0 only for what followed.
    fn fold_start(&mut self) {
        if self.folded > 0 {
            return;
        }
        let (Some(brief), Some((_, terrain))) = (&self.brief, &self.terrain) else { return };
        let height_m = terrain.ground(brief.start).map_or(0.0, |ground| ground.height_m);
        self.fold(Pose { cell: brief.start, height_m });
    }

    /// Asks for the records whose poses are missing: record k leads to pose k + 1, and the brief has pose 0.
    fn request(&mut self, run: RunId, now: MonotonicNs) -> Option<Effect> {
        self.past.advance_to(self.folded.saturating_sub(1));
        let from = Decision(self.past.ask(now)?);
        Some(Effect::RequestPast(PastRequest { run, robot: self.robot, from }))
    }

    fn past(&mut self, page: &PastPage, now: MonotonicNs) -> Vec<Effect> {
        let Some(state) = self.state.filter(|state| self.current() && state.run == page.run) else {
            return Vec::new();
        };
        if page.robot != self.robot || self.caught_up() {
            return Vec::new();
        }
        let folded = self.folded;
        for record in &page.records {
            // Record k leads to pose k + 1; the state brings its own pose.
            if record.decision.0 + 1 != self.folded || self.folded >= state.decision.0 {
                continue;
            }
            if self.timeline.is_broken_by(record) {
                // The map holds poses of another past. It is built anew, after a pause: the page may be an old one.
                self.forget();
                self.past.restart(now);
                return Vec::new();
            }
            self.fold(record.pose);
            self.timeline.fold(record);
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
        if let Some(request) = self.gathering.ask(now) {
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

/// A cell of the map, if it is seen.
fn seen_cell(map: &ObservedMap, index: usize) -> Option<SeenCell> {
    map.cells()[index].map(|ground| SeenCell { index: index as u32, ground })
}
