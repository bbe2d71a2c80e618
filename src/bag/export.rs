//! `hopper bag export`: rows of a recording for tables and scripts.

use std::collections::BTreeSet;
use std::io::{self, ErrorKind, Write};

use contract::Stage;
use node::{Exit, Failure};
use recording::{Flown, Message, Recording, Topic, steps};
use serde_json::{Map, Value, json};

use super::{Source, at_fault, load, open};

/// Arguments of `hopper bag export`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    source: Source,
    /// `decisions`: a row each with action, outcome and the time of every stage; or a topic such as
    /// hop/r0/state: a row a message.
    #[arg(long, default_value = "decisions", value_name = "NAME")]
    topic: String,
    /// Form of the rows on standard output: csv, or json with one object a line.
    #[arg(long, default_value = "csv", value_parser = ["csv", "json"])]
    format: String,
}

/// Writes the rows.
///
/// # Errors
/// If the recording cannot be read or holds a malformed message, or has no such topic.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let path = &args.source.file;
    let bytes = load(path)?;
    let recording = open(path, &bytes)?;
    let rows = match args.topic.as_str() {
        "decisions" => decisions(&steps(&recording).map_err(|error| at_fault(path, &error))?),
        name => match Topic::of(name).filter(|topic| !topic.is_view()) {
            Some(topic) => messages(&recording, topic).map_err(|error| at_fault(path, &error))?,
            None => {
                let names = Topic::ALL.into_iter().filter(|topic| !topic.is_view()).map(Topic::name);
                let names: Vec<String> = names.collect();
                let message = format!("--topic needs decisions or one of {}, got {name}", names.join(", "));
                return Err(Failure::new(Exit::Usage, message));
            }
        },
    };
    let mut out = io::BufWriter::new(io::stdout().lock());
    let written = match args.format.as_str() {
        "csv" => as_csv(&rows).and_then(|table| out.write_all(&table).and_then(|()| out.flush())),
        _ => as_json(out, &rows),
    };
    match written {
        // The reader has seen enough.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(Exit::Done),
        written => Ok(written.map(|()| Exit::Done)?),
    }
}

/// A row a decision, in the columns of `timing.csv` and more.
fn decisions(flown: &Flown) -> Vec<Value> {
    let us = |ns: u64| ns as f64 / 1e3;
    let row = |step: &report::Step| {
        let mut row = json!({
            "decision": step.decision,
            "planner": step.leader.planner,
            "term": step.leader.term,
            "pid": step.leader.pid,
            "origin": step.origin,
            "vetoes": step.vetoes,
            "work": step.work,
            "cut": step.cut,
            "landed_ns": step.timing.landed,
            "landing_to_command_us": us(step.timing.answer_ns()),
            "total_us": us(step.timing.total_ns()),
        });
        for (stage, ns) in Stage::ALL.into_iter().zip(step.timing.stages_ns()) {
            row[format!("{stage}_us")] = json!(us(ns));
        }
        if let Some(record) = flown.records.get(&step.decision) {
            row["action"] = json!(record.action.to_string());
            row["branch"] = json!(record.outcome.branch);
            row["from_x"] = json!(record.outcome.from.x);
            row["from_y"] = json!(record.outcome.from.y);
            row["to_x"] = json!(record.outcome.to.x);
            row["to_y"] = json!(record.outcome.to.y);
            row["height_m"] = json!(record.pose.height_m);
            row["steps"] = json!(record.steps);
            row["status"] = json!(record.status);
            row["observation"] = json!(format!("{:016x}", record.observation));
            row["digest"] = json!(record.digest);
        }
        row
    };
    flown.steps.iter().map(row).collect()
}

/// A row a message; of the past, a row a record.
fn messages(recording: &Recording<'_>, wanted: Topic) -> Result<Vec<Value>, recording::RecordingError> {
    let mut rows = Vec::new();
    for entry in recording.entries().filter(|entry| entry.known == Some(wanted)) {
        let Some(message) = entry.message()? else { continue };
        let values = match message {
            Message::Brief(brief) => vec![json!(brief)],
            Message::State(state) => vec![json!(state)],
            Message::Patch(patch) => vec![json!(patch)],
            Message::Page(page) => vec![json!(page)],
            Message::Command(command) => vec![json!(command)],
            Message::Policy(policy) => vec![json!(policy)],
            Message::Control(control) => vec![json!(control)],
            Message::Tempo(tempo) => vec![json!(tempo)],
            Message::Heartbeat(beat) => vec![json!(beat)],
            Message::Past(page) => page.records.iter().map(|record| json!(record)).collect(),
            Message::Host(host) => vec![json!({
                "since": host.since, "until": host.until, "busy": host.busy, "load_1min": host.load_1min,
                "cores": host.cores,
            })],
            Message::Gap(gap) => vec![json!({
                "topic": gap.topic, "from": gap.from, "through": gap.through, "counted": gap.counted,
            })],
        };
        for mut value in values {
            value["logged"] = json!(entry.logged);
            rows.push(value);
        }
    }
    Ok(rows)
}

fn as_json(mut out: impl Write, rows: &[Value]) -> io::Result<()> {
    for row in rows {
        serde_json::to_writer(&mut out, row)?;
        writeln!(out)?;
    }
    out.flush()
}

/// Nested fields become columns joined by points, in the order of their names but for the decision, which comes
/// first; lists become their length.
fn as_csv(rows: &[Value]) -> io::Result<Vec<u8>> {
    let flat: Vec<Map<String, Value>> = rows.iter().map(flat).collect();
    let mut columns: Vec<&String> =
        flat.iter().flat_map(Map::keys).collect::<BTreeSet<_>>().into_iter().collect();
    columns.sort_by_key(|name| *name != "decision");
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(&columns)?;
    for row in &flat {
        writer.write_record(columns.iter().map(|name| row.get(*name).map_or_else(String::new, plain)))?;
    }
    writer.into_inner().map_err(|error| error.into_error())
}

fn plain(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn flat(value: &Value) -> Map<String, Value> {
    fn walk(into: &mut Map<String, Value>, path: &str, value: &Value) {
        match value {
            Value::Object(fields) => {
                for (key, value) in fields {
                    let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                    walk(into, &path, value);
                }
            }
            Value::Array(list) => {
                into.insert(format!("{path}.count"), json!(list.len()));
            }
            other => {
                into.insert(path.to_owned(), other.clone());
            }
        }
    }
    let mut into = Map::new();
    walk(&mut into, "", value);
    into
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_with_other_fields_share_one_heading() {
        let rows =
            [json!({ "b": { "c": 1 }, "decision": 0 }), json!({ "decision": 1, "a": [1, 2], "b": null })];
        assert_eq!(
            String::from_utf8(as_csv(&rows).unwrap()).unwrap(),
            "decision,a.count,b,b.c\n0,,,1\n1,2,,\n"
        );
    }
}
