//! The Monte Carlo simulation of P21: a trial is one random world, in all arms.

use std::sync::LazyLock;

use ::campaign::{CampaignError, Study};
use node::Failure;
use p21::{Arm, Ending, Outcome, Samples, Setup, monte_carlo};
use serde::{Deserialize, Serialize};

use super::Flown;
use super::team::{
    Planner, STAGES_MAX, all_arms, check_clearance, check_ending, check_probability, check_stages, clearance,
    headings_of_endings, is_0, probability,
};

/// Settings: who drives, what the helicopter sees with and how often it flies, in all arms.
#[derive(clap::Args, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MonteCarlo {
    /// Planner of the safe rover in all arms.
    #[arg(long, default_value_t, value_name = "PLANNER")]
    pub rover: Planner,
    /// Probability that the helicopter reads a cell's speed right; the others are equally likely [default: 1].
    #[arg(long, value_name = "P", value_parser = probability)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<f64>,
    /// Flights at most, each before a drive of a Sol; the last drive is as long as it takes.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=STAGES_MAX as i64))]
    pub stages: u32,
    /// How far `ett_exact` keeps from forbidden cells where it can, metres.
    #[arg(long = "clearance", default_value_t = 0.0, value_name = "M", value_parser = clearance)]
    #[serde(skip_serializing_if = "is_0")]
    pub clearance_m: f64,
}

impl Default for MonteCarlo {
    fn default() -> Self {
        Self { rover: Planner::default(), accuracy: None, stages: 1, clearance_m: 0.0 }
    }
}

/// How the mission of each arm ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Endings {
    /// In the order of the arms.
    pub arms: [Ending; Arm::ALL.len()],
}

impl MonteCarlo {
    /// Every arm on the world of `seed`, with routes and flights.
    pub fn outcomes(self, seed: u64) -> [Outcome; Arm::ALL.len()] {
        let setup = Setup {
            stages: self.stages,
            clearance_m: self.clearance_m,
            ..Setup::new(self.rover.into(), Samples::MONTE_CARLO)
        };
        all_arms(&monte_carlo(seed), setup, self.accuracy, seed)
    }
}

impl Study for MonteCarlo {
    const NAME: &'static str = "p21";
    const WORLDS_MIN: u64 = 2;
    type Outcome = Endings;

    fn headings() -> Vec<String> {
        headings_of_endings()
    }

    fn cases() -> &'static [String] {
        static CASES: LazyLock<[String; 1]> = LazyLock::new(|| ["Monte Carlo world".into()]);
        &*CASES
    }

    fn check_settings(&self) -> Result<(), CampaignError> {
        self.accuracy.map_or(Ok(()), |accuracy| check_probability("accuracy", accuracy))?;
        check_clearance(self.clearance_m)?;
        check_stages(self.stages)
    }

    fn world_seed(campaign_seed: u64, repetition: u64) -> u64 {
        campaign_seed.wrapping_add(repetition)
    }

    fn check_outcome(_case: usize, outcome: &Endings) -> Result<(), String> {
        outcome.arms.iter().try_for_each(check_ending)
    }
}

impl Flown for MonteCarlo {
    type Ground = ();

    fn ground(&self) {}

    fn fly(&self, (): &(), _case: usize, seed: u64) -> Result<Endings, Failure> {
        Ok(Endings { arms: self.outcomes(seed).each_ref().map(Ending::from) })
    }
}
