//! Path ratios of a case on many random worlds.

use serde::Serialize;

use crate::case::Case;
use crate::cases::Asked;
use crate::estimate::{Estimate, Moments};
use crate::steps::Steps;

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
    /// A row for each share that a case is asked for.
    pub fn all<'a>(asked: &Asked, worlds: impl Iterator<Item = &'a Steps> + Clone) -> Vec<Self> {
        let cells = f64::from(asked.case.ground.side.pow(2));
        let row = |percent: &u32| {
            let ratios: Vec<f64> = worlds.clone().map(|steps| steps.to(*percent) as f64 / cells).collect();
            let [sd, _] = Moments::of(ratios.iter().map(|ratio| [*ratio, 0.0])).deviations();
            let mean = Estimate::mean(ratios.iter().copied());
            Self { case: asked.case, percent: *percent, mean, sd, ratios }
        };
        asked.percents.iter().map(row).collect()
    }

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
