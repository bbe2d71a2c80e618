//! What a folder of rows needs to know of a plan, whatever its trials are: missions of a grid, or worlds of a study.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::CampaignError;
use crate::checksum::{with_checksum, without_checksum};

/// A plan of numbered trials: all that decides the rows of a campaign.
pub trait TrialPlan: Clone + PartialEq + Serialize + DeserializeOwned {
    /// The result of one trial.
    type Row: TrialRow;

    /// Which campaign it is.
    fn identity(&self) -> Identity<'_>;

    /// Number of trials of the whole campaign.
    fn trials(&self) -> u64;

    /// Refuses a plan that was read and cannot be one.
    ///
    /// # Errors
    /// If it was changed since it was made, or a field is out of its range.
    fn check_plan(&self) -> Result<(), CampaignError>;

    /// Checks that `row` belongs to this plan: everything the plan determines must agree.
    ///
    /// # Errors
    /// [`CampaignError::Foreign`] if it belongs to another plan, [`CampaignError::Value`] if no trial can come to that.
    fn check(&self, row: &Self::Row) -> Result<(), CampaignError>;
}

/// Which campaign a plan is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity<'a> {
    /// Name of the campaign.
    pub name: &'a str,
    /// Seed that every trial's seed is derived from.
    pub seed: u64,
    /// Trials of each cell.
    pub repetitions: u64,
    /// Version of the program that flies.
    pub version: &'a str,
    /// SHA-256 over the plan, hexadecimal.
    pub hash: &'a str,
}

/// A row of `trials.jsonl` and `trials.csv`.
///
/// A line of `trials.jsonl` ends with the CRC-32 of everything before it, as text, so that damaged rows are recognised.
pub trait TrialRow: Clone + PartialEq + Serialize + DeserializeOwned {
    /// Number of the trial in the whole campaign, from 0.
    fn trial(&self) -> u64;

    /// Headings of `trials.csv`: one for each number and text of a row, in the order of its fields.
    fn headings() -> Vec<String>;

    /// Refuses numbers that no trial can have.
    ///
    /// # Errors
    /// The field, what it needs, what it has.
    fn check(&self) -> Result<(), String>;

    /// The row as a line of `trials.jsonl`, with its line break.
    #[must_use]
    fn line(&self) -> String {
        let mut text = serde_json::to_string(self).expect("a row is numbers and text");
        assert_eq!(text.pop(), Some('}'), "a row is an object");
        with_checksum(&text) + "\n"
    }

    /// Parses a `line` without its line break.
    ///
    /// # Errors
    /// What is wrong with the line, in words.
    fn of_line(line: &[u8]) -> Result<Self, String> {
        let text = std::str::from_utf8(line).map_err(|error| format!("need UTF-8, got {error}"))?;
        let row: Self = serde_json::from_str(&without_checksum(text)?).map_err(|error| error.to_string())?;
        row.check()?;
        Ok(row)
    }
}

/// The error of a row that contradicts its plan.
pub(crate) fn foreign(trial: u64, need: &str, got: &str) -> CampaignError {
    CampaignError::Foreign { trial, need: need.trim_end().into(), got: got.trim_end().into() }
}

/// Refuses a plan whose hash is not that of its contents.
pub(crate) fn check_hash(need: String, got: &str) -> Result<(), CampaignError> {
    if need == got { Ok(()) } else { Err(CampaignError::Edited { need, got: got.into() }) }
}
