//! What the command line says instead of the scenario.

use std::path::PathBuf;

use contract::Profile;

/// Command-line overrides, applied by [`crate::Scenario::with`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Reading of the model.
    pub profile: Option<Profile>,
    /// Budget of one decision, nanoseconds.
    pub decision_budget_ns: Option<u64>,
    /// Elevation file; relative to the current folder.
    pub dem: Option<PathBuf>,
}
