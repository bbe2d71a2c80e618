//! All runs that the figures and claims of P19 need, and those of our planner beside them.

use ::coverage::{Algorithm, CoverMode};
use node::Failure;
use serde::Serialize;

use super::case::{Case, Ground, PAPER, Row, Sampling, rows};
use super::estimate::Estimate;

/// Shares of coverage in Fig. 6.
pub const PERCENTS: [u32; 7] = [90, 95, 96, 97, 98, 99, 100];

/// The paper's planners, in the order of its text.
pub const PLANNERS: [Algorithm; 4] = [
    Algorithm::Spiral,
    Algorithm::SpiralCircumnavigation,
    Algorithm::Boustrophedon,
    Algorithm::BoustrophedonCircumnavigation,
];

/// Sides of the worlds of Fig. 8. The paper has several sizes and prints none.
pub const SIDES: [u32; 4] = [10, 20, 30, 40];

/// Sizes of the teams of Fig. 8.
pub const TEAMS: [usize; 4] = [2, 4, 6, 8];

/// Share of coverage in Fig. 8.
const SHARING_PERCENT: u32 = 95;

/// Sides of the worlds of Fig. 7. The paper's is not printed.
const PAIR_SIDES: [u32; 3] = [20, 30, 40];

/// Grounds on which our planner is compared: the paper's first, then others, for which nothing was tuned.
const GROUNDS: [Ground; 5] = [
    PAPER,
    Ground { side: 10, obstacle_percent: 20.0 },
    Ground { side: 20, obstacle_percent: 0.0 },
    Ground { side: 30, obstacle_percent: 35.0 },
    Ground { side: 40, obstacle_percent: 5.0 },
];

/// The study; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Seed and number of worlds.
    pub sampling: Sampling,
    /// Fig. 6: path ratio over the share covered, one rover.
    pub single: Vec<Row>,
    /// The same on 15 × 15 cells, 98 and 100 % only.
    pub small: Vec<Row>,
    /// Fig. 7 on worlds of several sizes: four rovers, 99 %; overlap, then Voronoi.
    pub pairs: Vec<[Row; 2]>,
    /// Fig. 8: path ratio over the number of rovers for both modes.
    pub sharing: Vec<Sharing>,
    /// `cover_frontier` beside `spiral`.
    pub ours: Vec<Ours>,
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

impl Study {
    /// Every run of it.
    ///
    /// # Errors
    /// If a mission does not end.
    pub fn new(sampling: Sampling) -> Result<Self, Failure> {
        let single = all(PLANNERS, |algorithm| one(PAPER, algorithm), &PERCENTS, sampling)?;
        let small = Ground { side: 15, ..PAPER };
        let small = all(PLANNERS, |algorithm| one(small, algorithm), &[98, 100], sampling)?;
        let pair = |side| sharing(side, 4, 99, sampling).map(|pair| [pair.overlap, pair.voronoi]);
        let pairs = PAIR_SIDES.into_iter().map(pair).collect::<Result<_, _>>()?;
        let teams = SIDES.into_iter().flat_map(|side| TEAMS.map(|rovers| (side, rovers)));
        let sharing = teams
            .map(|(side, rovers)| sharing(side, rovers, SHARING_PERCENT, sampling))
            .collect::<Result<Vec<_>, _>>()?;
        let ours = GROUNDS.into_iter().flat_map(|ground| [1, 2, 4, 8].map(|rovers| (ground, rovers)));
        let ours = ours.map(|(ground, rovers)| ours_beside(ground, rovers, sampling));
        let ours = ours.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        Ok(Self { sampling, single, small, pairs, sharing, ours })
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

fn one(ground: Ground, algorithm: Algorithm) -> Case {
    Case { ground, algorithm, mode: CoverMode::Overlap, rovers: 1 }
}

fn all<T>(
    of: impl IntoIterator<Item = T>,
    case: impl Fn(T) -> Case,
    percents: &[u32],
    sampling: Sampling,
) -> Result<Vec<Row>, Failure> {
    let rows: Vec<_> =
        of.into_iter().map(|of| rows(case(of), percents, sampling)).collect::<Result<_, _>>()?;
    Ok(rows.into_iter().flatten().collect())
}

fn sharing(side: u32, rovers: usize, percent: u32, sampling: Sampling) -> Result<Sharing, Failure> {
    let ground = Ground { side, ..PAPER };
    let case = |mode| Case { ground, algorithm: Algorithm::Spiral, mode, rovers };
    let row = |mode| Ok::<_, Failure>(rows(case(mode), &[percent], sampling)?.remove(0));
    Ok(Sharing { overlap: row(CoverMode::Overlap)?, voronoi: row(CoverMode::Voronoi)? })
}

fn ours_beside(ground: Ground, rovers: usize, sampling: Sampling) -> Result<Vec<Ours>, Failure> {
    let case = |algorithm| Case { ground, algorithm, mode: CoverMode::Overlap, rovers };
    let rows = |algorithm| rows(case(algorithm), &[95, 99, 100], sampling);
    let pairs = rows(Algorithm::Spiral)?.into_iter().zip(rows(Algorithm::CoverFrontier)?);
    let cells = f64::from(ground.side * ground.side);
    let free = cells - (cells * ground.obstacle_percent / 100.0).round();
    let ours = |(spiral, ours): (Row, Row)| {
        let need = (f64::from(ours.percent) * free / 100.0).ceil();
        let bound = ((need - rovers as f64) / rovers as f64).ceil() / cells;
        Ours { saving: ours.longer(&spiral), bound, spiral, ours }
    };
    Ok(pairs.map(ours).collect())
}
