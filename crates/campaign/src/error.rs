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
    /// A row of a trial that says of it what the plan does not.
    #[error("trial {trial}: need {need}, got {got}")]
    Foreign {
        /// The trial.
        trial: u64,
        /// What the plan says.
        need: String,
        /// What the row says.
        got: String,
    },
    /// A line that holds no row.
    #[error("line {line}: {reason}")]
    Damaged {
        /// Line of the file, from 1.
        line: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// A file that cannot be read.
    #[error("cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// A plan that is damaged.
    #[error("the plan: {reason}")]
    Plan {
        /// What is wrong with it.
        reason: String,
    },
    /// A plan that was changed since it was laid out.
    #[error("need a plan of hash {need}, got {got}; it is damaged or was edited, so begin in another folder")]
    Edited {
        /// Hash of what the plan holds.
        need: String,
        /// Hash that it claims.
        got: String,
    },
}
