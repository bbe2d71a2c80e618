//! The plan of a campaign: numbered cells and numbered trials.

use std::path::Path;

use contract::Weights;
use scenario::{BUILT_IN, Overrides, PayoffWeights, Scenario};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::cell::hexadecimal;
use crate::file::{GROUND_CELLS_MAX, NamedReading, Weighting};
use crate::{Campaign, CampaignError, Cell};

/// Everything that determines the rows of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Name of the campaign.
    pub name: String,
    /// Seed that every trial's seed is derived from.
    pub seed: u64,
    /// Number of trials of each cell.
    pub repetitions: u64,
    /// Version of the program that flies.
    pub version: String,
    /// SHA-256 over all other fields, hexadecimal.
    pub hash: String,
    /// The cells in the order of their numbers.
    pub cells: Vec<Cell>,
}

/// One mission of a campaign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial<'a> {
    /// Number in the whole campaign, from 0.
    pub number: u64,
    /// Repetition within its cell, from 0.
    pub repetition: u64,
    /// Seed of its random draws, as `hopper run --seed` takes it.
    pub seed: u64,
    /// The cell it belongs to.
    pub cell: &'a Cell,
}

impl Plan {
    pub(crate) fn new(campaign: &Campaign, version: &str, cells: Vec<Cell>) -> Self {
        let mut plan = Self {
            name: campaign.name.clone(),
            seed: campaign.seed,
            repetitions: campaign.repetitions,
            version: version.into(),
            hash: String::new(),
            cells,
        };
        plan.hash = plan.fingerprint();
        plan
    }

    /// The value that [`Plan::hash`] must have.
    pub(crate) fn fingerprint(&self) -> String {
        let mut hasher = Sha256::new();
        hasher.update(b"hopper campaign v2");
        let mut text = |text: &str| {
            hasher.update((text.len() as u64).to_le_bytes());
            hasher.update(text);
        };
        text(&self.name);
        text(&self.version);
        text(&format!("{} {}", self.seed, self.repetitions));
        for cell in &self.cells {
            // What decides where hops end is part of the world.
            let Cell {
                number,
                scenario,
                profile,
                planner,
                weights,
                reading,
                dynamics: _,
                steps_max,
                config,
                world,
            } = cell;
            let Weights { safety, information, distance } = weights;
            let weights = [safety, information, distance].map(|weight| format!("{:016x}", weight.to_bits()));
            text(&format!("{number} {profile} {} {steps_max}", weights.join(" ")));
            [scenario, planner, config, world].into_iter().chain(reading).for_each(|part| text(part));
        }
        hexadecimal(&hasher.finalize())
    }

    /// Trial `number`, counted cell by cell, repetition by repetition; `None` beyond the last.
    #[must_use]
    pub fn trial(&self, number: u64) -> Option<Trial<'_>> {
        let cell = self.cells.get(usize::try_from(number / self.repetitions).ok()?)?;
        let repetition = number % self.repetitions;
        Some(Trial { number, repetition, seed: cell.seed(self.seed, repetition), cell })
    }
}

impl Campaign {
    /// Plans the grid: scenarios outermost, then profiles, readings, planners, and weightings. Paths of scenario files
    /// start from `folder`; `version` is that of the program that will fly.
    ///
    /// # Errors
    /// If a scenario cannot be resolved, or all terrains together take too much memory.
    pub fn plan(&self, folder: &Path, version: &str) -> Result<Plan, CampaignError> {
        let (mut cells, mut ground) = (Vec::new(), 0_usize);
        for selector in &self.scenarios {
            let failed =
                |source| CampaignError::Scenario { selector: selector.clone(), source: Box::new(source) };
            let mut scenario = if BUILT_IN.iter().any(|(name, _)| name == selector) {
                scenario::load(selector)
            } else {
                scenario::load(folder.join(selector))
            }
            .map_err(failed)?;
            // Errors name it as the campaign does.
            scenario.file = None;
            // No terrain has more or fewer cells for its profile, weights or reading.
            let readings = self.readings.len().max(1);
            let worlds = self.profiles.len() * self.planners.len() * self.weights.len().max(1) * readings;
            ground += worlds.saturating_mul(scenario.clone().resolve().map_err(failed)?.terrain.cells.len());
            if ground > GROUND_CELLS_MAX {
                return Err(CampaignError::Value {
                    field: "scenarios",
                    need: format!("at most {GROUND_CELLS_MAX} cells of ground in all worlds of the grid"),
                    got: format!("{ground} with {selector}; fly it as several campaigns"),
                });
            }
            for profile in &self.profiles {
                let overrides = Overrides {
                    profile: Some(*profile),
                    dynamics: self.dynamics,
                    table: self.table.as_ref().map(|table| folder.join(table)),
                    ..Overrides::default()
                };
                let scenario = scenario.clone().with(&overrides);
                for (reading, scenario) in self.under_readings(scenario) {
                    for planner in &self.planners {
                        for weights in self.weightings(&scenario) {
                            let mut scenario = scenario.clone();
                            scenario.brief.weights = weights;
                            let world = scenario.resolve().map_err(failed)?;
                            let PayoffWeights { safety, information, distance } = weights;
                            let weights = Weights { safety, information, distance };
                            let number = cells.len() as u64;
                            cells.push(Cell::new(number, selector, planner, weights, reading, &world));
                        }
                    }
                }
            }
        }
        Ok(Plan::new(self, version, cells))
    }

    /// The scenario under each reading, or as it is.
    fn under_readings(&self, scenario: Scenario) -> Vec<(Option<&str>, Scenario)> {
        if self.readings.is_empty() {
            return vec![(None, scenario)];
        }
        let named = |reading: &NamedReading| reading.applied_to(scenario.clone());
        self.readings.iter().map(|reading| (Some(reading.name.as_str()), named(reading))).collect()
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
}
