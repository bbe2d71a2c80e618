//! The scatter of hops on one soil, and the time they take.

use crate::Error;

/// The landings of hops on flat ground of one soil, and the time they take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Soil {
    /// Probability p of the intended landing.
    pub intended: f64,
    /// Probability q of staying at the node of departure.
    pub stuck: f64,
    /// Probability s of a slip to either side; all four landings sum to 1.
    pub sideways: f64,
    /// Share of the hops that take a second period, spent where they start: 0 on hard ground, 1 where
    /// every hop takes two.
    pub wait: f64,
}

impl Soil {
    /// The discount between departure and landing: γ (1 − λ + λγ).
    #[must_use]
    pub fn discount(&self, discount: f64) -> f64 {
        discount * (1.0 - self.wait + self.wait * discount)
    }

    /// The soil that behaves, in expectation under `discount`, as if it were each of `parts` with the
    /// probability beside it; the probabilities sum to 1. A hop is chosen before the soil shows, so the
    /// mixture of the processes is the process of this mixture: the landings of each part weigh in with
    /// its probability times its discount.
    #[must_use]
    pub fn mixture(parts: &[(f64, Self)], discount: f64) -> Self {
        // The common factor γ is left out. Where no part ever lands, plain shares are the weights.
        let then = |soil: &Self| 1.0 - soil.wait + soil.wait * discount;
        let lands = parts.iter().any(|(share, soil)| share * then(soil) > 0.0);
        let weight = |share: f64, soil: &Self| if lands { share * then(soil) } else { share };
        let weights: f64 = parts.iter().map(|(share, soil)| weight(*share, soil)).sum();
        let landing = |of: fn(&Self) -> f64| {
            parts.iter().map(|(share, soil)| weight(*share, soil) * of(soil)).sum::<f64>() / weights
        };
        Self {
            intended: landing(|soil| soil.intended),
            stuck: landing(|soil| soil.stuck),
            sideways: landing(|soil| soil.sideways),
            wait: parts.iter().map(|(share, soil)| share * soil.wait).sum::<f64>().min(1.0),
        }
    }

    /// The soil with its slips adjusted so that its landings sum to 1 to the last bits; [`Self::check`] allows 1e-6.
    pub(crate) fn normalised(self) -> Self {
        let Self { intended, stuck, sideways, .. } = self;
        if (intended + stuck + 2.0 * sideways - 1.0).abs() <= 2.0 * f64::EPSILON {
            return self;
        }
        Self { sideways: (0.5 * (1.0 - intended - stuck)).max(0.0), ..self }
    }

    pub(crate) fn check(&self, soil: usize) -> Result<(), Error> {
        let Self { intended, stuck, sideways, wait } = *self;
        let in_range = [intended, stuck, sideways, wait].iter().all(|share| (0.0..=1.0).contains(share));
        let sum = intended + stuck + 2.0 * sideways;
        if in_range && (sum - 1.0).abs() <= 1e-6 {
            Ok(())
        } else {
            Err(Error::Scatter { soil, intended, stuck, sideways, wait })
        }
    }
}
