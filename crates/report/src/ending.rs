//! How a run of a mission ended: as the mission did, or before it.

use std::fmt;

use contract::Status;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The name of [`Ending::Stopped`] in JSON.
const STOPPED: &str = "stopped";

/// How a run of a mission ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It stands as the state says: over, or still under way.
    Mission(Status),
    /// The run ended before the mission did, and nothing goes on.
    Stopped,
}

impl Ending {
    /// The name in JSON: that of the status, or `stopped`.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Ending::Mission(status) => status.as_str(),
            Ending::Stopped => STOPPED,
        }
    }
}

impl From<Status> for Ending {
    fn from(status: Status) -> Self {
        Ending::Mission(status)
    }
}

impl PartialEq<Status> for Ending {
    fn eq(&self, status: &Status) -> bool {
        *self == Ending::Mission(*status)
    }
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl Serialize for Ending {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl<'de> Deserialize<'de> for Ending {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let status = || Status::ALL.into_iter().find(|status| status.as_str() == text).map(Ending::Mission);
        let stopped = (text == STOPPED).then_some(Ending::Stopped);
        stopped.or_else(status).ok_or_else(|| {
            serde::de::Error::custom(format!("an outcome is a status or {STOPPED}, got {text:?}"))
        })
    }
}
