//! Sections `[brief]` and `[limits]` of a scenario.

use contract::{DistanceNorm, Profile, Reading, UnseenGround};
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{BelievedMotion, ScenarioError, Visits, exact};

/// Section `[brief]`: what every process receives about the mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MissionBrief {
    /// Name of the scenario, up to 31 printable characters; that of the file by default.
    pub name: Option<String>,
    /// Reading of the model: `paper-2023` reproduces Sakamoto & Kunii 2023, `hopper` does better, `paper-2022` has the payoff of
    /// Sakamoto & Kubota 2022.
    #[serde(default = "default_profile")]
    #[cfg_attr(test, schemars(with = "String", extend("enum" = ["paper-2023", "hopper", "paper-2022"])))]
    pub profile: Profile,
    /// Cell (x, y) to start from, counted from the south-western corner: that of the hopper, or of robots of `[[robots]]` that may
    /// take it and have none of their own.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::optional")]
    pub start: Option<[i32; 2]>,
    /// Cell (x, y) to reach: that of the hopper, or of robots of `[[robots]]` that may take it and have none of their own.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::optional")]
    pub goal: Option<[i32; 2]>,
    /// Goals of a patrol in place of `goal`, 2 to 16 cells (x, y): visited in turn, from the last to the first again. Each is
    /// different from the one before it, and the first from the last. `limits.steps_max` does not apply.
    #[serde(default, skip_serializing_if = "Vec::is_empty", deserialize_with = "exact::list")]
    pub goals: Vec<[i32; 2]>,
    /// Hops after which a patrol ends; by default as many as a mission can count.
    #[serde(default = "Visits::most_hops", skip_serializing_if = "Visits::is_most_hops")]
    pub hops_max: u64,
    /// What is known of the map beforehand: `unknown`, only what the sensor has seen, or `known`, all of it. With `known` every hopper
    /// sees the whole map from where it is, whatever the radii of its sensor.
    #[serde(default, skip_serializing_if = "is_default")]
    pub map: MapBefore,
    /// Elevation that heights are relative to, metres, or `survey`: the mean of the map.
    #[serde(default = "zero")]
    pub datum_m: Surveyed<f64>,
    /// Weights w1, w2, w3 of the payoff.
    #[serde(default)]
    pub weights: PayoffWeights,
    /// Payoffs of goal and treasures, discount, and sand term.
    #[serde(default)]
    pub payoff: PayoffConstants,
    /// Ranges for min-max normalisation, as an orbital survey would give them.
    #[serde(default)]
    pub priors: Ranges,
    /// How the paper's open points are read; profile `paper-2023` only.
    #[serde(default, skip_serializing_if = "OpenPoints::is_default")]
    pub reading: OpenPoints,
    /// What planners believe of where hops end; by default the scatter of `[robot]`.
    #[serde(default, skip_serializing_if = "BelievedMotion::is_law")]
    pub motion: BelievedMotion,
}

/// What is known of the map before the mission.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum MapBefore {
    /// Nothing: the map is what the sensor has seen.
    #[default]
    Unknown,
    /// The whole map.
    Known,
}

/// How open points of Sakamoto & Kunii 2023 are read, where not as by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct OpenPoints {
    /// What leaving the map is worth to the plan, below 0; by default leaving counts as staying.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub leaving: Option<f64>,
    /// Norm of the distance D: `euclidean` or `manhattan`.
    #[serde(skip_serializing_if = "is_default")]
    #[cfg_attr(test, schemars(with = "String", extend("enum" = ["euclidean", "manhattan"])))]
    pub distance: DistanceNorm,
    /// Distance at which D is -1, cells; by default that from start to goal in the same norm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_scale_cells: Option<f64>,
    /// Steps counted for the first observation, before any hop.
    #[serde(skip_serializing_if = "is_default")]
    pub opening_steps: u64,
    /// What landing on unseen ground is to planner `mdp`: as on `flat` hard ground, or `stays`, `leaves`, `ends` the plan.
    #[serde(skip_serializing_if = "is_default")]
    #[cfg_attr(test, schemars(with = "String", extend("enum" = ["flat", "stays", "leaves", "ends"])))]
    pub unseen: UnseenGround,
}

/// A value that is given, or found by surveying the whole map when the scenario is resolved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(untagged, expecting = "need \"survey\", a number, or [smallest, largest]")]
pub enum Surveyed<T> {
    /// The value itself.
    Given(T),
    /// To be measured over the whole true map.
    Survey(Survey),
}

/// The text `survey` in place of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Survey {
    /// Measure the value over the whole true map.
    Survey,
}

/// Weights of the payoff r = w1 S + w2 I + w3 D.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct PayoffWeights {
    /// w1, of safety S.
    pub safety: f64,
    /// w2, of information gain I.
    pub information: f64,
    /// w3, of the distance penalty D.
    pub distance: f64,
}

/// Constants of the payoff.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct PayoffConstants {
    /// Payoff of reaching the goal, an absorbing state.
    pub goal: f64,
    /// Payoff of collecting a treasure, on top of that of landing on its cell.
    pub treasure: f64,
    /// Discount of one period, 0.01 to 0.9999.
    pub discount: f64,
    /// Soil term T on sand in S = -|slope| - T; -5 taken literally from the paper makes sand attractive.
    pub sand_term: f64,
}

/// Ranges [smallest, largest] for min-max normalisation, or `survey`: over all ground a hopper can
/// land on, steeper ground and gaps left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Ranges {
    /// Of S = -|slope| - T.
    pub safety: Surveyed<[f64; 2]>,
    /// Of heights above the datum, metres.
    pub height_m: Surveyed<[f64; 2]>,
}

/// Section `[limits]`: when the mission is over, and how long a decision may take.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MissionLimits {
    /// Steps, in the paper's count of 2 or 3 a hop, after which a hopper's mission is a deadlock; in other missions, actions of each
    /// robot.
    pub steps_max: u64,
    /// Budget of one decision, landing to commit, milliseconds; used in reports only, it changes no decision.
    pub decision_budget_ms: f64,
}

impl MissionLimits {
    /// The budget in nanoseconds, as the brief has it.
    #[must_use]
    pub fn decision_budget_ns(&self) -> u64 {
        (self.decision_budget_ms * 1e6).round() as u64
    }
}

impl OpenPoints {
    pub(crate) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// The reading of a mission in `profile`.
    pub(crate) fn resolve(&self, profile: Profile) -> Result<Reading, ScenarioError> {
        let refuse = |field, need, got: f64| Err(ScenarioError::Value { field, need, got: got.to_string() });
        if profile != Profile::Paper2023 && !self.is_default() {
            let (field, need) = ("brief.reading", "profile = \"paper-2023\": it reads the paper");
            return Err(ScenarioError::Value { field, need, got: profile.to_string() });
        }
        if let Some(leaving) = self.leaving.filter(|leaving| leaving.is_nan() || *leaving >= 0.0) {
            return refuse("brief.reading.leaving", "a payoff below 0", leaving);
        }
        if let Some(scale) = self.distance_scale_cells.filter(|scale| scale.is_nan() || *scale < 1e-3) {
            return refuse("brief.reading.distance_scale_cells", "a distance of at least 0.001", scale);
        }
        let Self { leaving, distance, distance_scale_cells, opening_steps, unseen } = *self;
        Ok(Reading { leaving, distance, distance_scale_cells, opening_steps, unseen })
    }
}

impl<T> Surveyed<T> {
    /// The default of values that an orbital survey would give.
    pub const SURVEY: Self = Self::Survey(Survey::Survey);
}

impl Default for PayoffWeights {
    fn default() -> Self {
        Self { safety: 0.5, information: 0.5, distance: 10.0 }
    }
}

impl Default for PayoffConstants {
    fn default() -> Self {
        Self { goal: 100.0, treasure: 20.0, discount: 0.99, sand_term: -5.0 }
    }
}

impl Default for Ranges {
    fn default() -> Self {
        Self { safety: Surveyed::SURVEY, height_m: Surveyed::SURVEY }
    }
}

impl Default for MissionLimits {
    fn default() -> Self {
        Self { steps_max: 150, decision_budget_ms: 600.0 }
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// The profile of a mission that names none.
pub const DEFAULT_PROFILE: Profile = Profile::Paper2023;

fn default_profile() -> Profile {
    DEFAULT_PROFILE
}

fn zero() -> Surveyed<f64> {
    Surveyed::Given(0.0)
}
