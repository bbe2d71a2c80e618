//! `hopper bag info`: shows what is in a recording.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use contract::{Brief, Decision, Digest, RunId, State, Status};
use hopper::stdout::print;
use node::{Exit, Failure};
use recording::{RecordedMessage, Recording, RecordingError};
use report::{Format, table};
use serde::Serialize;

use super::{Source, at_fault, load, open};

/// Gaps that the text shows; the JSON has all.
const GAPS_SHOWN: usize = 10;

/// Arguments of `hopper bag info`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    source: Source,
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
    /// Print the scenario that the recording keeps, and nothing else.
    #[arg(long, conflicts_with = "format")]
    scenario: bool,
}

/// The answer; field names are those of the JSON. If the recording holds several missions, fields about the mission
/// are those of the last.
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
    /// The last run, and how many there are.
    run: Option<RunId>,
    runs: u64,
    /// Decisions told by the states; those whose record is there; the last state's status and digest.
    decisions: u64,
    records: u64,
    /// Whether every one of these decisions has its record, whatever states and patches were missed.
    complete: bool,
    status: Option<Status>,
    digest: Option<Digest>,
    /// The journal's digest as it was at the end, if the recording came to its end.
    digest_at_end: Option<String>,
    gaps: Vec<Missing>,
    topics: Vec<Topic>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
}

/// What is told of one run.
#[derive(Default)]
struct Mission {
    brief: Option<Brief>,
    state: Option<State>,
    records: BTreeSet<Decision>,
    gaps: Vec<Missing>,
}

impl Mission {
    fn is(&self, run: RunId) -> bool {
        self.brief.is_some_and(|brief| brief.run == run)
    }
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

/// Shows what is in the recording.
///
/// # Errors
/// If it cannot be read, is none, or holds a malformed message.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let path = &args.source.file;
    let bytes = load(path)?;
    let recording = open(path, &bytes)?;
    if args.scenario {
        let Some(text) = recording.metadata_entry("scenario", "toml") else {
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
        let mut runs = 0;
        let mut mission = Mission::default();
        for entry in recording.entries() {
            first.get_or_insert(entry.logged);
            last = Some(entry.logged);
            let topic = topics.entry(entry.topic.clone()).or_default();
            topic.messages += 1;
            topic.bytes += entry.data.len() as u64;
            topic.schema = entry.known.map_or("of others", recording::Channel::schema).into();
            match entry.message()? {
                Some(RecordedMessage::Brief(told)) if !mission.is(told.run) => {
                    runs += 1;
                    mission = Mission { brief: Some(told), ..Mission::default() };
                }
                Some(RecordedMessage::State(told)) if mission.is(told.run) => mission.state = Some(told),
                Some(RecordedMessage::Past(page)) if mission.is(page.run) => {
                    mission.records.extend(page.records.iter().map(|record| record.decision));
                }
                Some(RecordedMessage::Gap(gap)) => mission.gaps.push(Missing {
                    topic: gap.topic,
                    counted: gap.counted,
                    from: gap.from,
                    through: gap.through,
                }),
                _ => {}
            }
        }
        let duration_s = first.zip(last).map_or(0.0, |(first, last)| last.since_ns(first) as f64 / 1e9);
        let told = |key| recording.metadata_entry("hopper", key).map(str::to_owned);
        let with_rate = |(name, topic): (String, Topic)| Topic {
            topic: name,
            hz: if duration_s > 0.0 { topic.messages as f64 / duration_s } else { 0.0 },
            ..topic
        };
        let Mission { brief, state, records, gaps } = mission;
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
            runs,
            decisions: state.map_or(0, |state| state.decision.0),
            records: records.len() as u64,
            complete: state.is_some_and(|state| records.len() as u64 >= state.decision.0),
            status: state.map(|state| state.status),
            digest: state.map(|state| state.digest),
            digest_at_end: recording.metadata_entry("end", "digest").map(str::to_owned),
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
        let run = self.run.map_or_else(|| "unknown".into(), |run| run.to_string());
        match self.runs {
            0 | 1 => line("run", &run),
            runs => line("run", &format!("{run}, the last of {runs}; what follows is of this one")),
        }
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
        } else if self.complete {
            line("missing", "no decision: what queues lost is in hop/past");
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

#[cfg(test)]
mod tests {
    use contract::{MonotonicNs, RunId};
    use recording::{Context, Recorder};

    use super::*;

    /// What `hopper bag info` says of a recording of `messages`.
    fn told(messages: impl IntoIterator<Item = RecordedMessage>) -> Info {
        let mut now = MonotonicNs(1_000);
        let mut recorder = Recorder::new(&Context::default(), now).unwrap();
        for message in messages {
            now = now.plus_ns(1_000);
            recorder.on(message, now).unwrap();
        }
        recorder.finish(now).unwrap();
        let bytes = recorder.bytes();
        Info::of(&Recording::read(&bytes).unwrap(), "a.mcap", bytes.len() as u64).unwrap()
    }

    /// The messages of the fixtures' mission, its own gap left out.
    fn flown() -> impl Iterator<Item = RecordedMessage> {
        hostile::recording::messages()
            .into_iter()
            .filter(|message| !matches!(message, RecordedMessage::Gap(_)))
    }

    /// The same as of another run.
    fn of(run: RunId, message: RecordedMessage) -> RecordedMessage {
        match message {
            RecordedMessage::Brief(brief) => RecordedMessage::Brief(Brief { run, ..brief }),
            RecordedMessage::State(state) => RecordedMessage::State(State { run, ..state }),
            RecordedMessage::Patch(patch) => RecordedMessage::Patch(contract::MapPatch { run, ..patch }),
            RecordedMessage::Past(page) => RecordedMessage::Past(contract::PastPage { run, ..page }),
            other => other,
        }
    }

    /// P-BAG-LATE: states and patches of before the recorder's time are missing, and told to be.
    #[test]
    fn a_recording_begun_late_tells_what_was_before_it() {
        let whole = told(flown());
        assert!(whole.gaps.is_empty() && whole.text().contains("missing     nothing"), "{}", whole.text());
        let late = told(flown().filter(|message| match message {
            RecordedMessage::State(state) => state.decision >= Decision(2),
            RecordedMessage::Patch(patch) => patch.through >= Decision(2),
            _ => true,
        }));
        let of = |topic: &str| {
            let gaps = late.gaps.iter().filter(|gap| gap.topic == topic);
            gaps.map(|gap| (gap.from, gap.through)).collect::<Vec<_>>()
        };
        assert_eq!((of("hop/r0/state"), of("hop/r0/map")), (vec![(0, 1)], vec![(1, 2)]));
        assert_eq!((late.decisions, late.records), (whole.decisions, whole.records));
        let text = late.text();
        assert!(text.contains("2 messages of hop/r0/state") && !text.contains("nothing"), "{text}");
        assert!(late.complete && text.contains("missing     no decision"), "{text}");
    }

    /// P-BAG-RUNS: of several missions the last is told of, and nothing of those before is counted to it.
    #[test]
    fn of_several_missions_the_last_is_told_of() {
        let one = told(flown());
        let run = RunId(one.run.unwrap().0 + 1);
        // The second is cut short and has no records; a straggler of the first comes late.
        let cut = flown().filter(|message| match message {
            RecordedMessage::State(state) => state.decision <= Decision(1),
            RecordedMessage::Patch(_) | RecordedMessage::Past(_) => false,
            _ => true,
        });
        let straggler = flown().filter(|message| matches!(message, RecordedMessage::State(_))).last();
        let missed =
            flown().filter(|message| !matches!(message, RecordedMessage::State(s) if s.decision.0 == 1));
        let two = told(missed.chain(cut.map(|message| of(run, message))).chain(straggler));
        assert_eq!((one.runs, two.runs, two.run), (1, 2, Some(run)));
        assert_eq!((two.decisions, two.records, two.status), (1, 0, Some(Status::Underway)));
        assert!(two.gaps.is_empty(), "{:?}", two.gaps);
        assert!(
            two.text().contains("the last of 2") && two.text().contains("records of 1 decisions"),
            "{}",
            two.text()
        );
    }
}
