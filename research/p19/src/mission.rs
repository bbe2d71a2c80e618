//! Flies cases on random worlds.

use contract::Grid;
use coverage::{CoverMode, Placement};
use coverage_world::{Mission, Outcome, Setup, World};

use crate::case::{Case, Ground};
use crate::cases::{Asked, CASES, PERCENTS};
use crate::error::P19Error;
use crate::steps::Steps;

/// The world of `seed` with random starts.
fn world(case: Case, seed: u64) -> Result<(World, Vec<Placement>), P19Error> {
    let Ground { side, obstacle_percent } = case.ground;
    let grid = Grid::new(side, side, 1.0, 1)?;
    let world = World::random(grid, obstacle_percent, seed)?;
    let starts = world.random_starts(case.rovers, seed)?;
    Ok((world, starts))
}

/// Flies `case` to `percent` on the world of `seed`; `look` is shown the mission before each round and at its end.
///
/// # Errors
/// If the world cannot be made, or the mission does not end.
pub fn mission(
    case: Case,
    percent: u32,
    seed: u64,
    mut look: impl FnMut(&World, &Mission<'_>),
) -> Result<Outcome, P19Error> {
    let (world, starts) = world(case, seed)?;
    let setup = Setup::new(&world, case.algorithm, case.mode, starts, percent);
    let mut mission = Mission::new(&world, &setup)?;
    while !mission.is_over() {
        look(&world, &mission);
        mission.round();
    }
    look(&world, &mission);
    let outcome = mission.outcome();
    if outcome.covered {
        return Ok(outcome);
    }
    let (algorithm, steps_max) = (case.algorithm, setup.steps_max);
    Err(P19Error::NotCovered { algorithm, percent, seed, steps_max })
}

/// Flies a case of [`CASES`] on the world of `seed`, to each share of coverage that it is asked for.
///
/// # Errors
/// As [`mission`].
///
/// # Panics
/// If there is no such case.
pub fn fly(case: usize, seed: u64) -> Result<Steps, P19Error> {
    let Asked { case, percents } = CASES[case];
    let fly = |percent| mission(case, percent, seed, |_, _| {});
    let mut steps = [None; PERCENTS.len()];
    let places = percents.iter().map(|percent| {
        let place = PERCENTS.iter().position(|known| known == percent);
        (place.expect("one of the shares"), *percent)
    });
    match case.mode {
        // No rover stops before all do, so one mission shows when each share was covered.
        CoverMode::Overlap => {
            let outcome = fly(percents.iter().copied().max().unwrap_or(100))?;
            places.for_each(|(place, percent)| steps[place] = outcome.steps_to(percent));
        }
        CoverMode::Voronoi => {
            for (place, percent) in places {
                steps[place] = Some(fly(percent)?.steps);
            }
        }
    }
    Ok(Steps { steps })
}
