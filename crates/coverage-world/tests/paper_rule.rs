//! The rule of P19 against the path ratios of its specification, and what a team of rovers keeps to.

use contract::{Cell, Direction, Grid};
use coverage::{Algorithm, CoverMode, Placement};
use coverage_world::{Mission, Setup, World};

/// Path length over cells on 20 × 20 cells without obstacles, from the corner (0, 0).
fn path_ratio(algorithm: Algorithm, heading: Direction) -> f64 {
    let grid = Grid::new(20, 20, 1.0, 1).unwrap();
    let world = World::new(grid, vec![false; grid.cells()]).unwrap();
    let starts = vec![Placement { cell: Cell::new(0, 0), heading }];
    let outcome =
        Mission::run(&world, &Setup::new(&world, algorithm, CoverMode::Overlap, starts, 100)).unwrap();
    assert!(outcome.covered);
    outcome.steps as f64 / grid.cells() as f64
}

/// P-COVERAGE-RULE: `spiral` and `boustrophedon` cover open ground at the path ratios of their
/// specification, for every heading.
#[test]
fn open_ground_is_covered_at_the_path_ratios_of_the_specification() {
    for algorithm in [Algorithm::Spiral, Algorithm::SpiralCircumnavigation] {
        assert_eq!(Direction::ALL.map(|heading| path_ratio(algorithm, heading)), [0.9975; 4], "{algorithm}");
    }
    for algorithm in [Algorithm::Boustrophedon, Algorithm::BoustrophedonCircumnavigation] {
        let ratios = Direction::ALL.map(|heading| path_ratio(algorithm, heading));
        assert_eq!(ratios, [0.9975, 0.9975, 1.0025, 1.8525], "{algorithm}");
    }
}
