//! The state machine of perception: poses in, maps out.
//!
//! It needs the brief, the terrain and the state of one run, in any order; poses it has missed come
//! from `hop/past`. Nobody downstream decides before [`ObservedMap::through`] equals the state's
//! decision, so publishing late is safe, and publishing twice is harmless.

use contract::{
    Brief, Decision, MonotonicNs, ObservedMap, PastPage, PastRequest, Pose, RobotId, RunId, State, Status,
};
use terrain::Terrain;

use crate::Observation;

/// While the hopper stands still, its map is published again after this long, for whoever missed it.
pub const REPUBLISH_NS: u64 = 100_000_000;

/// What perception hears.
#[derive(Clone, Debug)]
pub enum Event {
    /// The brief; one of a new run drops all that was known.
    Brief(Brief),
    /// The terrain of a run.
    Terrain(RunId, Terrain),
    /// The state.
    State(State),
    /// Records that were asked for.
    Past(PastPage),
    /// Time passes.
    Tick,
}

/// What perception wants done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Ask for the past.
    RequestPast(PastRequest),
    /// Publish [`Cartographer::stamped_map`].
    PublishMap,
    /// The mission is over and its last map is out.
    Finished(Status),
}

/// Folds poses into the observed map of one robot.
#[derive(Debug)]
pub struct Cartographer {
    robot: RobotId,
    brief: Option<Brief>,
    terrain: Option<(RunId, Terrain)>,
    state: Option<State>,
    observation: Option<Observation>,
    /// Poses 0..folded are in the map.
    folded: u64,
    /// The decision whose map has its moment of sensing.
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
            brief: None,
            terrain: None,
            state: None,
            observation: None,
            folded: 0,
            stamped: None,
            published: None,
            finished: false,
        }
    }

    /// Takes note of `event` at `now` and says what is to be done.
    pub fn on(&mut self, event: Event, now: MonotonicNs) -> Vec<Effect> {
        match event {
            Event::Brief(brief) => self.brief(brief),
            Event::Terrain(run, terrain) => self.terrain = Some((run, terrain)),
            Event::State(state) => {
                let lower = |known: &State| known.run == state.run && state.decision < known.decision;
                let back = self.state.filter(lower);
                if state.robot != self.robot || back.is_some_and(|known| state.published <= known.published) {
                    return Vec::new();
                }
                if back.is_some() {
                    // Published later, it is that of a journal that has lost its tail.
                    self.forget();
                }
                self.state = Some(state);
            }
            Event::Past(page) => return self.past(&page, now),
            Event::Tick => return self.tick(now),
        }
        self.advance(now)
    }

    /// The map, with the moments at which it was sensed and published written in.
    ///
    /// # Panics
    /// If nothing has been folded yet; only [`Effect::PublishMap`] asks for it.
    pub fn stamped_map(&mut self, sensed: MonotonicNs, published: MonotonicNs) -> &ObservedMap {
        let map = self.observation.as_mut().expect("a map is published only once it exists").map_mut();
        map.sequence += 1;
        if self.stamped != map.through {
            self.stamped = map.through;
            map.sensed = sensed;
        }
        map.published = published;
        map
    }

    /// The map so far.
    #[must_use]
    pub fn map(&self) -> Option<&ObservedMap> {
        self.observation.as_ref().map(Observation::map)
    }

    /// The run, decision and status last seen, for the heartbeat.
    #[must_use]
    pub fn seen(&self) -> (RunId, Decision, Status) {
        match (&self.state, self.current()) {
            (Some(state), true) => (state.run, state.decision, state.status),
            _ => (RunId::default(), Decision(0), Status::Underway),
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
        let news = self.brief.is_none_or(|known| known.run != brief.run);
        self.brief = Some(brief);
        if news {
            self.forget();
        }
    }

    /// Begins the map of the brief's run anew.
    fn forget(&mut self) {
        self.observation = self.brief.map(|brief| Observation::unseen(&brief, self.robot));
        self.folded = 0;
        self.stamped = None;
        self.published = None;
        self.finished = false;
    }

    /// Whether brief, terrain and state belong to one run.
    fn current(&self) -> bool {
        match (&self.brief, &self.terrain, &self.state) {
            (Some(brief), Some((run, terrain)), Some(state)) => {
                brief.run == *run && *run == state.run && terrain.grid == brief.grid
            }
            _ => false,
        }
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
        if self.folded > state.decision.0 {
            return self.finish(state);
        }
        if self.folded < state.decision.0 {
            self.fold_start();
        }
        if self.folded == state.decision.0 {
            self.fold(state.pose);
            self.published = Some(now);
            let mut effects = vec![Effect::PublishMap];
            effects.extend(self.finish(state));
            return effects;
        }
        vec![self.request(state.run)]
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

    fn request(&self, run: RunId) -> Effect {
        let from = Decision(self.folded.saturating_sub(1));
        Effect::RequestPast(PastRequest { run, robot: self.robot, from })
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
            if record.decision.0 + 1 == self.folded && self.folded < state.decision.0 {
                self.fold(record.pose);
            }
        }
        // An answer without news is asked for again at the next tick, not at once.
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
