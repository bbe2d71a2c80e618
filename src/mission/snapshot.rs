//! The state of a mission after a number of hops, ready to be drawn.

use contract::{Brief, MonotonicNs, ObservedMap, PolicyCell, Record, State, Status};
use hopper_sim::{Arbiter, Mission, Pace};
use planner::{Budget, Situation};
use report::Picture;
use scenario::ResolvedScenario;

use super::sensed::Sensed;

/// What the hopper had seen, and what it would have done next.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Hops executed so far.
    pub hops: usize,
    /// The map as observed so far.
    pub map: ObservedMap,
    /// Policy of the next decision, or of the last one once the mission is over; `None` if the planner has none.
    pub policy: Option<Vec<PolicyCell>>,
    /// Status of the mission; [`Status::Underway`] before its end.
    pub outcome: Status,
    /// Steps so far, as the paper counts them.
    pub steps: u64,
    sensing_radius_m: Option<f64>,
}

impl Snapshot {
    /// The mission under `brief` in `world` after the hops of `route`, `planner` being in command.
    #[must_use]
    pub fn after(world: &ResolvedScenario, brief: &Brief, route: &[Record], planner: &str) -> Self {
        let mut sensed = Sensed::new(world, brief);
        route.iter().for_each(|record| sensed.record(record));
        Self::with(world, brief, route, sensed.map(), planner)
    }

    /// The mission after the last hop of `route`, with the map observed until then; earlier hops may be left out of
    /// `route`.
    #[must_use]
    pub fn with(
        world: &ResolvedScenario,
        brief: &Brief,
        route: &[Record],
        map: &ObservedMap,
        planner: &str,
    ) -> Self {
        let state = state_after(world, brief, route);
        let map = map.clone();
        Self {
            hops: route.len(),
            policy: policy(brief, &map, state, planner),
            map,
            outcome: state.status,
            steps: state.steps,
            sensing_radius_m: brief.is_of_hopper().then(|| brief.sensor.radius_m(state.pose.height_m)),
        }
    }

    /// Its picture; `route` are the hops so far.
    #[must_use]
    pub fn picture<'a>(
        &'a self,
        world: &'a ResolvedScenario,
        brief: &'a Brief,
        route: &'a [Record],
    ) -> Picture<'a> {
        Picture {
            brief,
            terrain: &world.terrain.cells,
            treasures: &world.terrain.treasures,
            map: &self.map,
            policy: self.policy.as_deref(),
            route,
            outcome: self.outcome.into(),
            sensing_radius_m: self.sensing_radius_m,
        }
    }
}

fn state_after(world: &ResolvedScenario, brief: &Brief, route: &[Record]) -> State {
    let now = MonotonicNs(0);
    match route.last() {
        Some(last) => last.state_after(brief.run, now, now),
        None => {
            let mission = Mission {
                brief: *brief,
                terrain: world.terrain.clone(),
                seed: 0,
                fleet: world.fleet.clone(),
            };
            *Arbiter::new(mission, None, Pace::Max, 0, now).state()
        }
    }
}

fn policy(brief: &Brief, map: &ObservedMap, mut state: State, planner: &str) -> Option<Vec<PolicyCell>> {
    if !brief.is_of_hopper() {
        return None;
    }
    let mut planner = planner::algorithm(planner).ok()?;
    if let Some(last) = state.last.filter(|_| state.status.is_over()) {
        // A policy covers the map, but where the mission has ended there is nothing to plan for.
        state.pose.cell = last.from;
    }
    let leg = brief.leg(state.visits);
    planner
        .plan(&Situation { brief: &leg, map, state: &state, team: None, scouting: None }, &Budget::default());
    planner.policy()
}
