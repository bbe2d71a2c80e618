//! Reads missions from TOML text.
//!
//! A [`Scenario`] says what the true ground is, what the brief says of it, which robots there are, within which
//! limits and under which guard. [`Scenario::resolve`] builds its terrain, fills in what depends on it and checks
//! that a mission can be flown on it. The result is a [`ResolvedScenario`]: the true terrain for hopper-sim, the
//! [`contract::Brief`] for every process, and a canonical text that resolves to the same value.
//!
//! ```
//! let world = scenario::load("hard")?.resolve()?;
//! assert_eq!((world.brief.grid.width, world.brief.grid.height), (20, 20));
//! let leg = world.brief.leg(0);
//! assert!(world.terrain.hops_between(leg.start, leg.goal).is_some());
//! # Ok::<(), scenario::ScenarioError>(())
//! ```

#![warn(clippy::disallowed_methods)]

mod body;
mod bounds;
mod built_in;
mod check;
mod difference;
mod dynamics;
mod error;
mod exact;
mod fitted;
mod former;
mod guard;
mod mission;
mod mobility;
mod motion_table;
mod overrides;
mod resolve;
mod resolved;
mod robot;
mod robots;
mod sampling;
mod shape;
pub mod text;
mod truth;
mod warning;

pub use built_in::{BUILT_IN, description, load};
pub use check::ScenarioCheck;
pub use difference::{Difference, difference, hashed_difference};
pub use dynamics::*;
pub use error::ScenarioError;
pub use fitted::{Fitted, fitted, fitted_to, fitted_with};
pub use guard::GuardRules;
pub use mission::{
    DEFAULT_PROFILE, MapBefore, MissionBrief, MissionLimits, OpenPoints, PayoffConstants, PayoffWeights,
    Ranges, Surveyed,
};
pub use motion_table::BelievedMotion;
pub use overrides::Overrides;
pub use resolved::ResolvedScenario;
pub use robot::{Robot, Scatter, Sensor};
pub use robots::*;
pub use sampling::SamplingRules;
pub use truth::{
    CellPoint, CropCells, CropMetres, ElevationFile, Gaussians, Obstacles, Passages, RandomHills, Rock,
    Rocks, SandRectangle, SandRules, TerrainSource, Truth,
};
pub use warning::Warning;

use std::path::PathBuf;
use std::sync::Arc;

#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::de::{DeTable, Deserializer};

/// See [`Scenario::schema`].
const SCHEMA: &str = include_str!("../schema.json");

/// A mission as written in a scenario file, one field a section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// The true ground, known to the simulator only.
    pub truth: Truth,
    /// What every process receives about the mission.
    pub brief: MissionBrief,
    /// The hopper, or what hoppers of `[[robots]]` have in common. Everything has a default: the hopper of Sakamoto & Kunii 2023.
    #[serde(default)]
    pub robot: Robot,
    /// When the mission ends, and how long a decision may take.
    #[serde(default)]
    pub limits: MissionLimits,
    /// What hopper-sim refuses to execute, and when it acts on its own.
    #[serde(default, skip_serializing_if = "GuardRules::is_empty")]
    pub guard: GuardRules,
    /// What planners of routes over uncertain ground are given; only with a driver.
    #[serde(default, skip_serializing_if = "SamplingRules::is_default")]
    pub sampling: SamplingRules,
    /// The robots, 1 to 16; without them the mission is one hopper, that of `[robot]` and `[brief]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub robots: Vec<RobotRules>,
    /// Robots that fail, and when.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<Fault>,
    /// Folder that relative paths start from: that of the scenario's file.
    #[serde(skip)]
    pub folder: PathBuf,
    /// File that the scenario was read from, which errors of resolving it name.
    #[serde(skip)]
    pub file: Option<PathBuf>,
    /// Elevation file to take instead of the scenario's.
    #[serde(skip)]
    pub dem: Option<PathBuf>,
    /// Values of the elevation file that are nodata, instead of those of the scenario.
    #[serde(skip)]
    pub nodata: Option<Vec<f64>>,
    /// Contents of the elevation file, for hosts without files.
    #[serde(skip)]
    pub elevation: Option<Arc<[u8]>>,
}

impl Scenario {
    /// Reads a scenario from TOML; `origin` is what errors call it.
    ///
    /// # Errors
    /// [`ScenarioError::Toml`] with line and column, and [`ScenarioError::Former`] with what to write instead.
    pub fn parse(toml: &str, origin: &str) -> Result<Self, ScenarioError> {
        let refuse = |(mut error, of): (toml::de::Error, Option<String>)| {
            error.set_input(Some(toml));
            let message = text::toml_error(&error);
            let message = of.into_iter().fold(message, |message, of| format!("{message}, {of}"));
            ScenarioError::Toml { origin: origin.into(), message }
        };
        let mut table = DeTable::parse(toml).map_err(|error| refuse((error, None)))?;
        former::check(table.get_ref(), toml, origin)?;
        let robots = table.get_mut().remove("robots");
        let rest = Self::deserialize(Deserializer::from(table)).map_err(|error| refuse((error, None)))?;
        let robots = robots.map(robots::read).transpose().map_err(refuse)?;
        Ok(Self { robots: robots.unwrap_or_default(), ..rest })
    }

    /// The scenario with the command line's overrides. Defaults that depend on an overridden value follow it:
    /// the gradient source follows the profile.
    #[must_use]
    pub fn with(mut self, overrides: &Overrides) -> Self {
        if let Some(profile) = overrides.profile {
            self.brief.profile = profile;
        }
        if let Some(model) = overrides.dynamics
            && self.truth.dynamics.model() != model
        {
            self.truth.dynamics = Dynamics::of(model);
        }
        if let Some(preset) = overrides.preset {
            self.robot.gravity_mps2 = preset.gravity_mps2();
            if overrides.dynamics != Some(contract::MotionModel::Law) {
                self.truth.dynamics = Dynamics::Contact(ContactRules { preset, ..ContactRules::default() });
            }
        }
        if let Some(table) = &overrides.table {
            self.brief.motion.table = Some(motion_table::from_here(table));
        }
        if let Some(budget_ns) = overrides.decision_budget_ns {
            self.limits.decision_budget_ms = budget_ns as f64 / 1e6;
        }
        if let Some(dem) = &overrides.dem {
            self.dem = Some(dem.clone());
        }
        if let Some(nodata) = &overrides.nodata {
            self.nodata = Some(nodata.clone());
        }
        self
    }

    /// Whether its ground or what planners believe of hops comes from files, which may be elsewhere or have other contents another time.
    #[must_use]
    pub fn names_files(&self) -> bool {
        let Truth { terrain, sand, mobility, .. } = &self.truth;
        matches!(terrain, TerrainSource::ElevationFile(_))
            || sand.mask_file.is_some()
            || self.brief.motion.table.is_some()
            || mobility.clone().is_some_and(|mut mobility| mobility.files().next().is_some())
    }

    /// The scenario over an elevation model that is at hand: `contents` of a file of this `name`, which is not looked for.
    #[must_use]
    pub fn on_elevation(self, name: &str, contents: Arc<[u8]>) -> Self {
        Self { dem: Some(name.into()), elevation: Some(contents), ..self }
    }

    /// JSON Schema of scenarios.
    ///
    /// It is derived from these types by a test, which keeps the committed `schema.json` equal to it: a schema that was
    /// derived in every build would make each of them longer.
    ///
    /// # Panics
    /// Never: that `schema.json` is JSON is tested.
    #[must_use]
    pub fn schema() -> serde_json::Value {
        serde_json::from_str(SCHEMA).expect("schema.json is JSON")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Run with `HOPPER_BLESS=1` to write it anew.
    #[test]
    fn the_committed_schema_is_that_of_the_types() {
        let derived =
            serde_json::to_string_pretty(&schemars::schema_for!(Scenario).to_value()).unwrap() + "\n";
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/schema.json");
        if std::env::var_os("HOPPER_BLESS").is_some() {
            std::fs::write(path, &derived).unwrap();
        }
        assert!(
            std::fs::read_to_string(path).unwrap() == derived,
            "{path} is out of date: HOPPER_BLESS=1 writes it"
        );
        assert_eq!(Scenario::schema(), schemars::schema_for!(Scenario).to_value());
    }
}
