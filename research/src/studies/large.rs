//! The case study of P21 on a stand-in for its map of Jezero: a trial is one truth of the map, in all arms.

use std::sync::LazyLock;

use ::campaign::{CampaignError, Study};
use node::Failure;
use p21::{Arm, Ending, LargeMap, Outcome, Samples, Setup, World, spread_shown};
use serde::{Deserialize, Serialize};

use super::Flown;
use super::team::{
    Planner, STAGES_MAX, all_arms, check_clearance, check_ending, check_probability, check_stages, clearance,
    headings_of_endings, is_0, probability,
};

/// Metres of flight at which the spread shown is read.
pub const AT_M: [f64; 16] = [
    0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0, 140.0, 160.0, 180.0, 200.0, 220.0, 240.0, 260.0, 280.0, 300.0,
];

/// Arms with a helicopter.
pub const HELICOPTERS: [Arm; 3] = [Arm::ScoutRoute, Arm::InformationTheoretic, Arm::ScoutValue];

/// Settings: the map, how often the helicopter flies, who drives.
#[derive(clap::Args, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Large {
    /// Seed of the map.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub map: u64,
    /// Probability that the short way is good.
    #[arg(long, default_value_t = 0.8, value_name = "P", value_parser = probability)]
    pub good: f64,
    /// Flights at most, each before a drive of a Sol; the last drive is as long as it takes.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=STAGES_MAX as i64))]
    pub stages: u32,
    /// Planner of the safe rover in all arms.
    #[arg(long, default_value_t, value_name = "PLANNER")]
    pub rover: Planner,
    /// Probability that the helicopter reads a cell's speed right; the others are equally likely [default: 1].
    #[arg(long, value_name = "P", value_parser = probability)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<f64>,
    /// How far `ett_exact` keeps from forbidden cells where it can, metres.
    #[arg(long = "clearance", default_value_t = 0.0, value_name = "M", value_parser = clearance)]
    #[serde(skip_serializing_if = "is_0")]
    pub clearance_m: f64,
}

impl Default for Large {
    fn default() -> Self {
        Self { map: 1, good: 0.8, stages: 1, rover: Planner::default(), accuracy: None, clearance_m: 0.0 }
    }
}

/// How the mission of each arm ended, and what the helicopters showed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// In the order of the arms.
    pub arms: [Ending; Arm::ALL.len()],
    /// Sum of the standard deviations of all cells seen, in m/Sol, by helicopter after each of [`AT_M`].
    pub shown: [[f64; AT_M.len()]; HELICOPTERS.len()],
}

impl Large {
    /// Every arm on a truth of the map, with routes and flights.
    pub fn outcomes(self, world: &World, seed: u64) -> [Outcome; Arm::ALL.len()] {
        let setup = Setup {
            stages: self.stages,
            clearance_m: self.clearance_m,
            ..Setup::new(self.rover.into(), Samples::LARGE)
        };
        all_arms(world, setup, self.accuracy, seed)
    }
}

impl Study for Large {
    const NAME: &'static str = "p21-large";
    const WORLDS_MIN: u64 = 2;
    type Outcome = Truth;

    fn headings() -> Vec<String> {
        let shown = |arm: &Arm| AT_M.map(|at_m| format!("{}_shown_m_per_sol_after_{at_m}_m", arm.key()));
        headings_of_endings().into_iter().chain(HELICOPTERS.iter().flat_map(shown)).collect()
    }

    fn cases() -> &'static [String] {
        static CASES: LazyLock<[String; 1]> = LazyLock::new(|| ["truth of the large map".into()]);
        &*CASES
    }

    fn check_settings(&self) -> Result<(), CampaignError> {
        check_probability("good", self.good)?;
        self.accuracy.map_or(Ok(()), |accuracy| check_probability("accuracy", accuracy))?;
        check_clearance(self.clearance_m)?;
        check_stages(self.stages)
    }

    fn world_seed(campaign_seed: u64, repetition: u64) -> u64 {
        campaign_seed.wrapping_add(repetition)
    }

    fn check_outcome(_case: usize, outcome: &Truth) -> Result<(), String> {
        outcome.arms.iter().try_for_each(check_ending)?;
        match outcome.shown.iter().flatten().find(|sum| !(sum.is_finite() && **sum >= 0.0)) {
            Some(sum) => Err(format!("shown: need a sum of deviations, got {sum}")),
            None => Ok(()),
        }
    }
}

impl Flown for Large {
    type Ground = LargeMap;

    fn ground(&self) -> LargeMap {
        LargeMap::new(self.map, self.good)
    }

    fn fly(&self, ground: &LargeMap, _case: usize, seed: u64) -> Result<Truth, Failure> {
        let world = ground.world(seed);
        let outcomes = self.outcomes(&world, seed);
        let shown = HELICOPTERS.map(|arm| {
            let shown = spread_shown(&world.prior, &outcomes[arm as usize].flight, &AT_M);
            shown.try_into().expect("a sum for each of the metres")
        });
        Ok(Truth { arms: outcomes.each_ref().map(Ending::from), shown })
    }
}
