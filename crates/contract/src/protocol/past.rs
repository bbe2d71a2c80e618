//! The journal's public projection, paged: the one source of every rebuild.

use serde::{Deserialize, Serialize};

use crate::{Decision, Record, RobotId, RunId};

/// Asks for records from a decision on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PastRequest {
    /// The run whose past is meant.
    pub run: RunId,
    /// Robot 0, the only one of a mission.
    pub robot: RobotId,
    /// First decision wanted.
    pub from: Decision,
}

/// At most [`crate::limits::PAST_PAGE_RECORDS`] consecutive records.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PastPage {
    /// The run whose past this is; the asker's is wrong if it differs.
    pub run: RunId,
    /// Robot 0, the only one of a mission.
    pub robot: RobotId,
    /// Decision of the first record.
    pub from: Decision,
    /// Records in order of decisions; empty at the end of the past.
    pub records: Vec<Record>,
}
