//! P19's coverage of unknown ground: a trial is one case (ground, planner, mode, number of rovers) on one random world.

use std::sync::LazyLock;

use ::campaign::{CampaignError, Study};
use ::coverage::{Algorithm, CoverMode};
use contract::Grid;
use coverage_world::{Mission, Setup, World};
use node::Failure;
use serde::{Deserialize, Serialize};

use super::Flown;
use super::case::{Case, Ground, PAPER};

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

/// It has no settings.
#[derive(clap::Args, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Coverage {}

/// How long the longest path was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steps {
    /// To each of [`PERCENTS`]; none for a share that the case is not asked for.
    pub steps: [Option<u64>; PERCENTS.len()],
}

impl Steps {
    /// To one of [`PERCENTS`].
    ///
    /// # Panics
    /// If the case was not asked for it.
    pub fn to(&self, percent: u32) -> u64 {
        let place = PERCENTS.iter().position(|known| *known == percent);
        place.and_then(|place| self.steps[place]).expect("a share that the case is asked for")
    }
}

impl Study for Coverage {
    const NAME: &'static str = "p19";
    /// The intervals are those of samples of at least 100.
    const WORLDS_MIN: u64 = 100;
    type Outcome = Steps;

    fn headings() -> Vec<String> {
        PERCENTS.map(|percent| format!("steps_to_{percent}_percent")).into()
    }

    fn cases() -> &'static [String] {
        static NAMES: LazyLock<Vec<String>> =
            LazyLock::new(|| CASES.iter().map(|asked| asked.case.to_string()).collect());
        &NAMES
    }

    fn check_settings(&self) -> Result<(), CampaignError> {
        Ok(())
    }

    fn world_seed(campaign_seed: u64, repetition: u64) -> u64 {
        campaign_seed.wrapping_mul(1_000_000).wrapping_add(repetition)
    }

    fn check_outcome(case: usize, outcome: &Steps) -> Result<(), String> {
        for (percent, steps) in PERCENTS.iter().zip(outcome.steps) {
            if CASES[case].percents.contains(percent) != steps.is_some() {
                let got = steps.map_or("none".into(), |steps| steps.to_string());
                let need = if steps.is_some() { "none" } else { "a number of steps" };
                return Err(format!("steps to {percent} %: need {need}, got {got}"));
            }
        }
        let known: Vec<u64> = outcome.steps.into_iter().flatten().collect();
        if known.is_sorted() { Ok(()) } else { Err(format!("steps: need ascending ones, got {known:?}")) }
    }
}

/// A world with random starts.
fn world(case: Case, seed: u64) -> Result<(World, Vec<coverage::Placement>), Failure> {
    let Ground { side, obstacle_percent } = case.ground;
    let grid = Grid::new(side, side, 1.0, 1).map_err(Failure::usage)?;
    let world = World::random(grid, obstacle_percent, seed).map_err(Failure::usage)?;
    let starts = world.random_starts(case.rovers, seed).map_err(Failure::usage)?;
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
) -> Result<coverage_world::Outcome, Failure> {
    let (world, starts) = world(case, seed)?;
    let setup = Setup::new(&world, case.algorithm, case.mode, starts, percent);
    let mut mission = Mission::new(&world, &setup).map_err(Failure::usage)?;
    while !mission.is_over() {
        look(&world, &mission);
        mission.round();
    }
    look(&world, &mission);
    let outcome = mission.outcome();
    if outcome.covered {
        return Ok(outcome);
    }
    Err(Failure::run(format!(
        "{} does not cover {percent} % of the world of seed {seed} within {} steps",
        case.algorithm, setup.steps_max
    )))
}

impl Flown for Coverage {
    type Ground = ();

    fn ground(&self) {}

    fn fly(&self, (): &(), case: usize, seed: u64) -> Result<Steps, Failure> {
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
}
