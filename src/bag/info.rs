//! `hopper bag info`: what is in a recording.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use contract::{Decision, Digest, RunId, Status};
use node::{Exit, Failure};
use recording::{Message, Recording, RecordingError};
use report::{Format, table};
use serde::Serialize;

use super::{Source, at_fault, load, open, print};

/// Gaps that the text shows; the JSON has all.
const GAPS_SHOWN: usize = 10;

/// Arguments of `hopper bag info`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    source: Source,
    /// Form of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
    /// Print the scenario that the recording keeps, and nothing else.
    #[arg(long, conflicts_with = "format")]
    scenario: bool,
}

/// What a recording holds. The names are those of the JSON.
#[derive(Debug, Serialize)]
struct Info {
    file: String,
    bytes: u64,
    /// Whether it was ended as it should, and is all there.
    whole: bool,
    /// What is wrong with it, and the bytes that are lost by that.
    fault: Option<String>,
    lost_bytes: u64,
    chunks: usize,
    /// First to last message, seconds.
    duration_s: f64,
    scenario: Option<String>,
    seed: Option<String>,
    version: Option<String>,
    run: Option<RunId>,
    /// Decisions told by the states; those whose record is there; the last state's status and digest.
    decisions: u64,
    records: u64,
    status: Option<Status>,
    digest: Option<Digest>,
    /// The journal's digest as it was at the end, if the recording came to its end.
    digest_at_end: Option<String>,
    gaps: Vec<Missing>,
    topics: Vec<Topic>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
}

/// Messages that did not reach the recorder.
#[derive(Debug, Serialize)]
struct Missing {
    topic: String,
    counted: String,
    from: u64,
    through: u64,
}

#[derive(Debug, Default, Serialize)]
struct Topic {
    topic: String,
    schema: String,
    messages: u64,
    bytes: u64,
    /// Mean rate over the recording.
    hz: f64,
}

/// Tells what is in the recording.
///
/// # Errors
/// If it cannot be read, is none, or holds a malformed message.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let path = &args.source.file;
    let bytes = load(path)?;
    let recording = open(path, &bytes)?;
    if args.scenario {
        let Some(text) = recording.told("scenario", "toml") else {
            return Err(Failure::new(Exit::Failed, format!("{} keeps no scenario", path.display())));
        };
        print(text)?;
        return Ok(Exit::Done);
    }
    let info = Info::of(&recording, &path.display().to_string(), bytes.len() as u64)
        .map_err(|error| at_fault(path, &error))?;
    match args.format {
        Format::Text => print(&info.text())?,
        Format::Json => print(&format!("{}\n", serde_json::to_string(&info).map_err(Failure::run)?))?,
    }
    Ok(if info.whole { Exit::Done } else { Exit::Failed })
}

impl Info {
    fn of(recording: &Recording<'_>, file: &str, bytes: u64) -> Result<Self, RecordingError> {
        let mut topics = BTreeMap::<String, Topic>::new();
        let (mut first, mut last) = (None, None);
        let (mut state, mut brief) = (None, None);
        let (mut records, mut gaps) = (std::collections::BTreeSet::<Decision>::new(), Vec::new());
        for entry in recording.entries() {
            first.get_or_insert(entry.logged);
            last = Some(entry.logged);
            let topic = topics.entry(entry.topic.clone()).or_default();
            topic.messages += 1;
            topic.bytes += entry.data.len() as u64;
            topic.schema = entry.known.map_or("of others", recording::Topic::schema).into();
            match entry.message()? {
                Some(Message::Brief(told)) => brief = Some(told),
                Some(Message::State(told)) => state = Some(told),
                Some(Message::Past(page)) => {
                    records.extend(page.records.iter().map(|record| record.decision))
                }
                Some(Message::Gap(gap)) => gaps.push(Missing {
                    topic: gap.topic,
                    counted: gap.counted,
                    from: gap.from,
                    through: gap.through,
                }),
                _ => {}
            }
        }
        let duration_s = first.zip(last).map_or(0.0, |(first, last)| last.since_ns(first) as f64 / 1e9);
        let told = |key| recording.told("hopper", key).map(str::to_owned);
        let with_rate = |(name, topic): (String, Topic)| Topic {
            topic: name,
            hz: if duration_s > 0.0 { topic.messages as f64 / duration_s } else { 0.0 },
            ..topic
        };
        let mut metadata = recording.metadata.clone();
        metadata.remove("scenario");
        Ok(Self {
            file: file.into(),
            bytes,
            whole: recording.is_whole(),
            fault: recording.fault.clone(),
            lost_bytes: recording.lost_bytes(),
            chunks: recording.chunks(),
            duration_s,
            scenario: brief.map(|brief| brief.scenario.to_string()),
            seed: told("seed"),
            version: told("version"),
            run: brief.map(|brief| brief.run),
            decisions: state.map_or(0, |state| state.decision.0),
            records: records.len() as u64,
            status: state.map(|state| state.status),
            digest: state.map(|state| state.digest),
            digest_at_end: recording.told("end", "digest").map(str::to_owned),
            gaps,
            topics: topics.into_iter().map(with_rate).collect(),
            metadata,
        })
    }

    /// Gaps, and the messages in them, by topic.
    fn missing(&self) -> BTreeMap<&str, (u64, u64)> {
        let mut missing = BTreeMap::<_, (u64, u64)>::new();
        for gap in &self.gaps {
            let (gaps, messages) = missing.entry(gap.topic.as_str()).or_default();
            *gaps += 1;
            *messages = messages.saturating_add((gap.through - gap.from).saturating_add(1));
        }
        missing
    }

    fn text(&self) -> String {
        let or_unknown = |text: &Option<String>| text.clone().unwrap_or_else(|| "unknown".into());
        let mut text = String::new();
        let mut line = |name: &str, value: &str| {
            let _ = writeln!(text, "{name:<12}{value}");
        };
        line("file", &format!("{}, {} bytes in {} chunks", self.file, self.bytes, self.chunks));
        match &self.fault {
            None => line("whole", "yes"),
            Some(fault) => line("whole", &format!("no: {fault}; {} bytes are lost", self.lost_bytes)),
        }
        line("scenario", &format!("{}, seed {}", or_unknown(&self.scenario), or_unknown(&self.seed)));
        line("version", &or_unknown(&self.version));
        line("run", &self.run.map_or_else(|| "unknown".into(), |run| run.to_string()));
        line("time", &format!("{:.3} s", self.duration_s));
        let status = self.status.map_or("unknown", Status::as_str);
        line(
            "mission",
            &format!("{status} after {} decisions, {} with records", self.decisions, self.records),
        );
        line("digest", &self.digest.map_or_else(|| "unknown".into(), |digest| digest.to_string()));
        let unrecorded = self.decisions.saturating_sub(self.records);
        if unrecorded > 0 {
            line("missing", &format!("the records of {unrecorded} decisions"));
        } else if self.gaps.is_empty() {
            line("missing", "nothing");
        }
        for (topic, (gaps, messages)) in self.missing() {
            line("missing", &format!("{messages} messages of {topic}, in {gaps} gaps"));
        }
        for gap in self.gaps.iter().take(GAPS_SHOWN) {
            line("", &format!("{} {} to {} of {}", gap.counted, gap.from, gap.through, gap.topic));
        }
        if self.gaps.len() > GAPS_SHOWN {
            line("", "and so on: --format json has all gaps");
        }
        let row = |topic: &Topic| {
            let Topic { topic, schema, messages, bytes, hz } = topic;
            [topic.clone(), schema.clone(), messages.to_string(), format!("{hz:.1}"), bytes.to_string()]
        };
        let rows: Vec<_> = self.topics.iter().map(row).collect();
        text + "\n" + &table(["topic", "schema", "messages", "a second", "bytes"], &rows)
    }
}
