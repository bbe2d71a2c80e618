//! The campaign laid out: numbered cells, numbered trials.

use contract::Weights;
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
    /// SHA-256 over all the rest, hexadecimal.
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

    /// What [`Plan::hash`] has to be.
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
            let Cell { number, scenario, profile, planner, weights, steps_max, config, world } = cell;
            let Weights { safety, information, distance } = weights;
            let weights = [safety, information, distance].map(|weight| format!("{:016x}", weight.to_bits()));
            text(&format!("{number} {profile} {} {steps_max}", weights.join(" ")));
            [scenario, planner, config, world].into_iter().for_each(|part| text(part));
        }
        hexadecimal(&hasher.finalize())
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

    /// Whether `row` is one of this plan's: it says of its trial what the plan says.
    ///
    /// # Errors
    /// If it is another's.
    pub fn check(&self, row: &Row) -> Result<(), CampaignError> {
        let trial = self.trial(row.trial);
        let foreign = |need: &str, got: &str| CampaignError::Foreign {
            trial: row.trial,
            need: need.into(),
            got: got.into(),
        };
        let Some(trial) = trial.filter(|trial| trial.cell.config == row.config) else {
            let need = trial.map_or("none", |trial| &trial.cell.config);
            return Err(foreign(&format!("configuration {need}"), &row.config));
        };
        let need = Row::new(self, &trial, row.ending());
        if *row == need { Ok(()) } else { Err(foreign(need.line().trim_end(), row.line().trim_end())) }
    }
}
