//! The single-agent study of P21: a trial is one random grid, with the paths of all choices.

use std::sync::LazyLock;

use ::campaign::{CampaignError, Study};
use node::Failure;
use p21::{CellType, Choice, GRID_SIDE, SingleGrid, simple_paths};
use serde::{Deserialize, Serialize};

use super::Flown;

/// Cells whose information counts as early.
pub const EARLY: usize = 5;

/// It has no settings.
#[derive(clap::Args, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Single {}

/// The paths of a grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trips {
    /// In the order of the choices.
    pub choices: [Trip; Choice::ALL.len()],
}

/// What one path of one grid came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trip {
    /// Its cells, numbered row by row, with hyphens between.
    pub path: String,
    /// Share of all information that it gains.
    pub information: f64,
    /// Share of all information that its first cells gain.
    pub early: f64,
    /// Types of cells seen.
    pub types: usize,
    /// Its expected time.
    pub expected_time: f64,
    /// Its true time.
    pub true_time: f64,
    /// True time of a second agent that knows what this one has seen.
    pub follower_time: f64,
}

impl Trip {
    fn new(grid: &SingleGrid, paths: &[Vec<usize>], choice: Choice) -> Self {
        let path = grid.best(paths, choice);
        let known = grid.known(path);
        let information = grid.information(path);
        Self {
            path: path.iter().map(usize::to_string).collect::<Vec<_>>().join("-"),
            information: information[information.len() - 1],
            early: information[EARLY - 1],
            types: known.iter().filter(|known| **known).count(),
            expected_time: grid.time(path, CellType::expected),
            true_time: grid.time(path, CellType::true_time),
            follower_time: grid.time(grid.follower(paths, &known), CellType::true_time),
        }
    }

    /// The cells of the path.
    ///
    /// # Errors
    /// If it is no way from corner to corner.
    pub fn cells(&self) -> Result<Vec<usize>, String> {
        let odd = || {
            format!("path: need cells from 0 to {}, each beside the one before, got {:?}", LAST, self.path)
        };
        let cells: Vec<usize> =
            self.path.split('-').map(str::parse).collect::<Result<_, _>>().map_err(|_| odd())?;
        let place = |cell: usize| (cell % GRID_SIDE, cell / GRID_SIDE);
        let beside = |pair: &[usize]| {
            let ((x, y), (to_x, to_y)) = (place(pair[0]), place(pair[1]));
            x.abs_diff(to_x) + y.abs_diff(to_y) == 1
        };
        let ends = (cells.first(), cells.last()) == (Some(&0), Some(&LAST));
        let simple = cells.len() <= LAST + 1 && cells.iter().all(|cell| *cell <= LAST);
        if ends && simple && cells.windows(2).all(beside) { Ok(cells) } else { Err(odd()) }
    }
}

/// The last cell, where every path ends.
const LAST: usize = GRID_SIDE * GRID_SIDE - 1;

impl Study for Single {
    const NAME: &'static str = "p21-single";
    const WORLDS_MIN: u64 = 2;
    type Outcome = Trips;

    fn headings() -> Vec<String> {
        let fields = ["path", "information", "early", "types", "expected_time", "true_time", "follower_time"];
        let of = |choice: &Choice| fields.map(|field| format!("{}_{field}", choice.key()));
        Choice::ALL.iter().flat_map(of).collect()
    }

    fn cases() -> &'static [String] {
        static CASES: LazyLock<[String; 1]> = LazyLock::new(|| ["grid".into()]);
        &*CASES
    }

    fn check_settings(&self) -> Result<(), CampaignError> {
        Ok(())
    }

    fn world_seed(campaign_seed: u64, repetition: u64) -> u64 {
        campaign_seed.wrapping_add(repetition)
    }

    fn check_outcome(_case: usize, outcome: &Trips) -> Result<(), String> {
        outcome.choices.iter().try_for_each(|trip| trip.cells().map(drop))
    }
}

impl Flown for Single {
    /// All simple paths from corner to corner.
    type Ground = Vec<Vec<usize>>;

    fn ground(&self) -> Vec<Vec<usize>> {
        simple_paths()
    }

    fn fly(&self, paths: &Vec<Vec<usize>>, _case: usize, seed: u64) -> Result<Trips, Failure> {
        let grid = SingleGrid::random(seed);
        Ok(Trips { choices: Choice::ALL.map(|choice| Trip::new(&grid, paths, choice)) })
    }
}
