//! The state of a mission after a number of hops, ready to be drawn.

use contract::{Brief, Member, ObservedMap, PolicyCell, Record, Route, State, Status};
use planner::{Budget, Situation};
use report::Picture;
use scenario::ResolvedScenario;
use speed_layer::SpeedLayer;

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
    members: Vec<Member>,
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
        let members = sensed.team().map_or_else(Vec::new, |team| team.members.to_vec());
        let (state, map) = (*sensed.state(), sensed.map().clone());
        Self {
            hops: state.decision.0 as usize,
            policy: policy(brief, &map, state, planner),
            speeds: speeds(world, brief, &map, &members),
            members,
            announced: announced.to_vec(),
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
            speeds: &self.speeds,
            members: &self.members,
            announced: &self.announced,
        }
    }
}

/// Expected speed and spread of each cell; empty where speeds are certain.
fn speeds(world: &ResolvedScenario, brief: &Brief, map: &ObservedMap, members: &[Member]) -> Vec<[f64; 2]> {
    if brief.scout.is_none() {
        return Vec::new();
    }
    let layer = SpeedLayer::of_speeds(world.terrain.prior.iter(), members);
    let seen = map.cells().iter().enumerate();
    let estimates = seen.filter_map(|(index, seen)| layer.estimate_seen(index, seen.as_ref()));
    estimates.map(|estimate| [estimate.mean_m_per_sol, estimate.sd_m_per_sol]).collect()
}

fn policy(brief: &Brief, map: &ObservedMap, mut state: State, planner: &str) -> Option<Vec<PolicyCell>> {
    if !brief.is_of_hopper() {
        return None;
    }
    let mut planner = planner::algorithm(planner).ok()?;
    if state.status.is_over()
        && let Some(last) = state.last
    {
        // A policy covers the map, but where the mission has ended there is nothing to plan for.
        state.pose.cell = last.from;
    }
    let leg = brief.leg(state.visits);
    planner
        .plan(&Situation { brief: &leg, map, state: &state, team: None, scouting: None }, &Budget::default());
    planner.policy()
}
