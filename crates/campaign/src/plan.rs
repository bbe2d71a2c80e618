//! The campaign laid out: numbered cells, numbered trials.

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::cell::hexadecimal;
use crate::{Campaign, CampaignError, Cell, Row};

/// All that decides what the rows of a campaign will be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Name of the campaign.
    pub name: String,
    /// Seed that every trial's seed derives from.
    pub seed: u64,
    /// Trials of each cell.
    pub repetitions: u64,
    /// Version of the program that flies.
    pub version: String,
    /// SHA-256 over the above and the configurations of the cells, hexadecimal.
    pub hash: String,
    /// The cells in order.
    pub cells: Vec<Cell>,
}

/// One mission of a campaign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial<'a> {
    /// Number in the whole campaign, from 0.
    pub number: u64,
    /// Repetition within its cell, from 0.
    pub repetition: u64,
    /// Seed of its draws.
    pub seed: u64,
    /// Its cell.
    pub cell: &'a Cell,
}

impl Plan {
    pub(crate) fn new(campaign: &Campaign, version: &str, cells: Vec<Cell>) -> Self {
        let mut hasher = Sha256::new();
        hasher.update(b"hopper campaign v1");
        for text in [campaign.name.as_str(), version] {
            hasher.update((text.len() as u64).to_le_bytes());
            hasher.update(text);
        }
        hasher.update(campaign.seed.to_le_bytes());
        hasher.update(campaign.repetitions.to_le_bytes());
        for cell in &cells {
            hasher.update((cell.scenario.len() as u64).to_le_bytes());
            hasher.update(&cell.scenario);
            hasher.update(&cell.config);
        }
        Self {
            name: campaign.name.clone(),
            seed: campaign.seed,
            repetitions: campaign.repetitions,
            version: version.into(),
            hash: hexadecimal(&hasher.finalize()),
            cells,
        }
    }

    /// Trials in all.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.cells.len() as u64 * self.repetitions
    }

    /// Trial `number`, if the campaign has so many: cell by cell, repetition by repetition.
    #[must_use]
    pub fn trial(&self, number: u64) -> Option<Trial<'_>> {
        let cell = self.cells.get(usize::try_from(number / self.repetitions).ok()?)?;
        let repetition = number % self.repetitions;
        Some(Trial { number, repetition, seed: cell.seed(self.seed, repetition), cell })
    }

    /// Whether `row` is one of this plan's.
    ///
    /// # Errors
    /// If its configuration is another.
    pub fn check(&self, row: &Row) -> Result<(), CampaignError> {
        let need = self.trial(row.trial).map_or("none", |trial| trial.cell.config.as_str());
        if row.config == need {
            return Ok(());
        }
        Err(CampaignError::Foreign { trial: row.trial, need: need.into(), got: row.config.clone() })
    }
}
