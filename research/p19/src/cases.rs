//! The cases of the study: the grounds, planners and teams that its figures need.

use std::sync::LazyLock;

use coverage::{Algorithm, CoverMode};

use crate::case::{Case, Ground, PAPER};

/// Shares of coverage, in percent, of which some case tells how long the path to them is.
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
pub const PAIR_SIDES: [u32; 3] = [20, 30, 40];

/// Rovers of Fig. 7.
const PAIR_ROVERS: usize = 4;

/// Grounds on which our planner is compared: the paper's first, then others, for which nothing was tuned.
pub const GROUNDS: [Ground; 5] = [
    PAPER,
    Ground { side: 10, obstacle_percent: 20.0 },
    Ground { side: 20, obstacle_percent: 0.0 },
    Ground { side: 30, obstacle_percent: 35.0 },
    Ground { side: 40, obstacle_percent: 5.0 },
];

/// Teams with which our planner is compared.
pub const OUR_TEAMS: [usize; 4] = [1, 2, 4, 8];

/// A case, and the shares of coverage that it is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// The case.
    pub case: Case,
    /// In percent, ascending, of [`PERCENTS`].
    pub percents: &'static [u32],
}

/// All cases: those of Fig. 6 on 20 × 20 and on 15 × 15 cells, of Fig. 7, of Fig. 8, and of our planner beside `spiral`.
pub static CASES: LazyLock<Vec<Asked>> = LazyLock::new(|| {
    let one = |ground, algorithm| Case { ground, algorithm, mode: CoverMode::Overlap, rovers: 1 };
    let asked = |percents| move |case| Asked { case, percents };
    let small = Ground { side: 15, ..PAPER };
    let both_modes = |(side, rovers): (u32, usize)| {
        let ground = Ground { side, ..PAPER };
        [CoverMode::Overlap, CoverMode::Voronoi].map(|mode| Case {
            ground,
            algorithm: Algorithm::Spiral,
            mode,
            rovers,
        })
    };
    let both_planners = |(ground, rovers): (Ground, usize)| {
        [Algorithm::Spiral, Algorithm::CoverFrontier].map(|algorithm| Case {
            ground,
            algorithm,
            mode: CoverMode::Overlap,
            rovers,
        })
    };
    let teams = SIDES.into_iter().flat_map(|side| TEAMS.map(|rovers| (side, rovers)));
    let ours = GROUNDS.into_iter().flat_map(|ground| OUR_TEAMS.map(|rovers| (ground, rovers)));
    PLANNERS
        .map(|algorithm| one(PAPER, algorithm))
        .into_iter()
        .map(asked(&PERCENTS[..]))
        .chain(PLANNERS.map(|algorithm| one(small, algorithm)).into_iter().map(asked(&[98, 100])))
        .chain(PAIR_SIDES.into_iter().flat_map(|side| both_modes((side, PAIR_ROVERS))).map(asked(&[99])))
        .chain(teams.flat_map(both_modes).map(asked(&[SHARING_PERCENT])))
        .chain(ours.flat_map(both_planners).map(asked(&[95, 99, 100])))
        .collect()
});
