//! P19's coverage of unknown ground: a trial is one case (ground, planner, mode, number of rovers) on one random world.

use std::sync::LazyLock;

use ::campaign::{CampaignError, Study};
use node::Failure;
use p19::{CASES, P19Error, PERCENTS, Steps};
use serde::{Deserialize, Serialize};

use super::Flown;

/// It has no settings.
#[derive(clap::Args, Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Coverage {}

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

impl Flown for Coverage {
    type Ground = ();

    fn ground(&self) {}

    fn fly(&self, (): &(), case: usize, seed: u64) -> Result<Steps, Failure> {
        p19::fly(case, seed).map_err(failure)
    }
}

/// The failure of a case: exit code 1 if its mission does not end, 2 if it cannot begin.
pub fn failure(error: P19Error) -> Failure {
    match error {
        P19Error::NotCovered { .. } => Failure::run(error),
        P19Error::Grid(_) | P19Error::World(_) | P19Error::Setup(_) => Failure::usage(error),
    }
}
