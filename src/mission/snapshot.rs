//! The state of a mission after a number of hops, ready to be drawn.

use contract::{
    Account, Brief, Decision, Detail, Leg, MotionTable, ObservedMap, PolicyCell, Record, Route, State, Status,
};
use planner::{Budget, Situation};
use report::Picture;
use scenario::ResolvedScenario;
use speed_layer::{SpeedEstimate, SpeedLayer};

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
    /// See [`Picture::speeds`].
    speeds: Vec<[f64; 2]>,
    announced: Vec<Route>,
}

impl Snapshot {
    /// The hopper's mission under `brief` in `world` after the hops of `route`, `planner` being in command.
    #[must_use]
    pub fn after(
        world: &ResolvedScenario,
        brief: &Brief,
        seed: u64,
        route: &[Record],
        planner: &str,
    ) -> Self {
        let mut sensed = Sensed::new(world, brief, seed);
        route.iter().for_each(|record| sensed.record(record, &[]));
        Self::with(world, brief, &sensed, &[], planner)
    }

    /// The mission under `brief` in `world` after the last record that `sensed` has folded in, `planner` being in command, with
    /// the routes that were `announced`.
    #[must_use]
    pub fn with(
        world: &ResolvedScenario,
        brief: &Brief,
        sensed: &Sensed,
        announced: &[Route],
        planner: &str,
    ) -> Self {
        let (state, map) = (*sensed.state(), sensed.map().clone());
        Self {
            hops: state.decision.0 as usize,
            policy: policy((brief, world.table.as_deref()), &map, state, planner),
            speeds: speeds(world, brief, &map),
            announced: announced.to_vec(),
            map,
            outcome: state.status,
            steps: state.steps,
            sensing_radius_m: hopper_leg(brief, state.visits)
                .map(|leg| leg.sensor.radius_m(state.pose.height_m)),
        }
    }

    /// Its picture; `route` are the hops so far, with what the motion model told of them.
    #[must_use]
    pub fn picture<'a>(
        &'a self,
        world: &'a ResolvedScenario,
        brief: &'a Brief,
        route: &'a [Record],
        details: &'a [(Decision, Detail)],
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
            speeds: &self.speeds,
            announced: &self.announced,
            details,
        }
    }
}

/// Expected speed and spread of each cell; empty where speeds are certain.
fn speeds(world: &ResolvedScenario, brief: &Brief, map: &ObservedMap) -> Vec<[f64; 2]> {
    if brief.sampling.is_none() {
        return Vec::new();
    }
    let layer = SpeedLayer::of_speeds(world.terrain.prior.iter(), &brief.robots);
    let seen = map.cells().iter().enumerate();
    let estimates = seen.filter_map(|(index, seen)| layer.estimate_seen(index, seen.as_ref()));
    estimates.map(SpeedEstimate::mean_and_sd_m_per_sol).collect()
}

fn policy(
    (brief, table): (&Brief, Option<&MotionTable>),
    map: &ObservedMap,
    mut state: State,
    planner: &str,
) -> Option<Vec<PolicyCell>> {
    let leg = hopper_leg(brief, state.visits)?;
    let mut planner = planner::algorithm(planner).ok()?;
    if state.status.is_over()
        && let Some(last) = state.last
    {
        // A policy covers the map, but where the mission has ended there is nothing to plan for.
        state.pose.cell = last.from;
    }
    let situation = Situation { table, ..Situation::alone(brief, &leg, map, &state) };
    planner.plan(&situation, &Budget::default());
    planner.policy()
}

/// The leg of a hopper's mission; `None` in other missions.
fn hopper_leg(brief: &Brief, visits: u64) -> Option<Leg> {
    if brief.account == Account::Hopper { Some(brief.leg(visits)) } else { None }
}
