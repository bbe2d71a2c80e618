//! Missions of one kind, on many random worlds.

use ::coverage::{Algorithm, CoverMode};
use contract::Grid;
use coverage_world::{Mission, Setup, World};
use node::Failure;
use rayon::prelude::*;
use serde::Serialize;

use super::estimate::{Estimate, Moments};

/// A square world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ground {
    /// Cells to a side.
    pub side: u32,
    /// Share of the cells that are obstacles.
    pub obstacle_percent: f64,
}

/// The paper's world, as far as it is known: 10 % is the specification's choice, and the paper's sizes are not printed.
pub const PAPER: Ground = Ground { side: 20, obstacle_percent: 10.0 };

/// Who covers what.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Case {
    /// Size of the worlds, and their share of obstacles.
    #[serde(flatten)]
    pub ground: Ground,
    /// Planner of all rovers.
    pub algorithm: Algorithm,
    /// How they share the ground.
    pub mode: CoverMode,
    /// Number of rovers, with random starts and headings.
    pub rovers: usize,
}

/// Path ratios of a case at one share of coverage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The missions that were flown.
    #[serde(flatten)]
    pub case: Case,
    /// Share of the reachable cells that was to be covered.
    pub percent: u32,
    /// Mean path ratio: steps of the longest path over all cells of the grid (P19 eq. 2).
    pub mean: Estimate,
    /// Standard deviation of the path ratio.
    pub sd: f64,
    /// By run. Runs of one number have the same world and starts in every case of the same ground and number of rovers.
    #[serde(skip)]
    pub ratios: Vec<f64>,
}

impl Row {
    /// Ratios of this row and of `other` on the same worlds.
    pub fn beside(&self, other: &Row) -> Vec<[f64; 2]> {
        self.ratios.iter().copied().zip(other.ratios.iter().copied()).map(Into::into).collect()
    }

    /// How much longer `other` is: the mean of its ratio minus this one, on the same worlds.
    pub fn longer(&self, other: &Row) -> Estimate {
        Estimate::mean(self.ratios.iter().zip(&other.ratios).map(|(own, other)| other - own))
    }

    /// The value that a share `below` of the runs does not exceed.
    pub fn quantile(&self, below: f64) -> f64 {
        let mut ratios = self.ratios.clone();
        ratios.sort_by(f64::total_cmp);
        ratios[((ratios.len() - 1) as f64 * below).round() as usize]
    }

    /// Share of the runs with at most `ratio`.
    pub fn share_up_to(&self, ratio: f64) -> f64 {
        self.ratios.iter().filter(|got| **got <= ratio).count() as f64 / self.ratios.len() as f64
    }
}

/// Which worlds are drawn, and how many.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sampling {
    /// Runs have the seeds from a million times this number on.
    pub seed: u64,
    /// Worlds for each case.
    pub runs: u64,
}

/// A row for each share of `percents`.
///
/// # Errors
/// If a world cannot be made, or a mission does not end.
pub fn rows(case: Case, percents: &[u32], sampling: Sampling) -> Result<Vec<Row>, Failure> {
    let runs: Vec<Vec<f64>> = (0..sampling.runs)
        .into_par_iter()
        .map(|run| ratios(case, percents, sampling.seed.wrapping_mul(1_000_000).wrapping_add(run)))
        .collect::<Result<_, _>>()?;
    let row = |(n, percent): (usize, &u32)| {
        let ratios: Vec<f64> = runs.iter().map(|run| run[n]).collect();
        let [sd, _] = Moments::of(ratios.iter().map(|ratio| [*ratio, 0.0])).deviations();
        Row { case, percent: *percent, mean: Estimate::mean(ratios.iter().copied()), sd, ratios }
    };
    Ok(percents.iter().enumerate().map(row).collect())
}

/// Path ratios of one run at `percents`.
fn ratios(case: Case, percents: &[u32], seed: u64) -> Result<Vec<f64>, Failure> {
    let Ground { side, obstacle_percent } = case.ground;
    let grid = Grid::new(side, side, 1.0, 1).map_err(Failure::usage)?;
    let world = World::random(grid, obstacle_percent, seed).map_err(Failure::usage)?;
    let starts = world.random_starts(case.rovers, seed).map_err(Failure::usage)?;
    let run = |percent| {
        let setup = Setup::new(&world, case.algorithm, case.mode, starts.clone(), percent);
        let outcome = Mission::run(&world, &setup).map_err(Failure::usage)?;
        if outcome.covered {
            Ok(outcome)
        } else {
            Err(Failure::run(format!(
                "{} does not cover {percent} % of the world of seed {seed} within {} steps",
                case.algorithm, setup.steps_max
            )))
        }
    };
    let ratio = |steps: u64| steps as f64 / grid.cells() as f64;
    match case.mode {
        // No rover stops before all do, so one mission shows when each share was covered.
        CoverMode::Overlap => {
            let outcome = run(percents.iter().copied().max().unwrap_or(100))?;
            Ok(percents.iter().filter_map(|percent| outcome.steps_to(*percent)).map(ratio).collect())
        }
        CoverMode::Voronoi => percents.iter().map(|percent| Ok(ratio(run(*percent)?.steps))).collect(),
    }
}
