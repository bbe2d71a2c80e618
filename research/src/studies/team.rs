//! What the studies share that fly every arm of rover and helicopter on the same worlds.

use ::campaign::CampaignError;
use p21::{Arm, Ending, Outcome, RoverPlanner, Sensor, Setup, World, announce, fly};
use serde::{Deserialize, Serialize};

/// Planners of the safe rover, by their names.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum Planner {
    /// That of the paper.
    #[default]
    RrtStarEtt,
    /// Ours.
    EttExact,
}

impl std::fmt::Display for Planner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Planner::RrtStarEtt => "rrt_star_ett",
            Planner::EttExact => "ett_exact",
        })
    }
}

impl From<Planner> for RoverPlanner {
    fn from(planner: Planner) -> Self {
        match planner {
            Planner::RrtStarEtt => RoverPlanner::RrtStarEtt,
            Planner::EttExact => RoverPlanner::EttExact,
        }
    }
}

/// A number from 0 to 1.
pub fn probability(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if (0.0..=1.0).contains(&number) { Ok(number) } else { Err("a probability needs 0 to 1".into()) }
}

/// Refuses a setting that is no probability.
pub fn check_probability(field: &'static str, value: f64) -> Result<(), CampaignError> {
    if (0.0..=1.0).contains(&value) {
        return Ok(());
    }
    let need = "a probability, 0 to 1".into();
    Err(CampaignError::Value { field, need, got: value.to_string() })
}

/// Most metres that routes keep from forbidden cells.
const CLEARANCE_MAX_M: f64 = 10.0;

/// A distance that routes may keep from forbidden cells.
pub fn clearance(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|error| format!("{error}"))?;
    let refused = |_| format!("a clearance needs 0 to {CLEARANCE_MAX_M} m");
    check_clearance(number).map_err(refused).map(|()| number)
}

/// Refuses a clearance out of its range.
pub fn check_clearance(value: f64) -> Result<(), CampaignError> {
    if (0.0..=CLEARANCE_MAX_M).contains(&value) {
        return Ok(());
    }
    let need = format!("0 to {CLEARANCE_MAX_M} metres");
    Err(CampaignError::Value { field: "clearance_m", need, got: value.to_string() })
}

/// Whether a setting is at its default of 0, so that what is written down is what it was before there was one.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
pub fn is_0(value: &f64) -> bool {
    *value == 0.0
}

/// Most flights of a mission.
pub const STAGES_MAX: u32 = 20;

/// Refuses a number of flights out of its range.
pub fn check_stages(stages: u32) -> Result<(), CampaignError> {
    if (1..=STAGES_MAX).contains(&stages) {
        return Ok(());
    }
    let (need, got) = (format!("1 to {STAGES_MAX}"), stages.to_string());
    Err(CampaignError::Value { field: "stages", need, got })
}

/// Plans and flies every arm on one world.
pub fn all_arms(world: &World, setup: Setup, accuracy: Option<f64>, seed: u64) -> [Outcome; Arm::ALL.len()] {
    let sensor = accuracy.map(|p| Sensor::with_accuracy(p).expect("a probability"));
    let setup = Setup { sensor: sensor.map(|sensor| (sensor, seed)), ..setup };
    let announced = announce(world, &setup, seed);
    Arm::ALL.map(|arm| fly(world, arm, &setup, seed, announced.as_ref()))
}

/// Headings of the columns of the endings of all arms.
pub fn headings_of_endings() -> Vec<String> {
    let of = |arm: &Arm| {
        let arm = arm.key();
        [format!("{arm}_travel_sol"), format!("{arm}_stuck"), format!("{arm}_has_route")]
    };
    Arm::ALL.iter().flat_map(of).collect()
}

/// Refuses an ending that no mission has.
pub fn check_ending(ending: &Ending) -> Result<(), String> {
    let Ending { travel_sol, stuck, has_route } = *ending;
    match travel_sol {
        Some(travel_sol) if !(travel_sol.is_finite() && travel_sol >= 0.0) => {
            Err(format!("travel_sol: need a time, got {travel_sol}"))
        }
        Some(_) if stuck || !has_route => {
            Err("travel_sol: need none without a way to the goal, got one".into())
        }
        _ => Ok(()),
    }
}
