//! Section `[robot]`: how the hopper moves and what it sees.

use contract::GradientSource;
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ScenarioError;
use crate::bounds::in_range;
use crate::error::refuse;

/// The hopper; its defaults are those of Sakamoto & Kunii 2023.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Robot {
    /// Length of one hop on the flat, metres; a whole number of cells.
    pub hop_distance_m: f64,
    /// Launch angle above the horizontal, degrees.
    pub launch_angle_deg: f64,
    /// Surface gravity, m/s2.
    pub gravity_mps2: f64,
    /// Slope at which a hop no longer gets anywhere, degrees; steeper ground is impassable.
    pub slope_limit_deg: f64,
    /// Whether hoppers have the vertical hop at 80 degrees of Sakamoto & Kubota 2022 where a hop at the launch angle would collide; needs
    /// `truth.dynamics.model = "collision"`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub vertical: bool,
    /// Scatter of hops from hard ground.
    pub hard: Scatter,
    /// Scatter of hops from sand.
    #[serde(default = "Scatter::on_sand")]
    pub sand: Scatter,
    /// Range of the sensor, and what it measures.
    pub sensor: Sensor,
}

/// How hops scatter on the flat: intended + stuck + 2 sideways = 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Scatter {
    /// Probability of landing where intended.
    pub intended: f64,
    /// Probability of not leaving the cell, whatever the slope.
    pub stuck: f64,
    /// Probability of landing one hop to the left; the same to the right.
    pub sideways: f64,
    /// Flights of an intended hop: 1, or 2 half hops.
    pub flights: u32,
}

/// The sensor sees a disc of radius gain x (height + offset), clamped.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Sensor {
    /// Metres of radius per metre of height.
    pub gain: f64,
    /// Height above the datum that is added, metres.
    pub offset_m: f64,
    /// Smallest radius, metres; one hop by default, and no less.
    pub radius_min_m: Option<f64>,
    /// Largest radius, metres; the diagonal of the map by default.
    pub radius_max_m: Option<f64>,
    /// Where gradients come from: `measured` at each seen cell, or `seen_differences` of heights. By
    /// default measured in the profiles of papers and seen_differences in profile hopper.
    #[cfg_attr(test, schemars(with = "Option<String>", extend("enum" = ["measured", "seen_differences", null])))]
    pub gradient: Option<GradientSource>,
}

impl Default for Robot {
    fn default() -> Self {
        Self {
            hop_distance_m: 1.0,
            launch_angle_deg: 45.0,
            gravity_mps2: 3.72,
            slope_limit_deg: 30.0,
            vertical: false,
            hard: Scatter::default(),
            sand: Scatter::on_sand(),
            sensor: Sensor::default(),
        }
    }
}

impl Robot {
    /// Refuses angles and landings that cannot be, in the units of the scenario: the brief's are radians.
    pub(crate) fn check(&self) -> Result<(), ScenarioError> {
        check_launch_angle("robot.launch_angle_deg", self.launch_angle_deg)?;
        let limits_deg = 0.01_f64.to_degrees()..=1.57_f64.to_degrees();
        in_range("robot.slope_limit_deg", self.slope_limit_deg, limits_deg, "0.573 to 89.954 degrees")?;
        self.hard.check("robot.hard")?;
        self.sand.check("robot.sand")
    }
}

/// Refuses a launch angle that no brief can hold.
pub(crate) fn check_launch_angle(field: &'static str, launch_angle_deg: f64) -> Result<(), ScenarioError> {
    let angles_deg = 0.01_f64.to_degrees()..=1.56_f64.to_degrees();
    in_range(field, launch_angle_deg, angles_deg, "0.573 to 89.381 degrees")
}

/// Refuses a smallest radius of a sensor below `hop_m`, the length of a hop.
pub(crate) fn check_radius_min(
    field: &'static str,
    radius_min_m: f64,
    hop_m: f64,
) -> Result<(), ScenarioError> {
    if radius_min_m.is_nan() || radius_min_m < hop_m * (1.0 - 1e-9) {
        let got = format!("{radius_min_m} m with hops of {hop_m} m");
        return refuse(field, "at least one hop, so that the hopper sees where it may land", got);
    }
    Ok(())
}

impl Default for Scatter {
    /// The scatter of P23 on hard ground.
    fn default() -> Self {
        Self { intended: 0.9, stuck: 0.0, sideways: 0.05, flights: 1 }
    }
}

impl Scatter {
    /// Checks that the four landings have probability 1 together; `field` is the section's name.
    pub(crate) fn check(&self, field: &'static str) -> Result<(), ScenarioError> {
        let sum = self.intended + self.stuck + 2.0 * self.sideways;
        if (sum - 1.0).abs() <= 1e-9 {
            return Ok(());
        }
        let Self { intended, stuck, sideways, .. } = self;
        Err(ScenarioError::Value {
            field,
            need: "intended + stuck + 2 x sideways = 1",
            got: format!("{intended} + {stuck} + 2 x {sideways} = {}", (1e9 * sum).round() / 1e9),
        })
    }

    /// The scatter of P23 on sand: two half hops.
    #[must_use]
    pub fn on_sand() -> Self {
        Self { intended: 0.7, stuck: 0.1, sideways: 0.1, flights: 2 }
    }
}

impl Default for Sensor {
    fn default() -> Self {
        Self { gain: 2.0, offset_m: 1.0, radius_min_m: None, radius_max_m: None, gradient: None }
    }
}
