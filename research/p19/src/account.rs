//! Path ratios that the figures and claims of P19 need, and those of our planner beside them.

use coverage::Algorithm;
use serde::Serialize;

use crate::cases::{CASES, GROUNDS, OUR_TEAMS, PAIR_SIDES, PLANNERS, SIDES, TEAMS};
use crate::estimate::Estimate;
use crate::row::Row;
use crate::steps::Steps;

/// Which worlds were drawn, and how many.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sampling {
    /// Runs have the seeds from a million times this number on.
    pub seed: u64,
    /// Worlds for each case.
    pub runs: u64,
}

/// The study; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Account {
    /// Seed and number of worlds.
    pub sampling: Sampling,
    /// Fig. 6: path ratio over the share covered, one rover.
    pub single: Vec<Row>,
    /// Path ratio over the share covered, one rover on 15 × 15 cells, 98 and 100 % only.
    pub small: Vec<Row>,
    /// Fig. 7 on worlds of several sizes: four rovers, 99 %; overlap, then Voronoi.
    pub pairs: Vec<[Row; 2]>,
    /// Fig. 8: path ratio over the number of rovers for both modes.
    pub sharing: Vec<Sharing>,
    /// `cover_frontier` beside `spiral`.
    pub ours: Vec<Ours>,
    /// Seeds of the worlds, in the order of the ratios of each row.
    #[serde(skip)]
    pub seeds: Vec<u64>,
}

/// One ground and team in both modes, with the paper's spiral.
#[derive(Clone, Debug, Serialize)]
pub struct Sharing {
    /// All rovers on all ground.
    pub overlap: Row,
    /// Each rover in its region.
    pub voronoi: Row,
}

/// One ground, team and share with our planner and with the paper's best, both in overlap.
#[derive(Clone, Debug, Serialize)]
pub struct Ours {
    /// `spiral`.
    pub spiral: Row,
    /// `cover_frontier`.
    pub ours: Row,
    /// Mean of the path ratio that ours saves, on the same worlds.
    pub saving: Estimate,
    /// Path ratio that no planner can undercut: rovers that never visit a cell twice.
    pub bound: f64,
}

impl Account {
    /// The account of a campaign with seed `seed`. Each world has its own seed and the outcomes of
    /// all [`CASES`] on it.
    #[must_use]
    pub fn new(seed: u64, worlds: &[(u64, &[Steps])]) -> Self {
        let of_case =
            |(case, asked)| Row::all(asked, worlds.iter().map(move |(_, outcomes)| &outcomes[case]));
        let mut rows = CASES.iter().enumerate().map(of_case);
        let mut next = |cases: usize| rows.by_ref().take(cases).collect::<Vec<_>>();
        Self {
            sampling: Sampling { seed, runs: worlds.len() as u64 },
            single: next(PLANNERS.len()).concat(),
            small: next(PLANNERS.len()).concat(),
            pairs: next(2 * PAIR_SIDES.len())
                .chunks(2)
                .map(|both| [0, 1].map(|n| both[n][0].clone()))
                .collect(),
            sharing: next(2 * SIDES.len() * TEAMS.len())
                .chunks(2)
                .map(|both| Sharing { overlap: both[0][0].clone(), voronoi: both[1][0].clone() })
                .collect(),
            ours: next(2 * GROUNDS.len() * OUR_TEAMS.len())
                .chunks(2)
                .flat_map(|both| both[0].iter().zip(&both[1]).map(Ours::new))
                .collect(),
            seeds: worlds.iter().map(|(seed, _)| *seed).collect(),
        }
    }
}

impl Sharing {
    /// Share of the worlds in which the path of Voronoi is at most as long as that of overlap.
    #[must_use]
    pub fn voronoi_as_short(&self) -> Estimate {
        let pairs = self.overlap.ratios.iter().zip(&self.voronoi.ratios);
        Estimate::mean(pairs.map(|(overlap, voronoi)| f64::from(voronoi <= overlap)))
    }
}

impl Ours {
    fn new((spiral, ours): (&Row, &Row)) -> Self {
        let (ground, rovers) = (ours.case.ground, ours.case.rovers as f64);
        let cells = f64::from(ground.side * ground.side);
        let free = cells - (cells * ground.obstacle_percent / 100.0).round();
        let need = (f64::from(ours.percent) * free / 100.0).ceil();
        let bound = ((need - rovers) / rovers).ceil() / cells;
        Self { saving: ours.longer(spiral), bound, spiral: spiral.clone(), ours: ours.clone() }
    }
}

/// The row of `algorithm` at `percent`.
///
/// # Panics
/// If there is none.
pub fn row(rows: &[Row], algorithm: Algorithm, percent: u32) -> &Row {
    let wanted = |row: &&Row| row.case.algorithm == algorithm && row.percent == percent;
    rows.iter().find(wanted).expect("a row for each planner and share")
}
