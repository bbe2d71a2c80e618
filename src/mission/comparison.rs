//! Compares a journal with the same planners flown in lockstep: digest and map of every decision.

use std::path::Path;

use contract::{Brief, Decision, Digest, Record};
use hopper_sim::{JournalReader, Mission};
use lockstep::PlannerSchedule;
use node::Failure;
use serde::Serialize;

/// The first decision of a journal that lockstep takes otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The first that differs.
    pub decision: Decision,
    /// Digest after it and fingerprint of the map it was taken on, in lockstep; `None` if lockstep ends before.
    pub need: Option<(Digest, u64)>,
    /// Digest after the decision and fingerprint of the map it was taken on, in the journal.
    pub got: (Digest, u64),
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { decision, need, got: (digest, map) } = self;
        match need {
            None => write!(f, "decision {decision} needs to be none, since lockstep has ended before it"),
            Some((need, need_map)) if need == digest => write!(
                f,
                "decision {decision} needs the map with fingerprint {need_map:016x}, got {map:016x}: it was taken on \
                 a wrong map"
            ),
            Some((need, _)) => write!(f, "decision {decision} needs digest {need}, got {digest}"),
        }
    }
}

/// Flies the mission of the journal in `dir` in lockstep, with the planners and the fallbacks that the journal shows, and
/// compares every decision that the journal holds. `None` if all agree.
///
/// # Errors
/// If the journal cannot be read, or names a planner that is not known.
pub fn against_lockstep(dir: &Path) -> Result<Option<Difference>, Failure> {
    let history = JournalReader::open(dir).map_err(Failure::usage)?;
    let (world, header) = (history.world().map_err(Failure::usage)?, history.header());
    let schedule = PlannerSchedule::from_records(history.records()).map_err(Failure::usage)?;
    if schedule.is_empty() {
        return Ok(None);
    }
    let brief = Brief { run: header.run(), ..world.brief.clone() };
    let mission = Mission { brief, ..Mission::of(&world, header.seed) };
    let mut held = history.records().map_while(Result::ok);
    let mut first = None;
    let outline = |record: &Record| (record.digest, record.observation);
    lockstep::fly(mission, &schedule, &mut || contract::MonotonicNs(0), &mut |due| {
        let Some(record) = held.next() else { return };
        if outline(&record) != outline(due) && first.is_none() {
            let (decision, need, got) = (record.decision, Some(outline(due)), outline(&record));
            first = Some(Difference { decision, need, got });
        }
    })
    .map_err(Failure::usage)?;
    let beyond = || {
        let record = held.next()?;
        Some(Difference { decision: record.decision, need: None, got: outline(&record) })
    };
    Ok(first.or_else(beyond))
}
