//! What a team of rovers keeps to: turns, cells of their own, regions, failures, and that every mission ends.

use contract::{Cell, Direction, Grid};
use coverage::{Algorithm, CoverMode, Placement};
use coverage_world::{Fault, Mission, Outcome, Setup, SetupError, World};

fn world(side: u32, obstacle_percent: f64, seed: u64) -> World {
    World::random(Grid::new(side, side, 1.0, 1).unwrap(), obstacle_percent, seed).unwrap()
}

fn setup(world: &World, algorithm: Algorithm, mode: CoverMode, rovers: usize, seed: u64) -> Setup {
    Setup::new(world, algorithm, mode, world.random_starts(rovers, seed).unwrap(), 100)
}

#[test]
fn every_planner_covers_all_ground_in_both_modes() {
    for algorithm in Algorithm::ALL {
        for mode in [CoverMode::Overlap, CoverMode::Voronoi] {
            for (seed, rovers) in [1, 2, 4, 8, 16].into_iter().cycle().take(25).enumerate() {
                let world = world(12, 15.0, seed as u64);
                let setup = setup(&world, algorithm, mode, rovers, seed as u64);
                let outcome = Mission::run(&world, &setup).unwrap();
                assert!(outcome.covered, "{algorithm} {mode:?} seed {seed}");
                assert_eq!(outcome.covered_at.len(), outcome.reachable);
                // Regions may enclose cells that their rover cannot reach without leaving.
                assert!(mode == CoverMode::Voronoi || outcome.reachable == 144 - 22);
            }
        }
    }
}

/// A rover moves to one of four neighbours, and no two rovers ever share a cell.
#[test]
fn rovers_step_to_free_neighbours_and_share_no_cell() {
    for algorithm in Algorithm::ALL {
        let world = world(8, 20.0, 3);
        let setup = setup(&world, algorithm, CoverMode::Overlap, 12, 3);
        let mut mission = Mission::new(&world, &setup).unwrap();
        while !mission.is_over() {
            let before: Vec<Cell> = mission.rovers().iter().map(|rover| rover.pose.cell).collect();
            mission.round();
            let after: Vec<Cell> = mission.rovers().iter().map(|rover| rover.pose.cell).collect();
            for (robot, (from, to)) in before.iter().zip(&after).enumerate() {
                assert!((from.x - to.x).abs() + (from.y - to.y).abs() <= 1);
                assert!(world.is_free(*to));
                assert!(!after[..robot].contains(to), "{algorithm}: two rovers on {to}");
            }
        }
    }
}

/// Rover 1 sees that rover 0 has left the cell in front of it, in the same round.
#[test]
fn a_rover_acts_on_what_those_before_it_have_done() {
    let corridor = World::new(Grid::new(5, 1, 1.0, 1).unwrap(), vec![false; 5]).unwrap();
    let at = |x| Placement { cell: Cell::new(x, 0), heading: Direction::East };
    for (starts, cells) in [([1, 0], [2, 1]), ([0, 1], [0, 2])] {
        let starts = starts.map(at).to_vec();
        let setup = Setup::new(&corridor, Algorithm::Spiral, CoverMode::Overlap, starts, 100);
        let mut mission = Mission::new(&corridor, &setup).unwrap();
        mission.round();
        let after: Vec<i32> = mission.rovers().iter().map(|rover| rover.pose.cell.x).collect();
        assert_eq!(after, cells);
    }
}

#[test]
fn in_voronoi_no_rover_leaves_its_region_and_one_whose_region_is_covered_stops() {
    let world = world(12, 10.0, 5);
    let setup = setup(&world, Algorithm::Spiral, CoverMode::Voronoi, 4, 5);
    let mut mission = Mission::new(&world, &setup).unwrap();
    let starts: Vec<Cell> = setup.starts.iter().map(|start| start.cell).collect();
    let mut stopped = 0;
    while !mission.is_over() {
        let before = mission.rovers().to_vec();
        mission.round();
        stopped += before.iter().zip(mission.rovers()).filter(|(before, after)| before == after).count();
        for (robot, rover) in mission.rovers().iter().enumerate() {
            assert_eq!(coverage::region::nearest_start(starts.clone(), rover.pose.cell), robot);
        }
    }
    assert!(mission.outcome().covered && stopped > 0);
}

fn with_fault(algorithm: Algorithm, mode: CoverMode, seed: u64, action: u64) -> Outcome {
    let world = world(12, 10.0, seed);
    let setup = Setup { faults: vec![Fault { robot: 1, action }], ..setup(&world, algorithm, mode, 4, seed) };
    let setup = Setup { steps_max: 20_000, ..setup };
    let mut mission = Mission::new(&world, &setup).unwrap();
    while !mission.is_over() {
        mission.round();
        let stranded = mission.rovers()[1].stranded;
        assert_eq!(stranded, mission.outcome().steps >= action, "it fails at its {action}th action");
    }
    mission.outcome()
}

/// P-STRANDED: Where rovers share all ground, the others still cover the area of a rover that
/// fails; once no rover is left, it stays uncovered.
#[test]
fn where_rovers_overlap_the_area_of_one_that_fails_is_still_covered() {
    for algorithm in Algorithm::ALL {
        for seed in 0..20 {
            for action in [1, 2, 10, 20] {
                let outcome = with_fault(algorithm, CoverMode::Overlap, seed, action);
                assert!(outcome.covered, "{algorithm}, seed {seed}, action {action}");
                assert_eq!(outcome.covered_at.len(), outcome.reachable);
            }
        }
    }
}

#[test]
fn in_voronoi_the_region_of_a_rover_that_fails_stays_uncovered() {
    for seed in 0..20 {
        assert!(!with_fault(Algorithm::Spiral, CoverMode::Voronoi, seed, 2).covered);
    }
}

/// P-STRANDED. When the last rover fails, nobody takes over, and the rest of the ground stays
/// uncovered.
#[test]
fn a_team_of_which_nobody_is_left_has_not_covered_its_ground() {
    for rovers in [1, 3] {
        let world = world(6, 0.0, 1);
        let faults = (0..rovers).map(|robot| Fault { robot, action: 2 + robot as u64 }).collect();
        let setup = Setup { faults, ..setup(&world, Algorithm::Spiral, CoverMode::Overlap, rovers, 1) };
        let outcome = Mission::run(&world, &setup).unwrap();
        assert!(!outcome.covered, "{rovers} rovers");
        assert_eq!(outcome.reachable, 36, "{rovers} rovers");
    }
}

#[test]
fn setups_that_cannot_be_executed_are_refused() {
    let world = World::new(Grid::new(3, 1, 1.0, 1).unwrap(), vec![false, false, true]).unwrap();
    let at = |x| Placement { cell: Cell::new(x, 0), heading: Direction::North };
    let refused = |starts: &[i32], percent, faults: &[Fault]| {
        let starts = starts.iter().copied().map(at).collect();
        let setup = Setup::new(&world, Algorithm::Spiral, CoverMode::Overlap, starts, percent);
        Mission::run(&world, &Setup { faults: faults.to_vec(), ..setup }).unwrap_err()
    };
    assert_eq!(refused(&[], 100, &[]), SetupError::Rovers { got: 0 });
    assert_eq!(refused(&[0; 17], 100, &[]), SetupError::Rovers { got: 17 });
    assert_eq!(refused(&[0, 2], 100, &[]), SetupError::StartNotFree { robot: 1, cell: Cell::new(2, 0) });
    assert_eq!(refused(&[3], 100, &[]), SetupError::StartNotFree { robot: 0, cell: Cell::new(3, 0) });
    assert_eq!(refused(&[1, 1], 100, &[]), SetupError::StartShared { robots: [0, 1], cell: Cell::new(1, 0) });
    assert_eq!(refused(&[0], 0, &[]), SetupError::Percent { got: 0 });
    assert_eq!(refused(&[0], 101, &[]), SetupError::Percent { got: 101 });
    let fault = |robot, action| refused(&[0], 100, &[Fault { robot, action }]);
    assert_eq!(fault(1, 1), SetupError::Fault { robot_max: 0, robot: 1, action: 1 });
    assert_eq!(fault(0, 0), SetupError::Fault { robot_max: 0, robot: 0, action: 0 });
}
