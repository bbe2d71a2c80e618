//! A mission at one of its moments, ready to be drawn.

use contract::{Brief, Decision, MonotonicNs, ObservedMap, PolicyCell, Pose, Record, RobotId, State, Status};
use hopper_sim::{Arbiter, Mission, Pace};
use perception::Observation;
use planner::{Budget, Situation};
use report::Picture;
use scenario::World;

/// What the hopper knew and meant to do after some hops of a mission.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Hops so far.
    pub hops: usize,
    /// What had been seen.
    pub map: ObservedMap,
    /// The policy in force: that of the next decision, or of the last one if there is none to come.
    pub policy: Option<Vec<PolicyCell>>,
    /// How the mission stood.
    pub outcome: Status,
    /// Steps so far, in the paper's count.
    pub steps: u64,
    sensing_radius_m: f64,
}

impl Snapshot {
    /// The mission under `brief` in `world` after the hops of `route`, `planner` being in command.
    #[must_use]
    pub fn after(world: &World, brief: &Brief, route: &[Record], planner: &str) -> Self {
        let height_m = world.terrain.ground(brief.start).map_or(0.0, |ground| ground.height_m);
        let start = Pose { cell: brief.start, height_m };
        let mut observation = Observation::unseen(brief, RobotId(0));
        let poses = std::iter::once(start).chain(route.iter().map(|record| record.pose));
        for (decision, pose) in poses.enumerate() {
            observation.fold(brief, &world.terrain, pose, Decision(decision as u64));
        }
        Self::with(world, brief, route, observation.map(), planner)
    }

    /// The mission behind the last of `route` with the map that it has seen; `route` may be the end of a longer
    /// one.
    #[must_use]
    pub fn with(world: &World, brief: &Brief, route: &[Record], map: &ObservedMap, planner: &str) -> Self {
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
    pub fn picture<'a>(&'a self, world: &'a World, brief: &'a Brief, route: &'a [Record]) -> Picture<'a> {
        Picture {
            brief,
            terrain: &world.terrain.cells,
            treasures: &world.terrain.treasures,
            map: &self.map,
            policy: self.policy.as_deref(),
            route,
            outcome: self.outcome,
            sensing_radius_m: Some(self.sensing_radius_m),
        }
    }
}

fn state_after(world: &World, brief: &Brief, route: &[Record]) -> State {
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
