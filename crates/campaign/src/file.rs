//! Reads campaign files: the grid, and how often each cell is flown.

use std::path::PathBuf;

use contract::{DistanceNorm, MotionModel, Name, Profile, UnseenGround};
use scenario::{CellPoint, OpenPoints, Scenario, TerrainSource};
use serde::{Deserialize, Serialize};

use crate::CampaignError;

/// Most trials of one campaign.
pub const TRIALS_MAX: u64 = 1_000_000_000;

/// Most cells of the grid.
pub const CELLS_MAX: usize = 4096;

/// Most terrain cells over all cells of the grid. They are held in memory while the campaign is flown: 40 bytes
/// each.
pub const GROUND_CELLS_MAX: usize = 1 << 26;

/// A campaign file: every combination of scenario, profile, planner and weighting is a cell of the grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Campaign {
    /// Name, up to 31 printable characters without spaces or slashes.
    pub name: String,
    /// Seed that every trial's seed is derived from.
    pub seed: u64,
    /// Number of trials of each cell, at least 1.
    pub repetitions: u64,
    /// Names of built-in scenarios, or files relative to the folder of the campaign file.
    pub scenarios: Vec<String>,
    /// Profiles: readings of the model; by default only that of a scenario that names none.
    #[serde(default = "default_profiles")]
    pub profiles: Vec<Profile>,
    /// Names of algorithms.
    pub planners: Vec<String>,
    /// Weightings that replace the scenario's; if empty, the scenario's own is used.
    #[serde(default)]
    pub weights: Vec<Weighting>,
    /// Readings of the model's open points that replace the scenario's; if empty, the scenario's own is used.
    #[serde(default)]
    pub readings: Vec<NamedReading>,
    /// Where hops end in truth, in place of the scenarios' own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dynamics: Option<MotionModel>,
    /// Motion table that planners believe, a file relative to the folder of the campaign file, in place of what the scenarios say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<PathBuf>,
}

/// One weighting of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weighting {
    /// w1, of safety S.
    pub safety: f64,
    /// w2, of information I.
    pub information: f64,
    /// w3, of the distance penalty D; by default that of the scenario.
    pub distance: Option<f64>,
}

/// One reading of the grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NamedReading {
    /// Name in rows and reports, up to 31 printable characters.
    pub name: String,
    /// As `leaving` of `[brief.reading]` in a scenario.
    pub leaving: Option<f64>,
    /// As `distance` there.
    #[serde(default)]
    pub distance: DistanceNorm,
    /// As `distance_scale_cells` there.
    pub distance_scale_cells: Option<f64>,
    /// As `opening_steps` there.
    #[serde(default)]
    pub opening_steps: u64,
    /// As `unseen` there.
    #[serde(default)]
    pub unseen: UnseenGround,
    /// As `ground_at` of generated hills at given places; other ground has no such choice.
    #[serde(default)]
    pub ground_at: CellPoint,
}

impl NamedReading {
    /// The scenario under this reading.
    pub(crate) fn applied_to(&self, mut scenario: Scenario) -> Scenario {
        let Self { leaving, distance, distance_scale_cells, opening_steps, unseen, ground_at, .. } = *self;
        scenario.brief.reading =
            OpenPoints { leaving, distance, distance_scale_cells, opening_steps, unseen };
        if let TerrainSource::Gaussians(source) = &mut scenario.truth.terrain {
            source.ground_at = ground_at;
        }
        scenario
    }
}

impl Campaign {
    /// Reads a campaign from TOML; `origin` names the text in errors.
    ///
    /// # Errors
    /// If the text is not a campaign, or a field is out of its range.
    pub fn parse(text: &str, origin: &str) -> Result<Self, CampaignError> {
        let campaign: Self = toml::from_str(text).map_err(|error| CampaignError::Toml {
            origin: origin.into(),
            message: scenario::text::toml_error(&error),
        })?;
        campaign.check()?;
        Ok(campaign)
    }

    fn check(&self) -> Result<(), CampaignError> {
        let refuse =
            |field, need: &str, got: String| Err(CampaignError::Value { field, need: need.into(), got });
        check_name(&self.name)?;
        for (field, list) in [("scenarios", &self.scenarios), ("planners", &self.planners)] {
            if list.is_empty() {
                return refuse(field, "at least one", "none".into());
            }
            if let Some(odd) = list.iter().find(|text| text.is_empty() || text.chars().any(char::is_control))
            {
                return refuse(field, "printable names", format!("{odd:?}"));
            }
        }
        if self.profiles.is_empty() {
            return refuse("profiles", "at least one", "none".into());
        }
        let (weights, readings) = (self.weights.len().max(1), self.readings.len().max(1));
        let cells = [self.scenarios.len(), self.profiles.len(), self.planners.len(), weights, readings];
        let cells = cells.into_iter().try_fold(1, |cells: usize, n| cells.checked_mul(n));
        let Some(cells) = cells.filter(|cells| *cells <= CELLS_MAX) else {
            let need =
                format!("at most {CELLS_MAX} cells: scenarios x profiles x planners x weights x readings");
            let got = cells.map_or("more than can be counted".into(), |cells| cells.to_string());
            return refuse("scenarios", &need, format!("{got}; fly it as several campaigns"));
        };
        if let Some(twice) = first_twice(&self.scenarios) {
            return refuse("scenarios", "each once", format!("{twice:?} twice"));
        }
        if let Some(twice) = first_twice(&self.planners) {
            return refuse("planners", "each once", format!("{twice:?} twice"));
        }
        if let Some(twice) = first_twice(&self.profiles) {
            return refuse("profiles", "each once", format!("{twice} twice"));
        }
        if let Some(twice) = first_twice(&self.weights) {
            return refuse(
                "weights",
                "each once",
                format!("({}, {}) twice", twice.safety, twice.information),
            );
        }
        let names: Vec<&String> = self.readings.iter().map(|reading| &reading.name).collect();
        if let Some(odd) = names.iter().find(|name| name.parse::<Name>().is_err()) {
            return refuse(
                "readings",
                "names of 1 to 31 printable characters without spaces",
                format!("{odd:?}"),
            );
        }
        if let Some(twice) = first_twice(&names) {
            return refuse("readings", "each name once", format!("{twice:?} twice"));
        }
        check_repetitions(self.repetitions, cells as u64, 1)
    }
}

/// Refuses fewer repetitions than `least`, and more than there may be trials of `cells` cells.
pub(crate) fn check_repetitions(repetitions: u64, cells: u64, least: u64) -> Result<(), CampaignError> {
    let trials = repetitions.checked_mul(cells);
    if repetitions >= least && trials.is_some_and(|trials| trials <= TRIALS_MAX) {
        return Ok(());
    }
    Err(CampaignError::Value {
        field: "repetitions",
        need: format!("at least {least}, and at most {TRIALS_MAX} trials in all"),
        got: format!("{repetitions} a cell"),
    })
}

/// Refuses a name that cannot be that of a folder.
pub(crate) fn check_name(name: &str) -> Result<(), CampaignError> {
    if name.parse::<Name>().is_ok() && !name.contains(['/', '\\']) {
        return Ok(());
    }
    Err(CampaignError::Value {
        field: "name",
        need: "1 to 31 printable characters without spaces or slashes".into(),
        got: format!("{name:?}"),
    })
}

fn first_twice<T: PartialEq>(list: &[T]) -> Option<&T> {
    list.iter().enumerate().find(|(i, item)| list[..*i].contains(item)).map(|(_, item)| item)
}

fn default_profiles() -> Vec<Profile> {
    vec![scenario::DEFAULT_PROFILE]
}
