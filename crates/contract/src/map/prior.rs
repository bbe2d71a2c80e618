//! What is known of the ground of a driving rover before the mission, and how it travels.
//!
//! The prior of the whole map is served in pages, as the truth is, but to planners: it holds heights and probabilities only.

use serde::{Deserialize, Serialize};

use crate::{DriveSpeed, Grid, Refusal, RunId};

/// How likely each of the four speeds is on a cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct SpeedPrior([f64; 4]);

impl SpeedPrior {
    /// How far the sum of the probabilities may be from 1.
    pub const SUM_TOLERANCE: f64 = 1e-6;

    /// The prior with these probabilities, in the order of [`DriveSpeed::ALL`]. They are kept bit for bit.
    ///
    /// # Errors
    /// If one is no probability, or they do not sum to 1.
    pub fn new(probabilities: [f64; 4]) -> Result<Self, Refusal> {
        if let Some(got) = probabilities.iter().find(|probability| !(0.0..=1.0).contains(*probability)) {
            return Err(Refusal::malformed("prior.probability", "0 to 1", got));
        }
        let sum: f64 = probabilities.iter().sum();
        if (sum - 1.0).abs() > Self::SUM_TOLERANCE {
            return Err(Refusal::malformed("prior.sum", "1, the sum of the four probabilities", sum));
        }
        Ok(Self(probabilities))
    }

    /// The probabilities in the order of [`DriveSpeed::ALL`].
    #[must_use]
    pub fn probabilities(&self) -> [f64; 4] {
        self.0
    }

    /// The probability of one speed.
    #[must_use]
    pub fn probability(&self, speed: DriveSpeed) -> f64 {
        self.0[speed as usize]
    }
}

/// What is known of a cell beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PriorCell {
    /// How likely each speed is.
    pub speeds: SpeedPrior,
    /// Height at the middle of the cell, metres; slopes follow from heights.
    pub height_m: f64,
}

/// The prior of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prior {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// Lattice of the mission.
    pub grid: Grid,
    /// In index order, one for each cell.
    pub cells: Vec<PriorCell>,
}

/// Asks hopper-sim for the prior from an index on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PriorRequest {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// First index wanted.
    pub from: u32,
}

/// Consecutive cells of the prior, at most [`crate::limits::PRIOR_PAGE_CELLS`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PriorPage {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// Lattice of the mission.
    pub grid: Grid,
    /// Index of the first cell.
    pub from: u32,
    /// In index order.
    pub cells: Vec<PriorCell>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P-PRIOR-SUM: Priors that do not add up are refused by name.
    #[test]
    fn priors_that_do_not_add_up_are_refused_by_name() {
        for (probabilities, need) in [
            ([0.5, 0.5, 0.5, 0.0], "prior.sum"),
            ([0.0; 4], "prior.sum"),
            ([1.5, -0.5, 0.0, 0.0], "prior.probability"),
            ([f64::NAN, 0.0, 0.0, 1.0], "prior.probability"),
        ] {
            let refusal = SpeedPrior::new(probabilities).unwrap_err().to_string();
            assert!(refusal.contains(need), "{refusal}");
        }
        let third = [0.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0];
        assert_eq!(SpeedPrior::new(third).unwrap().probabilities(), third);
    }
}
