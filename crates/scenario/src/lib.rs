//! Missions as text: what is true, what is told, which robot, within which limits, under which guard.
//!
//! A [`Scenario`] is read from TOML; [`Scenario::resolve`] builds its terrain, fills in every default
//! and checks that a mission can be flown on it. The result is a [`World`]: the truth for hopper-sim,
//! the [`contract::Brief`] for everyone, and a canonical text that resolves to the very same world.

mod built_in;
mod check;
mod error;
mod finding;
mod guard;
mod mission;
mod overrides;
mod patrol;
mod resolve;
mod robot;
pub mod text;
mod truth;
mod world;

pub use built_in::{BUILT_IN, load};
pub use check::Check;
pub use error::ScenarioError;
pub use finding::Finding;
pub use guard::GuardRules;
pub use mission::{MissionBrief, MissionLimits, PayoffConstants, PayoffWeights, Ranges, Surveyed};
pub use overrides::Overrides;
pub use patrol::{MissionKind, MissionRules};
pub use robot::{Robot, Scatter, Sensor};
pub use truth::{
    CropCells, CropMetres, ElevationFile, Gaussians, RandomHills, SandRectangle, SandRules, TerrainSource,
    Truth,
};
pub use world::World;

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A mission of Hopper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// What is true, and known to the simulator only.
    pub truth: Truth,
    /// What everyone is told.
    pub brief: MissionBrief,
    /// Whether it goes to a goal or patrols.
    #[serde(default, skip_serializing_if = "MissionRules::is_empty")]
    pub mission: MissionRules,
    /// The hopper. Everything has a default: the hopper of Sakamoto & Kunii 2023.
    #[serde(default)]
    pub robot: Robot,
    /// When the mission is over.
    #[serde(default)]
    pub limits: MissionLimits,
    /// What hopper-sim refuses to execute, and when it acts by itself.
    #[serde(default, skip_serializing_if = "GuardRules::is_empty")]
    pub guard: GuardRules,
    /// Folder that relative paths start from: that of the scenario's file.
    #[serde(skip)]
    pub folder: PathBuf,
    /// Elevation file to take instead of the scenario's.
    #[serde(skip)]
    pub dem: Option<PathBuf>,
}

impl Scenario {
    /// Reads a scenario from TOML; `origin` is what errors call it.
    ///
    /// # Errors
    /// [`ScenarioError::Toml`] with line and column.
    pub fn parse(toml: &str, origin: &str) -> Result<Self, ScenarioError> {
        toml::from_str(toml)
            .map_err(|error| ScenarioError::Toml { origin: origin.into(), message: text::fault(&error) })
    }

    /// The scenario as the command line changes it. A default that follows from what is changed
    /// follows along: the gradient source from the profile.
    #[must_use]
    pub fn with(mut self, overrides: &Overrides) -> Self {
        if let Some(profile) = overrides.profile {
            self.brief.profile = profile;
        }
        if let Some(budget_ns) = overrides.decision_budget_ns {
            self.limits.decision_budget_ms = budget_ns as f64 / 1e6;
        }
        if let Some(dem) = &overrides.dem {
            self.dem = Some(dem.clone());
        }
        self
    }

    /// JSON Schema of scenarios, generated from these types.
    #[must_use]
    pub fn schema() -> serde_json::Value {
        schemars::schema_for!(Scenario).to_value()
    }
}
