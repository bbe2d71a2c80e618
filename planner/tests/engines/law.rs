//! The law: decide(brief, map, state, cache) gives the same plan with an empty cache, bit for bit.

use contract::{Action, Cell, Direction, Profile};
use planner::{
    AHEAD_ALGORITHMS, ALGORITHMS, COVER_ALGORITHMS, DRIVE_ALGORITHMS, FLY_ALGORITHMS, PlannerError, algorithm,
};

use crate::world::{PROFILES, Soils, World};

/// Flies `missions` in each world with one long-lived planner, a fresh one beside it at every decision.
fn decisions_alike(algorithm_name: &str, worlds: &[World], missions: u64) -> u64 {
    let mut veteran = algorithm(algorithm_name).unwrap();
    let mut decisions = 0;
    for seed in 0..missions {
        // One after another, so that what is kept from one world meets the next.
        for world in worlds {
            world.fly(&mut *veteran, seed, |situation, plan| {
                let mut novice = algorithm(algorithm_name).unwrap();
                let same = novice.plan(situation, &Default::default());
                assert_eq!(plan.action, same.action, "{algorithm_name} at {}", situation.state.pose.cell);
                assert_eq!(plan.status, same.status);
                // A mended search may take less work, or more; so may values kept from the last decision.
                if !["dstar_lite", "mdp"].contains(&algorithm_name) {
                    assert_eq!(plan.work, same.work);
                }
                assert_eq!(plan.error_bound.to_bits(), same.error_bound.to_bits());
                decisions += 1;
            });
        }
    }
    decisions
}

fn worlds() -> Vec<World> {
    let mut worlds = Vec::new();
    for profile in PROFILES {
        worlds.extend((0..12).map(|seed| World::random(seed, profile)));
        for (start, goal) in [((0, 0), (7, 7)), ((7, 7), (0, 0)), ((0, 7), (7, 0)), ((4, 0), (4, 7))] {
            worlds.push(World::flat(8, Cell::new(start.0, start.1), Cell::new(goal.0, goal.1), profile));
        }
    }
    for world in &mut worlds {
        world.leg.limits.steps_max = 60;
    }
    worlds.push(World::paper(Soils::Sandy, [0.5, 0.5], Profile::Hopper));
    worlds
}

/// P-LAW: A decision never depends on a planner's cache.
#[test]
fn a_planner_with_an_empty_cache_decides_the_same() {
    let worlds = worlds();
    for name in ALGORITHMS {
        let decisions = decisions_alike(name, &worlds, 10);
        assert!(decisions > 2_000, "{name}: only {decisions} decisions compared");
    }
}

/// P-LAW.
#[test]
fn ties_on_flat_ground_go_to_the_first_of_north_east_south_west() {
    use Direction::{East, North, South};
    // The goal in each corner; from the middle two directions are equally good.
    for profile in PROFILES {
        for (goal, first) in [((18, 18), North), ((2, 18), North), ((18, 2), East), ((2, 2), South)] {
            let middle = Cell::new(10, 10);
            let world = World::flat(21, middle, Cell::new(goal.0, goal.1), profile);
            for name in ["mdp", "greedy"] {
                let plan = world.plan(&mut *algorithm(name).unwrap(), &world.unseen(), middle);
                assert_eq!(plan.action, Action::Hop(first), "{name}, goal {goal:?}, {profile}");
            }
        }
    }
}

#[test]
fn on_flat_ground_the_policy_has_the_symmetry_of_the_map() {
    // Mirrored at the diagonal, values agree within the certified error, and off the diagonal north
    // becomes east: no tie is left to rounding.
    let world = World::flat(15, Cell::new(0, 0), Cell::new(14, 14), Profile::Paper2023);
    let mut planner = algorithm("mdp").unwrap();
    world.plan(&mut *planner, &world.unseen(), world.leg.start);
    let policy = planner.policy().unwrap();
    for x in 0..14 {
        for y in 0..14 {
            let [here, mirrored] = [policy[y * 15 + x], policy[x * 15 + y]];
            assert!((here.value - mirrored.value).abs() <= 2e-7);
            if x == y {
                assert_eq!(here.action, Action::Hop(Direction::North));
            }
        }
    }
}

#[test]
fn every_algorithm_answers_to_its_name_and_an_unknown_one_names_the_known() {
    for name in [ALGORITHMS, AHEAD_ALGORITHMS, COVER_ALGORITHMS, DRIVE_ALGORITHMS, FLY_ALGORITHMS].concat() {
        assert_eq!(algorithm(name).unwrap().name().as_str(), name);
    }
    let error = algorithm("oracle").err().unwrap();
    assert!(matches!(&error, PlannerError::UnknownAlgorithm { got, .. } if got == "oracle"), "{error}");
    let listed = planner::listed();
    assert_eq!(error.to_string(), format!("no planner is called \"oracle\"; need one of {listed}"));
    let error = algorithm("Dstar-Lite").err().unwrap();
    assert_eq!(error.to_string(), "no planner is called \"Dstar-Lite\"; did you mean dstar_lite?");
}

#[test]
fn hold_never_moves() {
    let world = World::paper(Soils::Hard, [1.0, 0.0], Profile::Hopper);
    let mut hold = algorithm("hold").unwrap();
    world.fly(&mut *hold, 0, |_, plan| assert_eq!(plan.action, Action::Hold));
    assert_eq!(hold.policy(), None);
}

/// P-CLAIRVOYANT: The clairvoyant planner is refused outside lockstep.
#[test]
fn the_clairvoyant_is_refused_outside_lockstep() {
    assert_eq!(algorithm(planner::CLAIRVOYANT).err(), Some(PlannerError::LockstepOnly));
}
