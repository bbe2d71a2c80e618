//! A campaign as text: the grid and how often each cell is flown.

use std::path::Path;

use contract::{Name, Profile, Weights};
use scenario::{BUILT_IN, Overrides, PayoffWeights, Scenario};
use serde::{Deserialize, Serialize};

use crate::{CampaignError, Cell, Plan};

/// Most trials of one campaign.
pub const TRIALS_MAX: u64 = 1_000_000_000;

/// Most cells of the grid.
pub const CELLS_MAX: usize = 4096;

/// Most cells of ground over all worlds of the grid, which are held while it is flown: 40 bytes each.
pub const GROUND_CELLS_MAX: usize = 1 << 26;

/// A grid: every scenario × profile × planner × weighting is a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Campaign {
    /// Its name, up to 31 printable characters without spaces.
    pub name: String,
    /// Seed that every trial's seed derives from.
    pub seed: u64,
    /// Trials of each cell.
    pub repetitions: u64,
    /// Built-in scenarios, or files relative to the campaign's.
    pub scenarios: Vec<String>,
    /// Readings of the model.
    #[serde(default = "paper")]
    pub profiles: Vec<Profile>,
    /// Algorithms.
    pub planners: Vec<String>,
    /// Weightings instead of the scenario's; the scenario's own if there are none.
    #[serde(default)]
    pub weights: Vec<Weighting>,
}

/// Weights of one column of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weighting {
    /// w1, of safety S.
    pub safety: f64,
    /// w2, of information I.
    pub information: f64,
    /// w3, of the distance penalty D; the scenario's by default.
    pub distance: Option<f64>,
}

impl Campaign {
    /// Reads a campaign from TOML; `origin` is what errors call it.
    ///
    /// # Errors
    /// If the text is no campaign, or a field is out of its range.
    pub fn parse(text: &str, origin: &str) -> Result<Self, CampaignError> {
        let campaign: Self = toml::from_str(text).map_err(|error| CampaignError::Toml {
            origin: origin.into(),
            message: scenario::text::toml_error(&error),
        })?;
        campaign.check()?;
        Ok(campaign)
    }

    /// Lays the grid out: scenarios outermost, then profiles, planners, and weightings. Scenario files
    /// are looked for from `folder`; `version` is that of the program that will fly.
    ///
    /// # Errors
    /// If a scenario cannot be flown.
    pub fn plan(&self, folder: &Path, version: &str) -> Result<Plan, CampaignError> {
        let (mut cells, mut ground) = (Vec::new(), 0_usize);
        for selector in &self.scenarios {
            let failed =
                |source| CampaignError::Scenario { selector: selector.clone(), source: Box::new(source) };
            let scenario = if BUILT_IN.iter().any(|(name, _)| name == selector) {
                scenario::load(selector)
            } else {
                scenario::load(&folder.join(selector).to_string_lossy())
            }
            .map_err(failed)?;
            // Whatever profile and weights, it is the same ground.
            let worlds = self.profiles.len() * self.planners.len() * self.weights.len().max(1);
            ground += worlds.saturating_mul(scenario.clone().resolve().map_err(failed)?.terrain.cells.len());
            if ground > GROUND_CELLS_MAX {
                return Err(CampaignError::Value {
                    field: "scenarios",
                    need: format!("at most {GROUND_CELLS_MAX} cells of ground in all worlds of the grid"),
                    got: format!("{ground} with {selector}; fly it as several campaigns"),
                });
            }
            for profile in &self.profiles {
                let overrides = Overrides { profile: Some(*profile), ..Overrides::default() };
                let scenario = scenario.clone().with(&overrides);
                for planner in &self.planners {
                    for weights in self.weightings(&scenario) {
                        let mut scenario = scenario.clone();
                        scenario.brief.weights = weights;
                        let world = scenario.resolve().map_err(failed)?;
                        let PayoffWeights { safety, information, distance } = weights;
                        let weights = Weights { safety, information, distance };
                        cells.push(Cell::new(cells.len() as u64, selector, planner, weights, &world));
                    }
                }
            }
        }
        Ok(Plan::new(self, version, cells))
    }

    fn weightings(&self, scenario: &Scenario) -> Vec<PayoffWeights> {
        let own = scenario.brief.weights;
        if self.weights.is_empty() {
            return vec![own];
        }
        let weights = self.weights.iter().map(|&Weighting { safety, information, distance }| PayoffWeights {
            safety,
            information,
            distance: distance.unwrap_or(own.distance),
        });
        weights.collect()
    }

    fn check(&self) -> Result<(), CampaignError> {
        let refuse =
            |field, need: &str, got: String| Err(CampaignError::Value { field, need: need.into(), got });
        if self.name.parse::<Name>().is_err() || self.name.contains(['/', '\\']) {
            return refuse(
                "name",
                "1 to 31 printable characters without spaces or slashes",
                format!("{:?}", self.name),
            );
        }
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
        let cells =
            [self.scenarios.len(), self.profiles.len(), self.planners.len(), self.weights.len().max(1)];
        let cells = cells.into_iter().try_fold(1, |cells: usize, n| cells.checked_mul(n));
        let Some(cells) = cells.filter(|cells| *cells <= CELLS_MAX) else {
            let need = format!("at most {CELLS_MAX} cells: scenarios x profiles x planners x weights");
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
        let trials = self.repetitions.checked_mul(cells as u64);
        match trials {
            Some(1..=TRIALS_MAX) => Ok(()),
            _ => refuse(
                "repetitions",
                &format!("at least 1, and at most {TRIALS_MAX} trials in all"),
                format!("{} a cell", self.repetitions),
            ),
        }
    }
}

fn first_twice<T: PartialEq>(list: &[T]) -> Option<&T> {
    list.iter().enumerate().find(|(i, item)| list[..*i].contains(item)).map(|(_, item)| item)
}

fn paper() -> Vec<Profile> {
    vec![Profile::Paper2023]
}
