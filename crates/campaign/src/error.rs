//! Why there is no campaign.

use scenario::ScenarioError;

/// What was needed, what was got, and where.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// Not a campaign; the message has line and column.
    #[error("{origin}: {message}")]
    Toml {
        /// Where the text comes from.
        origin: String,
        /// What is wrong, and where.
        message: String,
    },
    /// A field out of its range.
    #[error("{field}: need {need}, got {got}")]
    Value {
        /// The field.
        field: &'static str,
        /// Its range.
        need: String,
        /// Its value.
        got: String,
    },
    /// A scenario of the grid cannot be flown.
    #[error("scenarios: {selector}: {source}")]
    Scenario {
        /// The scenario as the campaign names it.
        selector: String,
        /// Why.
        #[source]
        source: Box<ScenarioError>,
    },
    /// A cell resolves to another world than it was planned with.
    #[error("cell {number} ({name}): need configuration {need}, got {got}: a file it reads has changed")]
    Changed {
        /// Number of the cell.
        number: u64,
        /// What the cell is.
        name: String,
        /// Hash in the plan.
        need: String,
        /// Hash now.
        got: String,
    },
    /// A row that is not the next of its shard.
    #[error("line {line}: need trial {need}, got {got}")]
    Order {
        /// Line of the file, from 1.
        line: u64,
        /// Trial that is due, or a word on there being none.
        need: String,
        /// Trial in the file.
        got: u64,
    },
    /// A row whose configuration is not its cell's.
    #[error("trial {trial}: need configuration {need}, got {got}")]
    Foreign {
        /// The trial.
        trial: u64,
        /// Hash in the plan.
        need: String,
        /// Hash in the row.
        got: String,
    },
}
