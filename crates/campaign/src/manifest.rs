//! `campaign.json`: which shard of which plan a folder of rows belongs to.

use contract::Name;
use serde::{Deserialize, Serialize};

use crate::checksum::{with_checksum, without_checksum};
use crate::file::{CELLS_MAX, TRIALS_MAX};
use crate::{CampaignError, Plan, Shard};

/// Longest `campaign.json`, bytes: enough for [`CELLS_MAX`] resolved scenarios.
pub const MANIFEST_BYTES_MAX: u64 = 1 << 26;

/// The shard and the plan of a folder of rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Shard that the folder holds.
    pub shard: Shard,
    /// Plan of the whole campaign.
    #[serde(flatten)]
    pub plan: Plan,
}

impl Manifest {
    /// Reads `campaign.json`.
    ///
    /// # Errors
    /// If the text is not a manifest, or was changed since it was written.
    pub fn parse(text: &str) -> Result<Self, CampaignError> {
        let damaged = |reason| CampaignError::Plan { reason };
        let text = without_checksum(text.trim_end()).map_err(damaged)?;
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

    /// The text of `campaign.json`, with its checksum.
    #[must_use]
    pub fn text(&self) -> String {
        let text = serde_json::to_string_pretty(self).expect("a plan is numbers and text");
        with_checksum(text.strip_suffix("\n}").expect("a plan is an object")) + "\n"
    }
}
