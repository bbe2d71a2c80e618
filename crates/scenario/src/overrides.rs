//! Scenario values that the command line overrides.

use std::path::PathBuf;

use contract::Profile;

/// Command-line overrides, applied by [`crate::Scenario::with`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Replaces `brief.profile`.
    pub profile: Option<Profile>,
    /// Replaces `limits.decision_budget_ms`; nanoseconds.
    pub decision_budget_ns: Option<u64>,
    /// Replaces the elevation file; a relative path starts from the current folder.
    pub dem: Option<PathBuf>,
    /// Replaces `truth.terrain.elevation_file.nodata`.
    pub nodata: Option<Vec<f64>>,
}
