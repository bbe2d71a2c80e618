//! How the mission and its processes do, as `diagnostic_msgs/DiagnosticArray`.

use std::collections::BTreeMap;

use contract::{Brief, Heartbeat, Incarnation, MonotonicNs, Record, RobotId, Stage, Standing, Status, Team};

use crate::message::{Byte, DiagnosticArray, DiagnosticStatus, KeyValue};
use crate::{Clock, Landing};

/// Time between two reports of one process, nanoseconds: diagnostics are commonly sent once a second.
const PERIOD_NS: u64 = 1_000_000_000;

/// The mission, its last decision and its robots at a landing.
pub(crate) fn of_landing(
    brief: &Brief,
    landing: &Landing,
    record: Option<&Record>,
    team: Option<&Team>,
    clock: &Clock,
) -> DiagnosticArray {
    let mut status = vec![mission(brief, landing)];
    status.extend(record.map(decision));
    if let Some(team) = team {
        let numbered = (0..).map(RobotId).zip(team.members.iter());
        status.extend(numbered.map(|(robot, member)| {
            let level = match member.standing {
                Standing::Active | Standing::Done => DiagnosticStatus::OK,
                Standing::GaveUp => DiagnosticStatus::WARN,
                Standing::Stranded => DiagnosticStatus::ERROR,
            };
            let leader = &member.leader;
            let values = [
                ("cell", format!("{} {}", member.at.cell.x, member.at.cell.y)),
                ("planner", leader.planner.to_string()),
                ("term", leader.term.to_string()),
                ("waits", member.waits.to_string()),
            ];
            component(&format!("robot_{robot}"), level, member.standing.to_string(), values)
        }));
    }
    DiagnosticArray { header: clock.header(landing.moment, ""), status }
}

fn mission(brief: &Brief, landing: &Landing) -> DiagnosticStatus {
    let state = &landing.state;
    let level = match state.status {
        Status::Underway | Status::Goal => DiagnosticStatus::OK,
        Status::Deadlock | Status::LeftMap | Status::Lost => DiagnosticStatus::ERROR,
    };
    let values = [
        ("run", state.run.to_string()),
        ("scenario", brief.scenario.to_string()),
        ("decision", state.decision.to_string()),
        ("robot", state.robot.to_string()),
        ("steps", state.steps.to_string()),
        ("visits", state.visits.to_string()),
        ("treasures", state.collected.count().to_string()),
        ("digest", state.digest.to_string()),
    ];
    component("mission", level, state.status.to_string(), values)
}

/// The decision that led to a landing, with the time of each stage.
fn decision(record: &Record) -> DiagnosticStatus {
    let is_usual = record.vetoed.is_empty() && !record.origin.is_fallback() && !record.cut;
    let level = if is_usual { DiagnosticStatus::OK } else { DiagnosticStatus::WARN };
    let us = |ns: u64| (ns as f64 / 1e3).to_string();
    let outcome = &record.outcome;
    let mut values = vec![
        ("decision".to_owned(), record.decision.to_string()),
        ("robot".to_owned(), record.robot.to_string()),
        ("action".to_owned(), record.action.to_string()),
        ("branch".to_owned(), word(&outcome.branch)),
        ("from".to_owned(), format!("{} {}", outcome.from.x, outcome.from.y)),
        ("to".to_owned(), format!("{} {}", outcome.to.x, outcome.to.y)),
        ("origin".to_owned(), record.origin.to_string()),
        ("vetoes".to_owned(), record.vetoed.count().to_string()),
        ("planner".to_owned(), record.leader.planner.to_string()),
        ("term".to_owned(), record.leader.term.to_string()),
        ("pid".to_owned(), record.leader.pid.to_string()),
        ("work".to_owned(), record.work.to_string()),
        ("cut".to_owned(), record.cut.to_string()),
        ("total_us".to_owned(), us(record.timing.total_ns())),
    ];
    for (stage, ns) in Stage::ALL.into_iter().zip(record.timing.stages_ns()) {
        values.push((format!("{stage}_us"), us(ns)));
    }
    component("decision", level, record.action.to_string(), values)
}

/// A word as it is in JSON.
fn word(value: &impl serde::Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|json| json.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Reports of processes, each once a second at most.
#[derive(Clone, Debug, Default)]
pub(crate) struct Processes {
    reported: BTreeMap<Incarnation, MonotonicNs>,
}

impl Processes {
    /// The report that a heartbeat at `moment` makes, if one is due.
    pub fn on(&mut self, beat: &Heartbeat, moment: MonotonicNs, clock: &Clock) -> Option<DiagnosticArray> {
        let is_due = |last: &MonotonicNs| moment.since_ns(*last) >= PERIOD_NS;
        if !self.reported.get(&beat.incarnation).is_none_or(is_due) {
            return None;
        }
        self.reported.insert(beat.incarnation, moment);
        let values = [
            ("pid", beat.pid.to_string()),
            ("life", beat.incarnation.to_string()),
            ("version", beat.version.to_string()),
            ("planner", beat.planner.to_string()),
            ("beats", beat.counter.to_string()),
            ("decision", beat.decision.to_string()),
        ];
        let status = vec![component(beat.role.as_str(), DiagnosticStatus::OK, "alive".into(), values)];
        Some(DiagnosticArray { header: clock.header(moment, ""), status })
    }
}

fn component<K: Into<String>>(
    name: &str,
    level: Byte,
    message: String,
    values: impl IntoIterator<Item = (K, String)>,
) -> DiagnosticStatus {
    let values = values.into_iter().map(|(key, value)| KeyValue { key: key.into(), value });
    DiagnosticStatus {
        level,
        name: format!("hopper: {name}"),
        message,
        hardware_id: "hopper".into(),
        values: values.collect(),
    }
}
