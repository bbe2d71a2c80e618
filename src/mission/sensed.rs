//! The observed map of a mission, folded again from its records.

use contract::{
    Brief, MapPatch, MonotonicNs, ObservedMap, PastPage, Record, RobotId, Route, RoutePage, State, Team,
};
use hopper_sim::{Arbiter, Mission, Pace};
use perception::{Cartographer, Effect, Event};
use scenario::ResolvedScenario;

/// The robot whose topics a mission is published on.
const ROBOT: RobotId = RobotId(0);

/// The map as perception had it after the records so far.
pub struct Sensed {
    brief: Brief,
    cartographer: Cartographer,
    state: State,
    team: Option<Team>,
}

impl Sensed {
    /// What is seen before the first decision.
    ///
    /// # Panics
    /// If `brief` is not that of `world`.
    #[must_use]
    pub fn new(world: &ResolvedScenario, brief: &Brief, seed: u64) -> Self {
        let now = MonotonicNs(0);
        let mission = Mission { brief: brief.clone(), ..Mission::of(world, seed) };
        let arbiter = Arbiter::new(mission, None, Pace::Max, 0, now);
        let start = *arbiter.state();
        let team = arbiter.team().cloned();
        let mut cartographer = Cartographer::new(ROBOT);
        cartographer.on(Event::Terrain(brief.run, world.terrain.clone()), now);
        cartographer.on(Event::Brief(brief.clone()), now);
        let mut sensed = Self { brief: brief.clone(), cartographer, state: start, team };
        sensed.pass(start, None, &[]);
        assert!(sensed.cartographer.map().is_some_and(|map| map.through.is_some()), "brief and world differ");
        sensed
    }

    /// Folds in what is seen after the decision of `record`, the next one. `routes` are at least those that were
    /// announced until then.
    pub fn record(&mut self, record: &Record, routes: &[Route]) {
        let now = MonotonicNs(0);
        self.pass(record.state_after(self.brief.run, now, now), Some(record), routes);
    }

    /// The map so far.
    ///
    /// # Panics
    /// Never: what is seen before the first decision is folded in at once.
    #[must_use]
    pub fn map(&self) -> &ObservedMap {
        self.cartographer.map().expect("the start is folded in")
    }

    /// What perception published after the last record, at `now`.
    pub fn patches(&mut self, now: MonotonicNs) -> Vec<MapPatch> {
        self.cartographer.patches(now, &mut || now)
    }

    /// The state after the last record; its times are 0.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The robots at their starts, if the mission is not a single hopper's.
    #[must_use]
    pub fn team(&self) -> Option<&Team> {
        self.team.as_ref()
    }

    /// Passes a state on, and answers what perception asks for: the record that leads to it, and its route.
    fn pass(&mut self, state: State, record: Option<&Record>, routes: &[Route]) {
        let run = self.brief.run;
        self.state = state;
        // A second a decision: whatever is asked for is asked for at once.
        let now = MonotonicNs(state.decision.0.saturating_mul(1_000_000_000));
        let mut effects = self.cartographer.on(Event::State(state), now);
        while let Some(effect) = effects.pop() {
            let answer = match effect {
                Effect::RequestPast(_) => record.map(|record| {
                    Event::Past(PastPage { run, robot: ROBOT, from: record.decision, records: vec![*record] })
                }),
                Effect::RequestRoute(request) => routes
                    .iter()
                    .find(|route| route.id() == request.id)
                    .map(|route| Event::Route(RoutePage { run, route: route.clone() })),
                _ => None,
            };
            effects.extend(answer.into_iter().flat_map(|answer| self.cartographer.on(answer, now)));
        }
    }
}
