//! What a folder of rows is a part of: `campaign.json`.

use contract::Name;
use serde::{Deserialize, Serialize};

use crate::file::{CELLS_MAX, TRIALS_MAX};
use crate::seal::{seal, unseal};
use crate::{CampaignError, Plan, Shard};

/// Longest `campaign.json`, bytes: [`CELLS_MAX`] worlds in full.
pub const MANIFEST_BYTES_MAX: u64 = 1 << 26;

/// A part of a campaign with its plan: all that decides the rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The part.
    pub shard: Shard,
    /// The whole.
    #[serde(flatten)]
    pub plan: Plan,
}

impl Manifest {
    /// Reads `campaign.json`.
    ///
    /// # Errors
    /// If it is none, or not as it was written.
    pub fn parse(text: &str) -> Result<Self, CampaignError> {
        let damaged = |reason| CampaignError::Plan { reason };
        let text = unseal(text.trim_end()).map_err(damaged)?;
        let manifest: Self = serde_json::from_str(&text).map_err(|error| damaged(error.to_string()))?;
        let Self { shard, plan } = &manifest;
        let refuse = |field, need: String, got: String| Err(CampaignError::Value { field, need, got });
        let need = plan.fingerprint();
        if need != plan.hash {
            return Err(CampaignError::Edited { need, got: plan.hash.clone() });
        }
        if let Err(need) = shard.to_string().parse::<Shard>() {
            return refuse("shard", need, shard.to_string());
        }
        if plan.name.parse::<Name>().is_err() {
            return refuse("name", "a name".into(), format!("{:?}", plan.name));
        }
        if !(1..=CELLS_MAX).contains(&plan.cells.len()) {
            return refuse("cells", format!("1 to {CELLS_MAX}"), plan.cells.len().to_string());
        }
        if let Some((place, cell)) = (0..).zip(&plan.cells).find(|(place, cell)| cell.number != *place) {
            return refuse("number of a cell", place.to_string(), cell.number.to_string());
        }
        match plan.repetitions.checked_mul(plan.cells.len() as u64) {
            Some(1..=TRIALS_MAX) => Ok(manifest),
            _ => {
                let need = format!("at least 1, and at most {TRIALS_MAX} trials in all");
                refuse("repetitions", need, plan.repetitions.to_string())
            }
        }
    }

    /// As it stands in `campaign.json`.
    #[must_use]
    pub fn text(&self) -> String {
        let text = serde_json::to_string_pretty(self).expect("a plan is numbers and text");
        seal(text.strip_suffix("\n}").expect("a plan is an object")) + "\n"
    }
}
