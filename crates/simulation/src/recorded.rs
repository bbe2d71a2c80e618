//! What a recording holds of the mission.

use std::collections::BTreeSet;

use contract::{Decision, Digest, RunId};
use recording::{RecordedMessage as Message, Recording};

/// The decisions of a run of which a recording holds the record, with the digest after each.
pub(crate) fn decisions_recorded(bytes: &[u8], run: RunId) -> BTreeSet<(Decision, Digest)> {
    let mut decisions = BTreeSet::new();
    let Ok(recording) = Recording::read(bytes) else { return decisions };
    for (_, message) in recording.messages().flatten() {
        if let Message::Past(page) = message
            && page.run == run
        {
            decisions.extend(page.records.iter().map(|record| (record.decision, record.digest)));
        }
    }
    decisions
}
