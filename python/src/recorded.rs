//! Journals and recordings as columns.

use std::collections::BTreeMap;
use std::path::PathBuf;

use contract::{Command, MonotonicNs, Record, State};
use hopper_sim::{Journal, JournalReader};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use recording::{RecordedMessage, Recording, SkippedMessages};

use crate::boundary::guarded;
use crate::columns::{self, Columns};

/// Reads a journal, or that of a run's output directory; see `hopper.read_journal`.
#[pyfunction]
pub fn read_journal<'py>(
    py: Python<'py>,
    path: PathBuf,
) -> PyResult<(String, String, Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    guarded(|| {
        let inner = path.join("journal");
        let folder = if !Journal::exists(&path) && Journal::exists(&inner) { inner } else { path };
        if std::fs::metadata(&folder).is_ok_and(|data| !data.is_dir()) {
            let of_file = folder.parent().filter(|parent| Journal::exists(parent));
            let hint = of_file.map_or_else(String::new, |parent| format!(": name {}", parent.display()));
            let got = folder.display();
            return Err(crate::error(format!(
                "a journal needs to be a folder, or the output folder of a run, got the file {got}{hint}"
            )));
        }
        let journal = JournalReader::open(&folder).map_err(crate::error)?;
        journal.require_sound().map_err(crate::error)?;
        let records: Vec<Record> = journal.records().collect::<Result<_, _>>().map_err(crate::error)?;
        let header = journal.header();
        let digest = records.last().map_or_else(String::new, |last| last.digest.to_string());
        let about = serde_json::json!({
            "seed": header.seed,
            "brief": header.brief,
            "digest": digest,
            "decisions": records.len(),
        });
        let (rows, route) = (columns::records(py, &records)?, columns::route(py, &header.brief, &records)?);
        Ok((about.to_string(), header.resolved.clone(), rows, route))
    })
}

/// Reads a recording; see `hopper.read_recording`. A damaged one is read up to its last whole record.
#[pyfunction]
pub fn read_recording<'py>(py: Python<'py>, path: PathBuf) -> PyResult<(String, Bound<'py, PyDict>)> {
    guarded(|| {
        let unreadable = |error: std::io::Error| crate::error(format!("{}: {error}", path.display()));
        // A device or a pipe would be read for ever.
        if !std::fs::metadata(&path).map_err(unreadable)?.is_file() {
            return Err(crate::error(format!("a recording needs to be a file, got {}", path.display())));
        }
        let bytes = std::fs::read(&path).map_err(unreadable)?;
        let recording = Recording::read(&bytes).map_err(crate::error)?;
        let mut counts = BTreeMap::<String, u64>::new();
        let (mut states, mut commands) =
            (Vec::<(MonotonicNs, State)>::new(), Vec::<(MonotonicNs, Command)>::new());
        let mut skipped = SkippedMessages::default();
        for entry in recording.entries() {
            *counts.entry(entry.topic.clone()).or_default() += 1;
            match skipped.skip(entry.message()).flatten() {
                Some(RecordedMessage::State(state)) => states.push((entry.logged, state)),
                Some(RecordedMessage::Command(command)) => commands.push((entry.logged, command)),
                _ => {}
            }
        }
        let about = serde_json::json!({
            "whole": recording.is_whole(),
            "lost_bytes": recording.lost_bytes(),
            "undecodable": skipped.messages,
            "damage": skipped.to_string(),
            "metadata": recording.metadata,
            "messages": counts,
        });
        let tables = PyDict::new(py);
        let table = Columns::new(py);
        table.add("logged_ns", states.iter().map(|(logged, _)| logged.0))?;
        table.add("published_ns", states.iter().map(|(_, state)| state.published.0))?;
        table.add("decision", states.iter().map(|(_, state)| state.decision.0))?;
        table.add("robot", states.iter().map(|(_, state)| state.robot.0))?;
        table.add("x", states.iter().map(|(_, state)| state.pose.cell.x))?;
        table.add("y", states.iter().map(|(_, state)| state.pose.cell.y))?;
        table.add("height_m", states.iter().map(|(_, state)| state.pose.height_m))?;
        table.add("steps", states.iter().map(|(_, state)| state.steps))?;
        table.add("visits", states.iter().map(|(_, state)| state.visits))?;
        table.add("status", states.iter().map(|(_, state)| state.status.code() as u8))?;
        tables.set_item("state", table.into_dict())?;
        let table = Columns::new(py);
        table.add("logged_ns", commands.iter().map(|(logged, _)| logged.0))?;
        table.add("decision", commands.iter().map(|(_, command)| command.decision.0))?;
        table.add("robot", commands.iter().map(|(_, command)| command.robot.0))?;
        table.add("action", commands.iter().map(|(_, command)| command.action.code() as u8))?;
        table.add("term", commands.iter().map(|(_, command)| command.term.0))?;
        table.add("work", commands.iter().map(|(_, command)| command.work))?;
        table.add("planning_started_ns", commands.iter().map(|(_, command)| command.planning_started.0))?;
        table.add("planning_ended_ns", commands.iter().map(|(_, command)| command.planning_ended.0))?;
        tables.set_item("command", table.into_dict())?;
        Ok((about.to_string(), tables))
    })
}
