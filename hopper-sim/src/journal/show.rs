//! A journal laid open: what it proves, with every record.

use std::path::Path;

use contract::{Detail, Record};
use serde::ser::Error as _;
use serde::{Serialize, Serializer};

use super::{JournalError, JournalReader, Verification};

/// Rows of one table; memory is bounded however long the journal is.
const TABLE_ROWS: usize = 1_000;

/// A verification with every record, serialised as one object without holding the records in memory.
#[derive(Debug, Serialize)]
pub struct Show {
    /// What the journal proves.
    #[serde(flatten)]
    pub verification: Verification,
    #[serde(rename = "records", serialize_with = "records")]
    history: JournalReader,
}

impl Show {
    /// Checks the journal in `dir` and prepares to show it.
    ///
    /// # Errors
    /// As [`super::verify`].
    pub fn new(dir: &Path) -> Result<Self, JournalError> {
        let history = JournalReader::open(dir)?;
        Ok(Self { verification: Verification::of(&history)?, history })
    }

    /// The records as text tables, in file order.
    pub fn tables(&self) -> impl Iterator<Item = Result<String, JournalError>> + '_ {
        let mut records = self.history.records().peekable();
        let has_team = self.history.header().brief.has_team();
        std::iter::from_fn(move || {
            records.peek()?;
            let records = records.by_ref().take(TABLE_ROWS);
            Some(if has_team { team_table(records) } else { table(records) })
        })
    }
}

fn table(records: impl Iterator<Item = Result<Record, JournalError>>) -> Result<String, JournalError> {
    let rows = records.map(|record| record.map(|record| row(&record)));
    rows.collect::<Result<Vec<_>, _>>().map(|rows| report::table(HEADINGS, &rows))
}

/// The table with the number of the robot as second column.
fn team_table(records: impl Iterator<Item = Result<Record, JournalError>>) -> Result<String, JournalError> {
    let [decision, others @ ..] = HEADINGS;
    let row = |record: Record| {
        let [decision, others @ ..] = row(&record);
        with_robot(decision, record.robot.to_string(), others)
    };
    let rows = records.map(|record| record.map(row)).collect::<Result<Vec<_>, _>>();
    rows.map(|rows| report::table(with_robot(decision, "robot", others), &rows))
}

fn with_robot<T>(decision: T, robot: T, others: [T; 12]) -> [T; 14] {
    let mut cells = [decision, robot].into_iter().chain(others);
    std::array::from_fn(|_| cells.next().expect("two and twelve are fourteen"))
}

const HEADINGS: [&str; 13] = [
    "decision",
    "term",
    "planner",
    "action",
    "origin",
    "vetoed",
    "branch",
    "from",
    "to",
    "height m",
    "treasures",
    "steps",
    "status",
];

fn row(record: &Record) -> [String; 13] {
    let outcome = &record.outcome;
    [
        record.decision.to_string(),
        record.leader.term.to_string(),
        record.leader.planner.to_string(),
        record.action.to_string(),
        record.origin.to_string(),
        record.vetoed.count().to_string(),
        format!("{:?}", outcome.branch).to_lowercase(),
        outcome.from.to_string(),
        outcome.to.to_string(),
        format!("{:.3}", record.pose.height_m),
        record.collected.count().to_string(),
        record.steps.to_string(),
        record.status.to_string(),
    ]
}

/// A record with what the motion model tells of it.
#[derive(Serialize)]
struct Told {
    #[serde(flatten)]
    record: Record,
    #[serde(skip_serializing_if = "Option::is_none")]
    detail: Option<Detail>,
}

fn records<S: Serializer>(history: &JournalReader, serializer: S) -> Result<S::Ok, S::Error> {
    let mut failure = None;
    let mut read = history.records();
    let records = std::iter::from_fn(|| {
        let record = read.next()?.map_err(|error| failure = Some(error)).ok()?;
        Some(Told { record, detail: read.detail().cloned() })
    });
    let done = serializer.collect_seq(records)?;
    failure.map_or(Ok(done), |error| Err(S::Error::custom(error)))
}
