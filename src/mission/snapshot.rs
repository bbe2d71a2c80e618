//! The state of a mission after a number of hops, ready to be drawn.

use contract::{Brief, Decision, MonotonicNs, ObservedMap, PolicyCell, Pose, Record, RobotId, State, Status};
use hopper_sim::{Arbiter, Mission, Pace};
use perception::Observation;
use planner::{Budget, Situation};
use report::Picture;
use scenario::ResolvedScenario;

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
    sensing_radius_m: f64,
}

impl Snapshot {
    /// The mission under `brief` in `world` after the hops of `route`, `planner` being in command.
    #[must_use]
    pub fn after(world: &ResolvedScenario, brief: &Brief, route: &[Record], planner: &str) -> Self {
        let height_m = world.terrain.ground(brief.start).map_or(0.0, |ground| ground.height_m);
        let start = Pose { cell: brief.start, height_m };
        let mut observation = Observation::unseen(brief, RobotId(0));
        let poses = std::iter::once(start).chain(route.iter().map(|record| record.pose));
        for (decision, pose) in poses.enumerate() {
            observation.fold(brief, &world.terrain, pose, Decision(decision as u64));
        }
        Self::with(world, brief, route, observation.map(), planner)
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
            sensing_radius_m: brief.sensor.radius_m(state.pose.height_m),
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
            sensing_radius_m: Some(self.sensing_radius_m),
        }
    }
}

fn state_after(world: &ResolvedScenario, brief: &Brief, route: &[Record]) -> State {
    let now = MonotonicNs(0);
    match route.last() {
        Some(last) => last.state_after(brief.run, now, now),
        None => {
            let mission = Mission { brief: *brief, terrain: world.terrain.clone(), seed: 0 };
            *Arbiter::new(mission, None, Pace::Max, 0, now).state()
        }
    }
}

fn policy(brief: &Brief, map: &ObservedMap, mut state: State, planner: &str) -> Option<Vec<PolicyCell>> {
    let mut planner = planner::algorithm(planner).ok()?;
    if let Some(last) = state.last.filter(|_| state.status.is_over()) {
        // A policy covers the map, but where the mission has ended there is nothing to plan for.
        state.pose.cell = last.from;
    }
    let leg = brief.leg(state.visits);
    planner.plan(&Situation { brief: &leg, map, state: &state }, &Budget::default());
    planner.policy()
}
