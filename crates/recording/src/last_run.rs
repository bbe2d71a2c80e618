//! Gathers the timing of every decision of a recording.

use std::collections::BTreeMap;

use contract::protocol::peer_table::BEAT_PERIOD_NS;
use contract::{Brief, Decision, Incarnation, MonotonicNs, Record, Role, State};
use report::decisions::boot_began;
use report::{Cause, DecisionTiming, Disturbance};

use crate::{MachineLoad, RecordedMessage, Recording, RecordingError, SequenceGap, SkippedMessages};

/// How long a snapshot page may explain long decisions afterwards, nanoseconds.
const SNAPSHOT_EFFECT_NS: u64 = 200_000_000;

/// Share of busy cores from which the machine counts as loaded.
const BUSY: f64 = 0.95;

/// The last run of a recording.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    /// Brief of the run.
    pub brief: Brief,
    /// Timing of the decisions in order; missing ones are left out.
    pub decisions: Vec<DecisionTiming>,
    /// Records of the decisions, as far as they were recorded.
    pub records: BTreeMap<Decision, Record>,
    /// Last state; `None` if none was recorded.
    pub state: Option<State>,
    /// Disturbances that may explain long decisions.
    pub disturbances: Vec<Disturbance>,
    /// Load of the machine over the run.
    pub machine_loads: Vec<MachineLoad>,
    /// Messages that did not reach the recorder.
    pub gaps: Vec<SequenceGap>,
    /// Messages of the whole file that cannot be decoded.
    pub skipped: SkippedMessages,
}

/// Gathers the decisions of the last run of a recording. The times of a decision come from the state after it, which
/// has the true time of its commit, or else from its record.
///
/// # Errors
/// If there is no brief. Messages that cannot be decoded are left out and counted.
// Long: an arm for each kind of message.
pub fn last_run(recording: &Recording<'_>) -> Result<RecordedRun, RecordingError> {
    let mut run: Option<RecordedRun> = None;
    let mut timings: BTreeMap<Decision, DecisionTiming> = BTreeMap::new();
    let mut processes: BTreeMap<Incarnation, Role> = BTreeMap::new();
    // The first process of each role, with when it was heard and how often it had sent a heartbeat until then.
    let mut first_heard: Vec<(Role, MonotonicNs, u64)> = Vec::new();
    let mut messages = 0;
    let mut skipped = SkippedMessages::default();
    for message in recording.messages() {
        messages += 1;
        let Some((logged, message)) = skipped.skip(message) else { continue };
        match (message, &mut run) {
            (RecordedMessage::Brief(brief), known)
                if known.as_ref().is_none_or(|known| known.brief.run != brief.run) =>
            {
                *known = Some(RecordedRun::new(brief));
                timings.clear();
            }
            (RecordedMessage::State(state), Some(run)) if state.run == run.brief.run => {
                if let Some(step) = DecisionTiming::before(&state) {
                    timings.insert(step.decision, step);
                }
                run.state = Some(state);
            }
            (RecordedMessage::Past(page), Some(run)) if page.run == run.brief.run => {
                run.records.extend(page.records.iter().map(|record| (record.decision, *record)));
            }
            (RecordedMessage::Page(_), Some(run)) => {
                let (from, until) = (logged, logged.plus_ns(SNAPSHOT_EFFECT_NS));
                run.disturbances.push(Disturbance { from, until, cause: Cause::Snapshot });
            }
            (RecordedMessage::Heartbeat(beat), known) => {
                let is_first = !processes.values().any(|role| *role == beat.role);
                let is_new = processes.insert(beat.incarnation, beat.role).is_none();
                if !is_new || beat.role == Role::Planner || beat.role == Role::Monitor {
                    continue;
                }
                match known {
                    Some(run) if !is_first => run.disturbances.push(Disturbance::restart(beat.role, logged)),
                    // Nobody was heard of before it: perhaps another had died before the recording began.
                    _ => first_heard.push((beat.role, logged, beat.counter)),
                }
            }
            (RecordedMessage::Host(host), Some(run)) => {
                if host.busy >= BUSY {
                    let (from, until) = (host.since, host.until);
                    run.disturbances.push(Disturbance { from, until, cause: Cause::HostLoad });
                }
                run.machine_loads.push(host);
            }
            (RecordedMessage::Gap(gap), Some(run)) => run.gaps.push(gap),
            _ => {}
        }
    }
    let mut run = run.ok_or(RecordingError::NoBrief { messages })?;
    run.skipped = skipped;
    for record in run.records.values() {
        let step = timings.entry(record.decision).or_insert_with(|| DecisionTiming::from(record));
        // States do not contain these.
        (step.work, step.cut) = (record.work, record.cut);
    }
    let end = run.state.map_or(Decision(u64::MAX), |state| state.decision);
    let executed = |step: &DecisionTiming| step.decision < end || run.records.contains_key(&step.decision);
    run.decisions = timings.into_values().filter(executed).collect();
    if let Some(began) = boot_began(&run.decisions) {
        // A process that was started after the first landing is not the first of its role.
        let late = first_heard.into_iter().filter(|(_, logged, beats)| {
            logged.0.saturating_sub(beats.saturating_mul(BEAT_PERIOD_NS)) > began.0
        });
        run.disturbances.extend(late.map(|(role, logged, _)| Disturbance::restart(role, logged)));
    }
    Ok(run)
}

impl RecordedRun {
    fn new(brief: Brief) -> Self {
        Self {
            brief,
            decisions: Vec::new(),
            records: BTreeMap::new(),
            state: None,
            disturbances: Vec::new(),
            machine_loads: Vec::new(),
            gaps: Vec::new(),
            skipped: SkippedMessages::default(),
        }
    }
}
