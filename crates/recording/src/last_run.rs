//! Gathers the timing of every decision of a recording.

use std::collections::BTreeMap;

use contract::{Brief, Decision, Incarnation, Record, Role, State};
use report::{Cause, DecisionTiming, Disturbance};

use crate::{MachineLoad, RecordedMessage, Recording, RecordingError, SequenceGap};

/// How long a snapshot page or a new process may explain long decisions afterwards, nanoseconds: a process is
/// noticed only by its first heartbeat.
const EFFECT_NS: u64 = 200_000_000;

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
}

/// Gathers the decisions of the last run of a recording. The times of a decision come from the state after it, which
/// has the true time of its commit, or else from its record.
///
/// # Errors
/// If there is no brief, or a message is malformed.
pub fn last_run(recording: &Recording<'_>) -> Result<RecordedRun, RecordingError> {
    let mut run: Option<RecordedRun> = None;
    let mut timings: BTreeMap<Decision, DecisionTiming> = BTreeMap::new();
    let mut processes: BTreeMap<Incarnation, Role> = BTreeMap::new();
    let mut messages = 0;
    for message in recording.messages() {
        let (logged, message) = message?;
        messages += 1;
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
                let (from, until) = (logged, logged.plus_ns(EFFECT_NS));
                run.disturbances.push(Disturbance { from, until, cause: Cause::Snapshot });
            }
            (RecordedMessage::Heartbeat(beat), known) => {
                let is_first = !processes.values().any(|role| *role == beat.role);
                let is_new = processes.insert(beat.incarnation, beat.role).is_none();
                let planned = beat.role == Role::Planner || beat.role == Role::Monitor;
                if let Some(run) = known.as_mut().filter(|_| is_new && !is_first && !planned) {
                    let (from, until) = (logged, logged.plus_ns(EFFECT_NS));
                    run.disturbances.push(Disturbance { from, until, cause: Cause::Restart(beat.role) });
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
    for record in run.records.values() {
        let step = timings.entry(record.decision).or_insert_with(|| DecisionTiming::from(record));
        // States do not contain these.
        (step.work, step.cut) = (record.work, record.cut);
    }
    let end = run.state.map_or(Decision(u64::MAX), |state| state.decision);
    let executed = |step: &DecisionTiming| step.decision < end || run.records.contains_key(&step.decision);
    run.decisions = timings.into_values().filter(executed).collect();
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
        }
    }
}
