//! The paper's rule to stop (Algorithm 1, line 13) beside ours.
//!
//! The paper's rover does not know which cells it can reach: it counts the cells of the grid less the obstacles that it has met so
//! far. An obstacle that no rover ever senses, because others surround it, would count as ground to be covered for ever.

use coverage::{Algorithm, Knowledge};
use serde::Serialize;

use crate::case::{Case, PAPER};
use crate::cases::{PERCENTS, PLANNERS};
use crate::error::P19Error;
use crate::estimate::Estimate;
use crate::mission::mission;

/// Shares of coverage that both rules are compared at, of [`PERCENTS`].
const COMPARED: [u32; 4] = [95, 97, 98, 100];

/// One rover of the paper's on its ground, by both rules.
#[derive(Clone, Debug, Serialize)]
pub struct StopRule {
    /// Its planner.
    pub algorithm: Algorithm,
    /// Share that was to be covered.
    pub percent: u32,
    /// Worlds in which it stops by the paper's rule.
    pub stopped: u64,
    /// All worlds.
    pub runs: u64,
    /// Mean path ratio by the paper's rule, where it stops.
    pub mean: Estimate,
    /// How much longer that is than by ours, on the same worlds.
    pub longer: Estimate,
}

/// Steps to each of [`PERCENTS`] by the paper's rule; none where it never stops.
///
/// # Errors
/// If the world cannot be made, or the mission does not end by ours.
pub fn steps(algorithm: Algorithm, seed: u64) -> Result<[Option<u64>; PERCENTS.len()], P19Error> {
    let mut steps = [None; PERCENTS.len()];
    mission(case(algorithm), 100, seed, |_, mission| {
        let map = mission.map();
        let (mut visited, mut counted) = (0, 0);
        for cell in map.grid().iter() {
            visited += u64::from(map.visits(cell) > 0);
            counted += u64::from(map.knowledge(cell) != Knowledge::Obstacle);
        }
        let steps_now = mission.outcome().steps;
        for (percent, steps) in PERCENTS.iter().zip(&mut steps) {
            if steps.is_none() && 100 * visited >= u64::from(*percent) * counted {
                *steps = Some(steps_now);
            }
        }
    })?;
    Ok(steps)
}

fn case(algorithm: Algorithm) -> Case {
    Case { ground: PAPER, algorithm, mode: coverage::CoverMode::Overlap, rovers: 1 }
}

/// Both rules compared: `flown` has the steps of each of the paper's planners by its rule, world by world, and `ours` those by ours.
#[must_use]
pub fn compared(
    flown: &[[[Option<u64>; PERCENTS.len()]; PLANNERS.len()]],
    ours: impl Fn(Algorithm, u32) -> Vec<f64>,
) -> Vec<StopRule> {
    let cells = f64::from(PAPER.side.pow(2));
    let row = |(number, algorithm): (usize, Algorithm), percent: u32| {
        let place = PERCENTS.iter().position(|known| *known == percent).expect("one of the shares");
        let theirs = flown.iter().map(|world| world[number][place].map(|steps| steps as f64 / cells));
        let pairs: Vec<(f64, f64)> =
            theirs.zip(ours(algorithm, percent)).filter_map(|(theirs, ours)| Some((theirs?, ours))).collect();
        StopRule {
            algorithm,
            percent,
            stopped: pairs.len() as u64,
            runs: flown.len() as u64,
            mean: Estimate::mean(pairs.iter().map(|pair| pair.0)),
            longer: Estimate::mean(pairs.iter().map(|pair| pair.0 - pair.1)),
        }
    };
    let planners = PLANNERS.into_iter().enumerate();
    planners.flat_map(|planner| COMPARED.map(|percent| row(planner, percent))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mission;

    #[test]
    fn the_papers_rule_stops_no_sooner_and_at_100_percent_at_the_same_step_or_never() {
        let (mut later, mut never) = (0, 0);
        for seed in 0..60 {
            let theirs = steps(Algorithm::Spiral, seed).unwrap();
            let outcome = mission(case(Algorithm::Spiral), 100, seed, |_, _| {}).unwrap();
            for (percent, theirs) in PERCENTS.into_iter().zip(theirs) {
                let ours = outcome.steps_to(percent).unwrap();
                match theirs {
                    None => never += 1,
                    Some(theirs) if percent == 100 => assert_eq!(theirs, ours, "seed {seed}"),
                    Some(theirs) => {
                        assert!(theirs >= ours, "seed {seed}, {percent} %: {theirs} before {ours}");
                        later += usize::from(theirs > ours);
                    }
                }
            }
        }
        assert!(later > 10, "{later}");
        assert!(never < 60, "{never}");
    }
}
