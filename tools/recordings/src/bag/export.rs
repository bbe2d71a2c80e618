//! `hopper bag export`: prints a recording as rows for tables and scripts, or makes a bag of ROS 2 of it.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;

use contract::spelling::did_you_mean;
use contract::{Member, Robots, RunId, Stage, Team};
use hopper::commands::topic::{summary, unit};
use hopper::stdout::unwritten;
use node::{Exit, Failure};
use recording::{
    Channel, Entry, JsonMessage, MessageError, RecordedMessage, RecordedRun, Recording, RecordingError,
    SkippedMessages, last_run,
};
use report::DecisionTiming;
use serde_json::{Map, Value, json};

use super::{Source, at_fault, load, open, ros2_bag, warn_of_skipped};

/// Arguments of `hopper bag export`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    source: Source,
    /// `decisions`: one row per decision with action, outcome and the time of every stage; or a topic such as
    /// hop/state: one row per message.
    #[arg(long, default_value = "decisions", value_name = "NAME", conflicts_with = "ros2")]
    topic: String,
    /// Format of the rows on standard output: csv, or json with one object per line.
    #[arg(long, default_value = "csv", value_parser = ["csv", "json"], conflicts_with = "ros2")]
    format: String,
    /// Print the cells of patches, pages and policies, not only their count; in JSON.
    #[arg(long, conflicts_with = "ros2")]
    full: bool,
    /// Write the last mission as a bag of ROS 2 (rosbag2, MCAP) into this new folder instead.
    #[arg(long, value_name = "FOLDER")]
    ros2: Option<PathBuf>,
    /// Most MiB that the maps of that bag take in all: 0 for the last map alone.
    #[arg(long, value_name = "MIB", default_value_t = 256, requires = "ros2")]
    maps_mib: u32,
}

/// Writes the rows, one message in memory at a time.
///
/// # Errors
/// If the recording cannot be read or has no such topic. A message that cannot be decoded has no row, and a warning counts
/// it.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let path = &args.source.file;
    let bytes = load(path)?;
    if let Some(folder) = &args.ros2 {
        return ros2_bag::write(path, &bytes, folder, args.maps_mib);
    }
    let recording = open(path, &bytes)?;
    match args.topic.as_str() {
        "decisions" => {
            let flown = last_run(&recording).map_err(|error| at_fault(path, &error))?;
            warn_of_skipped(path, &flown.skipped);
            write(args, || flown.decisions.iter().map(|step| Ok(decision(&flown, step))))
        }
        name => match Channel::of(name).filter(|topic| !topic.is_view()) {
            Some(topic) if topic.name() == name || other_topics(&recording).contains(name) => {
                write(args, || messages(&recording, name, args.full))
            }
            None if other_topics(&recording).contains(name) => {
                write(args, || json_messages(&recording, name))
            }
            _ => {
                let names = Channel::ALL.into_iter().filter(|topic| !topic.is_view()).map(Channel::name);
                let names: Vec<String> = names.chain(other_topics(&recording)).collect();
                let known = names.iter().map(String::as_str).chain(["decisions"]);
                let meant = did_you_mean(name, known);
                let names = names.join(", ");
                let message = format!("--topic needs decisions or one of {names}, got {name}{meant}");
                Err(Failure::new(Exit::Usage, message))
            }
        },
    }
}

/// The topics of the recording that not every recording has: those recorded as JSON, since their messages have no
/// schema, and the commands of robots but the first.
fn other_topics(recording: &Recording<'_>) -> BTreeSet<String> {
    let is_other = |entry: &Entry<'_>| entry.known.is_none_or(|known| known.name() != entry.topic);
    recording
        .entries()
        .filter(is_other)
        .map(|entry| entry.topic)
        .filter(|topic| topic.starts_with("hop/"))
        .collect()
}

/// A row a message of such a topic, as it was recorded; of `hop/team`, a row a robot.
fn json_messages<'a>(recording: &'a Recording<'a>, topic: &'a str) -> impl Iterator<Item = Row> + 'a {
    let of_topic = recording.entries().filter(move |entry| entry.known.is_none() && entry.topic == topic);
    let is_team = JsonMessage::topic::<Team>().as_deref() == Some(topic);
    let briefed = if is_team { briefed(recording) } else { BTreeMap::new() };
    of_topic.flat_map(move |entry| {
        let rows = match is_team {
            true => serde_json::from_slice(entry.data).map(|team| robots(&team, &briefed)),
            false => serde_json::from_slice::<Map<_, _>>(entry.data).map(|fields| vec![fields]),
        };
        let stamped = |mut row: Map<String, Value>| {
            row.insert("logged".to_owned(), json!(entry.logged));
            Ok(Value::Object(row))
        };
        match rows {
            Ok(rows) => rows.into_iter().map(stamped).collect(),
            Err(error) => {
                let cause = MessageError::Json(error.to_string());
                vec![Err(RecordingError::Message { topic: entry.topic, number: entry.number, cause })]
            }
        }
    })
}

/// The robots of each run.
fn briefed(recording: &Recording<'_>) -> BTreeMap<RunId, Robots> {
    let briefs = recording.entries().filter(|entry| entry.known == Some(Channel::Brief));
    let robots = |entry: Entry<'_>| match entry.message() {
        Ok(Some(RecordedMessage::Brief(brief))) => Some((brief.run, brief.robots)),
        _ => None,
    };
    briefs.filter_map(robots).collect()
}

/// The robots at one decision, each with what its brief says of it, if the recording has that.
fn robots(team: &Team, briefed: &BTreeMap<RunId, Robots>) -> Vec<Map<String, Value>> {
    let &Team { decision, due, actor, .. } = team;
    let described = briefed.get(&team.run);
    let row = |(robot, member): (usize, &Member)| {
        let Member { at, ready_at_ns, standing, leader, last, travel, waits } = member;
        let mut row = json!({
            "decision": decision, "due": due, "actor": actor, "robot": robot, "at": at, "ready_at_ns": ready_at_ns,
            "standing": standing, "leader": leader, "last": last, "travel": travel, "waits": waits,
        });
        if let Some(robot) = described.and_then(|robots| robots.get(robot)) {
            row["body"] = json!(robot.body);
            row["sensor"] = json!(robot.sensor);
            row["start"] = json!(robot.start);
            row["start_at"] = json!(robot.start_at);
            row["goal"] = json!(robot.goal);
        }
        if let Value::Object(row) = row { row } else { Map::new() }
    };
    team.members.iter().enumerate().map(row).collect()
}

/// One row, or why there is none.
type Row = Result<Value, RecordingError>;

/// Writes what `rows` makes, in the form that is asked for.
fn write<R: Iterator<Item = Row>>(args: &Args, rows: impl Fn() -> R) -> Result<Exit, Failure> {
    let out = io::BufWriter::new(io::stdout().lock());
    let written = match args.format.as_str() {
        "csv" => as_csv(out, rows),
        _ => as_json(out, rows()),
    };
    match written {
        // The reader has seen enough.
        Err(Unwritten(error)) if error.kind() == ErrorKind::BrokenPipe => Ok(Exit::Done),
        Err(Unwritten(error)) => Err(unwritten(&error)),
        Ok(skipped) => {
            warn_of_skipped(&args.source.file, &skipped);
            Ok(Exit::Done)
        }
    }
}

/// What ended the rows: standard output.
#[derive(Debug)]
struct Unwritten(io::Error);

impl From<io::Error> for Unwritten {
    fn from(error: io::Error) -> Self {
        Unwritten(error)
    }
}

impl From<serde_json::Error> for Unwritten {
    fn from(error: serde_json::Error) -> Self {
        Unwritten(error.into())
    }
}

impl From<csv::Error> for Unwritten {
    fn from(error: csv::Error) -> Self {
        // Its own way to an error of I/O forgets which.
        match error.into_kind() {
            csv::ErrorKind::Io(error) => Unwritten(error),
            other => Unwritten(io::Error::other(format!("{other:?}"))),
        }
    }
}

/// A row a decision, in the columns of `timing.csv` and more.
fn decision(flown: &RecordedRun, step: &DecisionTiming) -> Value {
    let us = |ns: u64| ns as f64 / 1e3;
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
    if flown.brief.has_team() {
        row["robot"] = json!(step.robot);
    }
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
}

/// A row a message; of the past, a row a record. Cells are counted, as by `hopper topic echo`, and written if `full`: a
/// policy may have hundreds of thousands.
fn messages<'a>(recording: &'a Recording<'a>, topic: &'a str, full: bool) -> impl Iterator<Item = Row> + 'a {
    let of_topic = recording.entries().filter(move |entry| entry.known.is_some() && entry.topic == topic);
    of_topic.flat_map(move |entry| match entry.message() {
        Ok(message) => {
            let stamped = |mut value: Value| {
                value["logged"] = json!(entry.logged);
                Ok(value)
            };
            message
                .map(|message| values(message, full))
                .unwrap_or_default()
                .into_iter()
                .map(stamped)
                .collect()
        }
        Err(error) => vec![Err(error)],
    })
}

fn values(message: RecordedMessage, full: bool) -> Vec<Value> {
    match message {
        RecordedMessage::Brief(brief) => vec![json!(brief)],
        RecordedMessage::State(state) => vec![json!(state)],
        RecordedMessage::Patch(patch) => vec![summary(patch, full)],
        RecordedMessage::Page(page) => vec![summary(page, full)],
        RecordedMessage::Command(command) => vec![json!(command)],
        RecordedMessage::Policy(policy) => vec![summary(policy, full)],
        RecordedMessage::Control(control) => vec![json!(control)],
        RecordedMessage::Pacing(pacing) => vec![json!(pacing)],
        RecordedMessage::Heartbeat(beat) => vec![json!(beat)],
        RecordedMessage::Past(page) => page.records.iter().map(|record| json!(record)).collect(),
        RecordedMessage::Host(host) => vec![json!({
            "since": host.since, "until": host.until, "busy": host.busy, "load_1min": host.load_1min,
            "cores": host.cores,
        })],
        RecordedMessage::Gap(gap) => vec![json!({
            "topic": gap.topic, "from": gap.from, "through": gap.through, "counted": gap.counted,
        })],
    }
}

/// Returns the messages that have no row.
fn as_json(mut out: impl Write, rows: impl Iterator<Item = Row>) -> Result<SkippedMessages, Unwritten> {
    let mut skipped = SkippedMessages::default();
    for row in rows.filter_map(|row| skipped.skip(row)) {
        serde_json::to_writer(&mut out, &row)?;
        writeln!(out)?;
    }
    out.flush()?;
    Ok(skipped)
}

/// Nested fields become columns joined by points, in the order of their names but for the decision, which comes
/// first; lists become their length, and what has no fields is written as `{}`. A column whose field is not named after its unit gets it. The rows are made twice,
/// first for the names of the columns. Returns the messages that have no row.
fn as_csv<R: Iterator<Item = Row>>(
    out: impl Write,
    rows: impl Fn() -> R,
) -> Result<SkippedMessages, Unwritten> {
    let mut columns = BTreeSet::new();
    for row in rows().filter_map(Result::ok) {
        columns.extend(flat(&row).into_iter().map(|(name, _)| name));
    }
    let mut columns: Vec<String> = columns.into_iter().collect();
    columns.sort_by_key(|name| *name != "decision");
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record(columns.iter().map(|column| heading(column)))?;
    let mut skipped = SkippedMessages::default();
    for row in rows().filter_map(|row| skipped.skip(row)) {
        let row = flat(&row);
        writer.write_record(columns.iter().map(|name| row.get(name).map_or_else(String::new, plain)))?;
    }
    writer.flush()?;
    Ok(skipped)
}

/// The name of a column, with its unit.
fn heading(column: &str) -> String {
    let field = column.rsplit('.').next().unwrap_or(column);
    unit(field).map_or_else(|| column.to_owned(), |unit| format!("{column}_{unit}"))
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
            Value::Object(fields) if !fields.is_empty() => {
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
    use contract::MonotonicNs;
    use recording::{Context, Recorder};

    use super::*;

    fn csv_of(rows: &[Value]) -> String {
        let mut out = Vec::new();
        as_csv(&mut out, || rows.iter().cloned().map(Ok)).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn rows_with_other_fields_share_one_heading() {
        let rows =
            [json!({ "b": { "c": 1 }, "decision": 0 }), json!({ "decision": 1, "a": [1, 2], "b": null })];
        assert_eq!(csv_of(&rows), "decision,a.count,b,b.c\n0,,,1\n1,2,,\n");
    }

    /// P-BAG-EXPORT: Every topic of a recording is exported row by row; cells are counted, and
    /// written only on request.
    #[test]
    fn every_topic_is_exported_with_its_cells_counted() {
        let messages = hostile::recording::messages();
        let mut recorder = Recorder::new(&Context::default(), MonotonicNs(1)).unwrap();
        for message in &messages {
            recorder.on(message.clone(), MonotonicNs(1)).unwrap();
        }
        recorder.finish(MonotonicNs(2)).unwrap();
        let bytes = recorder.bytes();
        let recording = Recording::read(&bytes).unwrap();
        for topic in Channel::ALL.into_iter().filter(|topic| !topic.is_view()) {
            let rows: Vec<Value> =
                super::messages(&recording, &topic.name(), false).map(Result::unwrap).collect();
            assert!(!rows.is_empty() && rows.iter().all(|row| row["logged"] == 1), "{topic:?}: {rows:?}");
            let counted =
                messages.iter().filter(|message| message.topic() == topic).filter_map(|m| match m {
                    RecordedMessage::Policy(policy) => Some(policy.cells.len()),
                    RecordedMessage::Patch(patch) => Some(patch.cells.len()),
                    RecordedMessage::Page(page) => Some(page.cells.len()),
                    _ => None,
                });
            for (row, count) in rows.iter().zip(counted) {
                assert_eq!((row.get("cells"), &row["cell_count"]), (None, &json!(count)), "{topic:?}");
            }
            for row in super::messages(&recording, &topic.name(), true).map(Result::unwrap) {
                let cells = row.get("cells").and_then(Value::as_array);
                assert_eq!(
                    cells.map(|cells| json!(cells.len())),
                    row.get("cell_count").cloned(),
                    "{topic:?}"
                );
            }
            let mut lines = Vec::new();
            as_json(&mut lines, rows.iter().cloned().map(Ok)).unwrap();
            assert_eq!(lines.iter().filter(|byte| **byte == b'\n').count(), rows.len());
            let table = csv_of(&rows);
            assert_eq!(table.lines().count(), 1 + rows.len(), "{topic:?}");
            let headings: Vec<&str> = table.lines().next().unwrap().split(',').collect();
            assert!(headings.contains(&"logged_ns"), "{headings:?}");
            let bare =
                |heading: &&&str| heading.rsplit('.').next().is_some_and(|field| unit(field).is_some());
            assert_eq!(headings.iter().find(bare), None, "{topic:?}: a heading without its unit");
        }
    }
}
