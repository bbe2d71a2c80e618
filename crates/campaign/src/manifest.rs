//! `campaign.json`: which shard of which plan a folder of rows belongs to.

use contract::Name;
use serde::{Deserialize, Serialize};

use crate::checksum::{with_checksum, without_checksum};
use crate::{CampaignError, Plan, Shard, TrialPlan};

/// Longest `campaign.json`, bytes: enough for [`crate::file::CELLS_MAX`] resolved scenarios.
pub const MANIFEST_BYTES_MAX: u64 = 1 << 26;

/// The shard and the plan of a folder of rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest<P = Plan> {
    /// Shard that the folder holds.
    pub shard: Shard,
    /// Plan of the whole campaign.
    #[serde(flatten)]
    pub plan: P,
}

impl<P: TrialPlan> Manifest<P> {
    /// Reads `campaign.json`.
    ///
    /// # Errors
    /// If the text is not a manifest, or was changed since it was written.
    pub fn parse(text: &str) -> Result<Self, CampaignError> {
        let damaged = |reason| CampaignError::Plan { reason };
        let text = without_checksum(text.trim_end()).map_err(damaged)?;
        let manifest: Self = serde_json::from_str(&text).map_err(|error| damaged(error.to_string()))?;
        let Self { shard, plan } = &manifest;
        plan.check_plan()?;
        let refuse = |field, need: String, got: String| Err(CampaignError::Value { field, need, got });
        if let Err(need) = shard.to_string().parse::<Shard>() {
            return refuse("shard", need, shard.to_string());
        }
        let name = plan.identity().name;
        if name.parse::<Name>().is_err() {
            return refuse("name", "a name".into(), format!("{name:?}"));
        }
        Ok(manifest)
    }

    /// The text of `campaign.json`, with its checksum.
    #[must_use]
    pub fn text(&self) -> String {
        let text = serde_json::to_string_pretty(self).expect("a plan is numbers and text");
        with_checksum(text.strip_suffix("\n}").expect("a plan is an object")) + "\n"
    }
}
