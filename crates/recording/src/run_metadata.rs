//! Assigns the metadata of a recording to its runs.
//!
//! A file may hold several recordings that another program has put together, and a recorder may see several missions.
//! Metadata `hopper` has the time at which its recorder started, `end` the time at which it ended and the run it ended
//! with. A value that may belong to another run is not known.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use contract::{Digest, RunId};

use crate::{Channel, RecordedMessage, Recording};

type Entries = BTreeMap<String, String>;

/// The metadata of one run of a recording.
#[derive(Clone, Debug)]
pub struct RunMetadata<'a> {
    /// Records `hopper` of the recorders that may have recorded the run.
    recorders: Vec<&'a Entries>,
    /// Whether a recorder of this run may have recorded another run too.
    is_shared: bool,
    /// Record `end` of the recorder that saw the end of the run.
    end: Option<&'a Entries>,
}

impl<'a> RunMetadata<'a> {
    /// The metadata of `run`, or of the whole file if there is no run. `digest` is that of the run's last state.
    pub(crate) fn new(recording: &'a Recording<'_>, run: Option<RunId>, digest: Option<Digest>) -> Self {
        let begins_ns = begins_ns(recording);
        let (all, ends) = (recording.metadata_named("hopper"), recording.metadata_named("end"));
        let begin_ns = run.and_then(|run| begins_ns.get(&run).copied());
        if begins_ns.len() <= 1 && all.len() <= 1 {
            // Another program may have changed the times.
            return Self {
                recorders: all,
                is_shared: false,
                end: only(&ends).or(end_of(&ends, run, digest)),
            };
        }
        let may_have = |entries: &Entries, at_ns| window_ns(entries, &ends).contains(&at_ns);
        let recorders: Vec<&Entries> = match begin_ns {
            Some(begin_ns) => all.into_iter().filter(|entries| may_have(entries, begin_ns)).collect(),
            None => all,
        };
        let has_another = |entries: &&Entries| {
            begins_ns.iter().any(|(other, at_ns)| Some(*other) != run && may_have(entries, *at_ns))
        };
        let is_shared = recorders.iter().any(has_another);
        Self { is_shared, end: end_of(&ends, run, digest), recorders }
    }

    /// What `hopper` says of the recorder and its machine, such as `version`; `None` if it does not, or several recorders
    /// may have recorded the run and differ.
    #[must_use]
    pub fn recorder(&self, key: &str) -> Option<&'a str> {
        let first = self.recorders.first()?.get(key)?;
        self.recorders.iter().all(|entries| entries.get(key) == Some(first)).then_some(first.as_str())
    }

    /// What `hopper` says of the mission, such as `seed`; `None` if it does not, or may say it of another run.
    #[must_use]
    pub fn mission(&self, key: &str) -> Option<&'a str> {
        if self.is_shared { None } else { self.recorder(key) }
    }

    /// What `end` says of the run's end; `None` if the recording of the run was cut.
    #[must_use]
    pub fn end(&self, key: &str) -> Option<&'a str> {
        self.end?.get(key).map(String::as_str)
    }
}

impl Recording<'_> {
    /// The metadata of `run`, whose last state has `digest`; of the whole file if it has no run.
    #[must_use]
    pub fn metadata_of(&self, run: Option<RunId>, digest: Option<Digest>) -> RunMetadata<'_> {
        RunMetadata::new(self, run, digest)
    }
}

/// When the brief of each run was first recorded, nanoseconds.
fn begins_ns(recording: &Recording<'_>) -> BTreeMap<RunId, u64> {
    let mut begins_ns = BTreeMap::new();
    for entry in recording.entries().filter(|entry| entry.known == Some(Channel::Brief)) {
        if let Ok(Some(RecordedMessage::Brief(brief))) = entry.message() {
            begins_ns.entry(brief.run).or_insert(entry.logged.0);
        }
    }
    begins_ns
}

/// From when until when a recorder may have recorded, nanoseconds. Nothing says which `end` is its own, so it is the first
/// after its start: a window is too short rather than one that holds the run of another recorder.
fn window_ns(recorder: &Entries, ends: &[&Entries]) -> RangeInclusive<u64> {
    let started_ns = time_ns(recorder, "started_ns").unwrap_or(0);
    let ended_ns = ends.iter().filter_map(|end| time_ns(end, "ended_ns")).filter(|end| *end >= started_ns);
    started_ns..=ended_ns.min().unwrap_or(u64::MAX)
}

fn time_ns(entries: &Entries, key: &str) -> Option<u64> {
    entries.get(key)?.parse().ok()
}

/// The end that names the run; recordings of older versions name no run, but the digest of the last state.
fn end_of<'a>(ends: &[&'a Entries], run: Option<RunId>, digest: Option<Digest>) -> Option<&'a Entries> {
    let (run, digest) = (run?.to_string(), digest?.to_string());
    let names_run = |end: &&&Entries| end.get("run") == Some(&run);
    let has_digest = |end: &&&Entries| !end.contains_key("run") && end.get("digest") == Some(&digest);
    ends.iter().find(names_run).or_else(|| ends.iter().find(has_digest)).copied()
}

fn only<'a>(ends: &[&'a Entries]) -> Option<&'a Entries> {
    match ends {
        [end] => Some(end),
        _ => None,
    }
}
