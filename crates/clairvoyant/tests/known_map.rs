//! What the planner of profile `hopper`, shown the whole map, leaves to one that minds the step clock.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use clairvoyant::{Bounds, bounds};
use contract::{
    Action, Branch, Brief, Collected, Decision, Digest, Leader, Leg, MonotonicNs, ObservedMap, PolicyCell,
    Pose, Profile, RobotId, State, Status, Timing, Weights,
};
use motion::{landing, steps, transition};
use planner::{Budget, Situation, algorithm};
use scenario::ResolvedScenario;
use terrain::Terrain;

/// The policy of `mdp` on the whole map.
fn policy(brief: &Brief, terrain: &Terrain) -> Vec<PolicyCell> {
    let leg = brief.leg(0);
    let cells: Vec<_> = terrain.cells.iter().copied().map(Some).collect();
    let map = ObservedMap::of_cells(brief.run, RobotId(0), brief.grid, &cells);
    let state = State {
        run: brief.run,
        robot: RobotId(0),
        decision: Decision(0),
        steps: 0,
        status: Status::Underway,
        leader: Leader::default(),
        pose: Pose { cell: leg.start, height_m: 0.0 },
        last: None,
        collected: Collected::default(),
        previous: Digest::default(),
        digest: Digest::default(),
        landed: MonotonicNs(0),
        published: MonotonicNs(0),
        visits: 0,
        vetoed: contract::Vetoed::NONE,
        last_origin: contract::Origin::Planner,
        last_vetoed: contract::Vetoed::NONE,
        last_timing: Timing::default(),
    };
    let mut planner = algorithm("mdp").unwrap();
    let situation = Situation::alone(brief, &leg, &map, &state);
    planner.plan(&situation, &Budget::default());
    planner.policy().unwrap()
}

/// Success and restricted mean of a fixed policy, exactly: layer after layer of steps left.
fn reached(leg: &Leg, terrain: &Terrain, policy: &[PolicyCell]) -> Bounds {
    let grid = &leg.grid;
    let mut layers: Vec<Vec<Bounds>> = Vec::new();
    for left in 0..=leg.limits.steps_max {
        let failed = Bounds { success: 0.0, restricted_mean_steps: left as f64 };
        let layer = grid.iter().map(|cell| {
            if cell == leg.goal {
                return Bounds { success: 1.0, restricted_mean_steps: 0.0 };
            }
            let index = grid.index(cell).unwrap();
            let (ground, action) = (&terrain.cells[index], policy[index].action);
            let Action::Hop(direction) = action else { return failed };
            let mut sum = Bounds { success: 0.0, restricted_mean_steps: 0.0 };
            for branch in [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right] {
                let p = transition(&leg.motion, ground, direction).probability(branch);
                let (cost, to) = (steps(ground.soil, action, branch), landing(grid, cell, direction, branch));
                let in_time = cost < left || cost == left && to == leg.goal;
                let then = match grid.index(to) {
                    Some(to) if in_time => {
                        let then = layers[(left - cost) as usize][to];
                        Bounds { restricted_mean_steps: cost as f64 + then.restricted_mean_steps, ..then }
                    }
                    _ => failed,
                };
                sum.success += p * then.success;
                sum.restricted_mean_steps += p * then.restricted_mean_steps;
            }
            sum
        });
        let layer = layer.collect();
        layers.push(layer);
    }
    layers[leg.limits.steps_max as usize][grid.index(leg.start).unwrap()]
}

/// P-PRICED-TIME: On a known map, profile `hopper` comes within 0.1 points of success and 0.1 steps
/// of the clairvoyant bounds, whatever the weights.
#[test]
fn priced_time_leaves_nothing_for_a_clock_to_gain() {
    for name in ["hard", "heterogeneous", "sandy"] {
        let ResolvedScenario { mut brief, terrain, .. } = scenario::load(name).unwrap().resolve().unwrap();
        brief.profile = Profile::Hopper;
        let bound = bounds(&brief.leg(0), &terrain);
        for (safety, information) in [(1.0, 0.0), (0.5, 0.5), (0.0, 1.0)] {
            brief.weights = Weights { safety, information, ..brief.weights };
            let got = reached(&brief.leg(0), &terrain, &policy(&brief, &terrain));
            assert!(
                got.success >= bound.success - 0.001,
                "{name} ({safety}, {information}): {got:?}, {bound:?}"
            );
            let over = got.restricted_mean_steps - bound.restricted_mean_steps;
            assert!((0.0..=0.1).contains(&over), "{name} ({safety}, {information}): {got:?}, {bound:?}");
        }
    }
}
