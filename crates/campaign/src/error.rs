//! Errors of reading campaigns, plans and rows.

use scenario::ScenarioError;

/// Why a campaign, its plan or a row cannot be read: what was needed, what was got, and where.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// The text is not a campaign; the message has line and column.
    #[error("{origin}: {message}")]
    Toml {
        /// File the text comes from.
        origin: String,
        /// Message of the TOML parser, shortened.
        message: String,
    },
    /// A field is out of its range.
    #[error("{field}: need {need}, got {got}")]
    Value {
        /// Name of the field.
        field: &'static str,
        /// Allowed values.
        need: String,
        /// Value in the file, and what to do where that is not obvious.
        got: String,
    },
    /// A scenario of the grid cannot be resolved.
    #[error("scenarios: {selector}: {source}")]
    Scenario {
        /// The scenario as the campaign names it.
        selector: String,
        /// The error of the scenario.
        #[source]
        source: Box<ScenarioError>,
    },
    /// A cell no longer resolves to what it was planned with.
    #[error(
        "cell {number} ({name}): need configuration {need}, got {got}; a file it reads has changed: restore it, or begin a new campaign"
    )]
    Changed {
        /// Position of the cell in the plan, from 0.
        number: u64,
        /// The cell in words.
        name: String,
        /// Configuration hash in the plan.
        need: String,
        /// Configuration hash of what the files hold now.
        got: String,
    },
    /// A row is not the next one of its shard.
    #[error("line {line}: need trial {need}, got {got}")]
    Order {
        /// Line of the file, from 1.
        line: u64,
        /// Trial that is due, or "no more".
        need: String,
        /// Trial found in the file.
        got: u64,
    },
    /// A row contradicts the plan.
    #[error("trial {trial}: need {need}, got {got}")]
    Foreign {
        /// Number of the trial.
        trial: u64,
        /// What the plan says.
        need: String,
        /// What the row says.
        got: String,
    },
    /// A row tells of an outcome that its trial cannot have.
    #[error("trial {trial}: {reason}")]
    Outcome {
        /// Number of the trial.
        trial: u64,
        /// What it needs, what it has.
        reason: String,
    },
    /// A line is not a valid row.
    #[error("line {line}: {reason}")]
    Damaged {
        /// Line of the file, from 1.
        line: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// The plan is damaged or not a plan.
    #[error("the plan: {reason}")]
    Plan {
        /// What is wrong with it.
        reason: String,
    },
    /// The plan was changed after it was written.
    #[error("need a plan of hash {need}, got {got}; it is damaged or was edited, so begin in another folder")]
    Edited {
        /// Hash computed over the plan's contents.
        need: String,
        /// Hash stated in the plan.
        got: String,
    },
}
