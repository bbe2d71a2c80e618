//! What profile `hopper` does better.

use contract::{Action, Cell, Profile, Soil, Status};
use planner::{PlanStatus, algorithm};

use crate::world::{PROFILES, Soils, World};

#[test]
fn on_a_large_map_no_value_is_so_low_that_losing_the_hopper_looks_better() {
    // With a fixed price of −300 the plan for a far corner was to jump off the map.
    let side = 60;
    let world = World::flat(side, Cell::new(1, 2), Cell::new(58, 58), Profile::Hopper);
    let mut planner = algorithm("mdp").unwrap();
    let plan = world.plan(&mut *planner, &world.unseen(), world.leg.start);
    assert_eq!(plan.status, PlanStatus::Solved);
    let policy = planner.policy().unwrap();
    for start in world.leg.grid.iter() {
        let mut cell = start;
        for _ in 0..4 * side {
            if let Action::Hop(direction) = policy[world.leg.grid.index(cell).unwrap()].action {
                cell = world.leg.grid.hop(cell, direction);
                assert!(world.leg.grid.contains(cell), "from {start} the policy leaves the map");
            }
        }
        assert_eq!(cell, world.leg.goal, "from {start} the policy does not arrive");
    }
}

/// Cells from which the policy's intended moves never arrive, on the seen sandy ground of the paper.
fn strays(profile: Profile, weights: [f64; 2]) -> usize {
    let world = World::paper(Soils::Sandy, weights, profile);
    let grid = &world.leg.grid;
    let mut planner = algorithm("mdp").unwrap();
    world.plan(&mut *planner, &world.seen(), world.leg.start);
    let policy = planner.policy().unwrap();
    let strays = |start: &Cell| {
        let mut cell = *start;
        for _ in 0..grid.cells() {
            if let Action::Hop(direction) = policy[grid.index(cell).unwrap()].action {
                // Off the map counts as staying in the paper's plan, where it may well be meant.
                cell = Some(grid.hop(cell, direction)).filter(|to| grid.contains(*to)).unwrap_or(cell);
            }
        }
        cell != world.leg.goal
    };
    grid.iter().filter(strays).count()
}

#[test]
fn no_preference_pays_for_lingering() {
    for weights in [[10.0, 0.0], [5.0, 5.0], [0.0, 10.0]] {
        assert_eq!(strays(Profile::Hopper, weights), 0, "{weights:?}");
        assert!(
            strays(Profile::Paper2023, weights) > 0,
            "{weights:?} are weights that catch the paper's plan"
        );
    }
}

#[test]
fn preferences_buy_no_detour_into_the_sand() {
    // 1.6 steps apart while the slope of the first hill could push the hopper into the sand beside it.
    let steps = [[1.0, 0.0], [0.0, 1.0]].map(|weights| {
        let world = World::paper(Soils::Heterogeneous, weights, Profile::Hopper);
        let mut planner = algorithm("mdp").unwrap();
        let missions = (0..200).map(|seed| world.fly(&mut *planner, seed, |_, _| ()));
        missions.map(|episode| episode.steps as f64).sum::<f64>() / 200.0
    });
    assert!((steps[0] - steps[1]).abs() < 0.5, "{steps:?}");
}

#[test]
fn the_policy_never_means_to_land_on_known_impassable_ground() {
    for seed in 0..40 {
        for profile in PROFILES {
            let world = World::random(seed, profile);
            let mut planner = algorithm("mdp").unwrap();
            let plan = world.plan(&mut *planner, &world.seen(), world.leg.start);
            let Some(policy) = planner.policy() else { continue };
            let grid = &world.leg.grid;
            let Action::Hop(direction) = plan.action else { panic!("a way exists: {plan:?}") };
            assert_eq!(plan.action, policy[grid.index(world.leg.start).unwrap()].action);
            let towards = grid.hop(world.leg.start, direction);
            if let Some(ground) = world.ground(towards) {
                assert!(ground.passable, "world {seed}: {} -> {towards}", world.leg.start);
            }
        }
    }
}

#[test]
fn unseen_soil_is_that_of_the_majority_of_the_seen_in_hopper_and_hard_in_the_paper() {
    let world = World::paper(Soils::Sandy, [1.0, 0.0], Profile::Hopper);
    let soil = |profile, sandy_cells: usize, hard_cells: usize| {
        let mut leg = world.leg;
        leg.profile = profile;
        let mut map = world.unseen();
        for index in 0..sandy_cells + hard_cells {
            let soil = if index < sandy_cells { Soil::Sand } else { Soil::Hard };
            map.learn(index, contract::Ground { soil, ..contract::Ground::FLAT });
        }
        planner::belief::Belief::new(&leg, &map).unseen.soil
    };
    assert_eq!(soil(Profile::Hopper, 5, 4), Soil::Sand);
    assert_eq!(soil(Profile::Hopper, 5, 5), Soil::Hard);
    assert_eq!(soil(Profile::Hopper, 0, 0), Soil::Hard);
    assert_eq!(soil(Profile::Paper2023, 5, 4), Soil::Hard);
}

#[test]
fn on_hard_ground_no_mission_of_profile_hopper_fails() {
    // The clairvoyant bound is 100.00 %.
    let world = World::paper(Soils::Hard, [1.0, 0.0], Profile::Hopper);
    let mut planner = algorithm("mdp").unwrap();
    for seed in 0..100 {
        assert_eq!(world.fly(&mut *planner, seed, |_, _| ()).status, Status::Goal, "seed {seed}");
    }
}
