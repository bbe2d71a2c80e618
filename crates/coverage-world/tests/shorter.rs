//! `cover_frontier` needs shorter paths than the paper's best rule.

use contract::Grid;
use coverage::{Algorithm, CoverMode};
use coverage_world::{Mission, Outcome, Setup, World};

const WORLDS: u64 = 60;

fn outcome(world: &World, algorithm: Algorithm, rovers: usize, seed: u64) -> Outcome {
    let starts = world.random_starts(rovers, seed).unwrap();
    let outcome =
        Mission::run(world, &Setup::new(world, algorithm, CoverMode::Overlap, starts, 100)).unwrap();
    assert!(outcome.covered);
    outcome
}

/// P-SHORTER: `cover_frontier` covers 95, 99 and 100 % in fewer steps than `spiral`, with 1, 2, 4
/// and 8 rovers, on the paper's worlds and on others.
///
/// On the paper's worlds and on others, the saving of steps is above 0 by four standard errors of
/// its mean.
#[test]
fn cover_frontier_is_shorter_than_spiral_for_every_team_and_share() {
    for (side, obstacle_percent) in [(20, 10.0), (15, 25.0), (30, 0.0)] {
        for rovers in [1, 2, 4, 8] {
            let pairs: Vec<[Outcome; 2]> = (0..WORLDS)
                .map(|seed| {
                    let grid = Grid::new(side, side, 1.0, 1).unwrap();
                    let world = World::random(grid, obstacle_percent, seed).unwrap();
                    [Algorithm::Spiral, Algorithm::CoverFrontier]
                        .map(|algorithm| outcome(&world, algorithm, rovers, seed))
                })
                .collect();
            for percent in [95, 99, 100] {
                let steps = |outcome: &Outcome| outcome.steps_to(percent).unwrap() as f64;
                let savings: Vec<f64> =
                    pairs.iter().map(|[spiral, ours]| steps(spiral) - steps(ours)).collect();
                let mean = savings.iter().sum::<f64>() / WORLDS as f64;
                let squares: f64 = savings.iter().map(|saving| (saving - mean).powi(2)).sum();
                let error = (squares / (WORLDS - 1) as f64 / WORLDS as f64).sqrt();
                assert!(
                    mean > 4.0 * error,
                    "{side} × {side}, {obstacle_percent} %, {rovers} rovers, {percent} %: {mean} ± {error} steps"
                );
            }
        }
    }
}
