//! Reads the rows of `trials.jsonl` one after another.

use std::io::{BufRead, Read};

use crate::row::LINE_BYTES_MAX;
use crate::{CampaignError, Manifest, Plan, TrialPlan, TrialRow};

/// Reads rows in order, each checked against its checksum and its plan.
#[derive(Debug)]
pub struct Rows<'a, R, P = Plan> {
    manifest: &'a Manifest<P>,
    reader: R,
    line: u64,
}

impl<'a, R: BufRead, P: TrialPlan> Rows<'a, R, P> {
    /// A reader of the rows of `manifest` from `reader`.
    pub fn new(manifest: &'a Manifest<P>, reader: R) -> Self {
        Self { manifest, reader, line: 0 }
    }

    /// Number of rows read so far.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.line
    }

    /// The next row; `None` at the end. A last line without line break is ignored: its write was interrupted.
    ///
    /// # Errors
    /// If the row is damaged, out of order, or of another campaign.
    #[allow(clippy::should_implement_trait, reason = "it fails")]
    pub fn next(&mut self) -> Result<Option<P::Row>, CampaignError> {
        let line = self.line + 1;
        let mut text = Vec::new();
        (&mut self.reader).take(LINE_BYTES_MAX as u64 + 1).read_until(b'\n', &mut text)?;
        if text.len() > LINE_BYTES_MAX {
            let reason = format!("need at most {LINE_BYTES_MAX} bytes, got more; it is damaged");
            return Err(CampaignError::Damaged { line, reason });
        }
        let Some(text) = text.strip_suffix(b"\n") else { return Ok(None) };
        self.line = line;
        let Manifest { shard, plan } = self.manifest;
        let row = P::Row::of_line(text).map_err(|reason| CampaignError::Damaged { line, reason })?;
        let need = shard.nth(line - 1, plan.trials());
        if need != Some(row.trial()) {
            let need = need.map_or("no more".into(), |need| need.to_string());
            return Err(CampaignError::Order { line, need, got: row.trial() });
        }
        plan.check(&row)?;
        Ok(Some(row))
    }
}
