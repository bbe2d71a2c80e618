//! The trials of a grid of missions: a plan with its rows.

use crate::file::{CELLS_MAX, check_repetitions};
use crate::trial_plan::{Identity, check_hash, foreign};
use crate::{CampaignError, Plan, Row, TrialPlan, TrialRow};

impl TrialPlan for Plan {
    type Row = Row;

    fn identity(&self) -> Identity<'_> {
        let Self { name, seed, repetitions, version, hash, .. } = self;
        Identity { name, seed: *seed, repetitions: *repetitions, version, hash }
    }

    fn trials(&self) -> u64 {
        self.cells.len() as u64 * self.repetitions
    }

    fn check_plan(&self) -> Result<(), CampaignError> {
        check_hash(self.fingerprint(), &self.hash)?;
        let refuse = |field, need: String, got: String| Err(CampaignError::Value { field, need, got });
        if !(1..=CELLS_MAX).contains(&self.cells.len()) {
            return refuse("cells", format!("1 to {CELLS_MAX}"), self.cells.len().to_string());
        }
        if let Some((place, cell)) = (0..).zip(&self.cells).find(|(place, cell)| cell.number != *place) {
            return refuse("number of a cell", place.to_string(), cell.number.to_string());
        }
        check_repetitions(self.repetitions, self.cells.len() as u64, 1)
    }

    fn check(&self, row: &Row) -> Result<(), CampaignError> {
        let trial = self.trial(row.trial);
        let Some(trial) = trial.filter(|trial| trial.cell.config == row.config) else {
            let need = trial.map_or("none", |trial| &trial.cell.config);
            return Err(foreign(row.trial, &format!("configuration {need}"), &row.config));
        };
        let need = Row::new(self, &trial, row.result());
        if *row == need { Ok(()) } else { Err(foreign(row.trial, &need.line(), &row.line())) }
    }
}
