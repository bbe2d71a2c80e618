//! Scenario values that the command line overrides.

use std::path::PathBuf;

use contract::{MotionModel, Profile};

use crate::Preset;

/// Command-line overrides, applied by [`crate::Scenario::with`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Replaces `brief.profile`.
    pub profile: Option<Profile>,
    /// Replaces `truth.dynamics` by the defaults of a model, unless it has that model already.
    pub dynamics: Option<MotionModel>,
    /// Replaces gravity and soils, and with that the motion model by `contact`.
    pub preset: Option<Preset>,
    /// Replaces `brief.motion.table`; a relative path starts from the current folder.
    pub table: Option<PathBuf>,
    /// Replaces `limits.decision_budget_ms`; nanoseconds.
    pub decision_budget_ns: Option<u64>,
    /// Replaces the elevation file; a relative path starts from the current folder.
    pub dem: Option<PathBuf>,
    /// Replaces `truth.terrain.elevation_file.nodata`.
    pub nodata: Option<Vec<f64>>,
}
