//! No decision depends on ground that no rover has sensed, nor on what a planner remembers.

use contract::{Cell, Grid};
use coverage::{Algorithm, CoverMode, Knowledge, Planner};
use coverage_world::{Mission, Sensing, Setup, World};
use proptest::prelude::*;

fn obstacles(world: &World) -> Vec<bool> {
    world.grid().iter().map(|cell| !world.is_free(cell)).collect()
}

fn setup(
    world: &World,
    algorithm: Algorithm,
    voronoi: bool,
    two_steps: bool,
    rovers: usize,
    seed: u64,
) -> Setup {
    let mode = if voronoi { CoverMode::Voronoi } else { CoverMode::Overlap };
    let starts = world.random_starts(rovers, seed).unwrap();
    let sensing = if two_steps { Sensing::TwoSteps } else { Sensing::OneStep };
    Setup { sensing, ..Setup::new(world, algorithm, mode, starts, 100) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// P-MYOPIC. The same rovers drive on two worlds that differ only where no rover has sensed.
    /// They do the same until one of them senses the difference.
    #[test]
    fn unsensed_ground_changes_no_decision(
        seed in 0_u64..1000,
        algorithm in prop::sample::select(Algorithm::ALL.to_vec()),
        voronoi: bool,
        two_steps: bool,
        rovers in 1_usize..=8,
        changed in 0_usize..144,
    ) {
        let grid = Grid::new(12, 12, 1.0, 1).unwrap();
        let world = World::random(grid, 10.0, seed).unwrap();
        let setup = setup(&world, algorithm, voronoi, two_steps, rovers, seed);
        let mut other = obstacles(&world);
        other[changed] = !other[changed];
        let other = World::new(grid, other).unwrap();
        let unsensed = |mission: &Mission<'_>| mission.map().knowledge(grid.cell(changed)) == Knowledge::Unknown;
        // The setup itself may not fit the other world, where a rover would start on the changed cell.
        let Ok(mut there) = Mission::new(&other, &setup) else { return Ok(()) };
        let mut here = Mission::new(&world, &setup).unwrap();
        while unsensed(&here) && unsensed(&there) && !here.is_over() && !there.is_over() {
            prop_assert_eq!(here.map(), there.map());
            prop_assert_eq!(here.rovers(), there.rovers());
            here.round();
            there.round();
        }
    }

    /// The law of planners: memory saves time and changes no answer.
    #[test]
    fn a_planner_with_empty_memory_decides_the_same(
        seed in 0_u64..1000,
        algorithm in prop::sample::select(Algorithm::ALL.to_vec()),
        voronoi: bool,
        rovers in 1_usize..=8,
    ) {
        let world = World::random(Grid::new(12, 12, 1.0, 1).unwrap(), 10.0, seed).unwrap();
        let setup = setup(&world, algorithm, voronoi, false, rovers, seed);
        let mut mission = Mission::new(&world, &setup).unwrap();
        let mut experienced = Planner::new(algorithm);
        while !mission.is_over() {
            for robot in 0..rovers {
                let situation = mission.situation(robot);
                let decision = experienced.decide(&situation);
                prop_assert_eq!(decision, Planner::new(algorithm).decide(&situation));
            }
            mission.round();
        }
    }
}

#[test]
fn a_rover_senses_the_cells_around_it_and_no_others() {
    let grid = Grid::new(9, 9, 1.0, 1).unwrap();
    let world = World::random(grid, 10.0, 1).unwrap();
    let starts = world.random_starts(1, 1).unwrap();
    let Cell { x, y } = starts[0].cell;
    for (sensing, range) in [(Sensing::OneStep, 1), (Sensing::TwoSteps, 2)] {
        let setup = Setup {
            sensing,
            ..Setup::new(&world, Algorithm::Spiral, CoverMode::Overlap, starts.clone(), 100)
        };
        let mission = Mission::new(&world, &setup).unwrap();
        for cell in grid.iter() {
            let sensed = (cell.x - x).abs() <= range && (cell.y - y).abs() <= range;
            let truth = if world.is_free(cell) { Knowledge::Free } else { Knowledge::Obstacle };
            assert_eq!(
                mission.map().knowledge(cell),
                if sensed { truth } else { Knowledge::Unknown },
                "{cell}"
            );
        }
        assert_eq!(mission.map().knowledge(Cell::new(-1, 0)), Knowledge::Outside);
    }
}
