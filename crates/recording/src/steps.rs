//! What a recording tells of the time of every decision.

use std::collections::BTreeMap;

use contract::{Brief, Decision, Incarnation, Record, Role, State};
use report::{Cause, DecisionTiming, Disturbance};

use crate::{Gap, Host, Message, Recording, RecordingError};

/// A snapshot's page or a new life explains a decision that ends this long after it, nanoseconds: the news of a
/// life comes with its first beat.
const AFTERMATH_NS: u64 = 200_000_000;

/// Share of all cores at which the host counts as loaded.
const BUSY: f64 = 0.95;

/// The last run of a recording, decision by decision.
#[derive(Clone, Debug)]
pub struct Flown {
    /// The brief.
    pub brief: Brief,
    /// The decisions in order, those missing left out.
    pub steps: Vec<DecisionTiming>,
    /// The records behind them, as far as they are there.
    pub records: BTreeMap<Decision, Record>,
    /// The last state.
    pub state: Option<State>,
    /// What may explain a long decision.
    pub disturbances: Vec<Disturbance>,
    /// How busy the machine was.
    pub hosts: Vec<Host>,
    /// What did not reach the recorder.
    pub gaps: Vec<Gap>,
}

/// Gathers the decisions of a recording's last run. A decision's moments come from the state after it, which has
/// the true moment of its commit, or else from its record.
///
/// # Errors
/// If there is no brief, or a message is malformed.
pub fn steps(recording: &Recording<'_>) -> Result<Flown, RecordingError> {
    let mut flown: Option<Flown> = None;
    let mut timed: BTreeMap<Decision, DecisionTiming> = BTreeMap::new();
    let mut lives: BTreeMap<Incarnation, Role> = BTreeMap::new();
    let mut messages = 0;
    for message in recording.messages() {
        let (logged, message) = message?;
        messages += 1;
        match (message, &mut flown) {
            (Message::Brief(brief), known)
                if known.as_ref().is_none_or(|known| known.brief.run != brief.run) =>
            {
                *known = Some(Flown::new(brief));
                timed.clear();
            }
            (Message::State(state), Some(flown)) if state.run == flown.brief.run => {
                if let Some(step) = DecisionTiming::before(&state) {
                    timed.insert(step.decision, step);
                }
                flown.state = Some(state);
            }
            (Message::Past(page), Some(flown)) if page.run == flown.brief.run => {
                flown.records.extend(page.records.iter().map(|record| (record.decision, *record)));
            }
            (Message::Page(_), Some(flown)) => {
                let (from, until) = (logged, logged.plus_ns(AFTERMATH_NS));
                flown.disturbances.push(Disturbance { from, until, cause: Cause::Snapshot });
            }
            (Message::Heartbeat(beat), known) => {
                let is_first = !lives.values().any(|role| *role == beat.role);
                let is_new = lives.insert(beat.incarnation, beat.role).is_none();
                let planned = beat.role == Role::Planner || beat.role == Role::Monitor;
                if let Some(flown) = known.as_mut().filter(|_| is_new && !is_first && !planned) {
                    let (from, until) = (logged, logged.plus_ns(AFTERMATH_NS));
                    flown.disturbances.push(Disturbance { from, until, cause: Cause::Restart(beat.role) });
                }
            }
            (Message::Host(host), Some(flown)) => {
                if host.busy >= BUSY {
                    let (from, until) = (host.since, host.until);
                    flown.disturbances.push(Disturbance { from, until, cause: Cause::HostLoad });
                }
                flown.hosts.push(host);
            }
            (Message::Gap(gap), Some(flown)) => flown.gaps.push(gap),
            _ => {}
        }
    }
    let mut flown = flown.ok_or(RecordingError::NoBrief { messages })?;
    for record in flown.records.values() {
        let step = timed.entry(record.decision).or_insert_with(|| DecisionTiming::from(record));
        // What a state does not tell.
        (step.work, step.cut) = (record.work, record.cut);
    }
    let end = flown.state.map_or(Decision(u64::MAX), |state| state.decision);
    let executed = |step: &DecisionTiming| step.decision < end || flown.records.contains_key(&step.decision);
    flown.steps = timed.into_values().filter(executed).collect();
    Ok(flown)
}

impl Flown {
    fn new(brief: Brief) -> Self {
        Self {
            brief,
            steps: Vec::new(),
            records: BTreeMap::new(),
            state: None,
            disturbances: Vec::new(),
            hosts: Vec::new(),
            gaps: Vec::new(),
        }
    }
}
