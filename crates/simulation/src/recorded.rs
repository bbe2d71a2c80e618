//! What a recording holds of the mission.

use std::collections::BTreeSet;

use contract::{Decision, RunId};
use recording::{RecordedMessage as Message, Recording};

/// The decisions of a run of which a recording holds the record.
pub(crate) fn decisions_recorded(bytes: &[u8], run: RunId) -> BTreeSet<Decision> {
    let mut decisions = BTreeSet::new();
    let Ok(recording) = Recording::read(bytes) else { return decisions };
    for (_, message) in recording.messages().flatten() {
        if let Message::Past(page) = message
            && page.run == run
        {
            decisions.extend(page.records.iter().map(|record| record.decision));
        }
    }
    decisions
}
