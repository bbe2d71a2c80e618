//! `hopper bag info`: shows what is in a recording.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use contract::message::{Message as _, Request as _};
use contract::{
    Action, Announcement, Brief, Command, Decision, DetailRequest, Digest, MonotonicNs, Record, RunId, State,
    Status, Team,
};
use hopper::stdout::print;
use node::{Exit, Failure};
use recording::{Channel, JsonMessage, RecordedMessage, Recording, SequenceGap, SkippedMessages};
use report::{Format, table};
use serde::Serialize;

use super::{Source, load, open, scenario_of, scenarios, warn_of_skipped};

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
    /// Messages that are left out: those whose channel the file does not define, and those that cannot be decoded.
    without_channel: u64,
    undecodable: u64,
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
    /// Whether every decision that states tell of has its record, whatever states and patches were missed.
    complete: bool,
    status: Option<Status>,
    digest: Option<Digest>,
    /// The journal's digest as it was at the end, if the recording came to its end.
    digest_at_end: Option<String>,
    gaps: Vec<Missing>,
    /// Topics that have no message, though a recording of the mission has some.
    missing_topics: Vec<String>,
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
    /// Topics of which it has messages.
    topics: BTreeSet<String>,
    /// Topics without which its records could not be: of the commands and the routes that they name.
    named: BTreeSet<String>,
}

impl Mission {
    fn is(&self, run: RunId) -> bool {
        self.brief.as_ref().is_some_and(|brief| brief.run == run)
    }

    /// Takes a message on `topic`, in whichever run it is.
    fn on(&mut self, topic: &str, message: RecordedMessage) {
        let run = match &message {
            RecordedMessage::State(state) => state.run,
            RecordedMessage::Patch(patch) => patch.run,
            RecordedMessage::Page(page) => page.run,
            RecordedMessage::Command(command) => command.run,
            RecordedMessage::Past(page) => page.run,
            RecordedMessage::Gap(gap) => {
                let SequenceGap { topic, counted, from, through } = gap.clone();
                return self.gaps.push(Missing { topic, counted, from, through });
            }
            _ => return,
        };
        if !self.is(run) {
            return;
        }
        self.topics.insert(topic.to_owned());
        match message {
            RecordedMessage::State(state) => self.state = Some(state),
            RecordedMessage::Past(page) => page.records.iter().for_each(|record| self.record(record)),
            _ => {}
        }
    }

    fn record(&mut self, record: &Record) {
        self.records.insert(record.decision);
        if !record.origin.is_fallback() {
            self.named.insert(Command::SERVICE.name_of(record.robot));
        }
        if !record.detail.is_none() {
            self.named.insert(DetailRequest::SERVICE.name_of(record.robot));
        }
        if let Action::Announce(_) = record.action {
            self.named.insert(Announcement::SERVICE.name_of(record.robot));
        }
    }

    /// The topics of which every recording of the mission has messages and this one has none. `all` are those of the file.
    fn missing_topics(&self, all: &BTreeMap<String, Topic>) -> Vec<String> {
        let Some(brief) = &self.brief else { return vec![Channel::Brief.name()] };
        let mut need = vec![Channel::State.name(), Channel::Heartbeat.name()];
        // A recorder that came late has the map from pages.
        if !self.topics.contains(&Channel::Snapshot.name()) {
            need.push(Channel::Map.name());
        }
        if self.state.is_some_and(|state| state.decision > Decision(0)) {
            need.push(Channel::Past.name());
        }
        if brief.has_team() {
            need.extend(JsonMessage::topic::<Team>());
        }
        need.extend(self.named.iter().cloned());
        // Messages without a run, or in JSON, are not counted to a mission.
        let has =
            |topic: &String| self.topics.contains(topic) || !is_of_run(topic) && all.contains_key(topic);
        need.retain(|topic| !has(topic));
        need.sort();
        need
    }
}

/// Whether [`Mission::on`] counts the messages of a topic by their runs.
fn is_of_run(topic: &str) -> bool {
    matches!(
        Channel::of(topic),
        Some(Channel::State | Channel::Map | Channel::Snapshot | Channel::Command | Channel::Past)
    )
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
/// If it cannot be read or is none.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let path = &args.source.file;
    let bytes = load(path)?;
    let recording = open(path, &bytes)?;
    let summary = Summary::of(&recording);
    warn_of_skipped(path, &summary.skipped);
    if args.scenario {
        let text = scenario(&recording, &summary)
            .map_err(|why| Failure::new(Exit::Failed, format!("{} {why}", path.display())))?;
        print(text)?;
        return Ok(Exit::Done);
    }
    let info = Info::of(&recording, summary, &path.display().to_string(), bytes.len() as u64);
    match args.format {
        Format::Text => print(&info.text())?,
        Format::Json => print(&format!("{}\n", serde_json::to_string(&info).map_err(Failure::run)?))?,
    }
    Ok(if info.whole && info.undecodable == 0 { Exit::Done } else { Exit::Failed })
}

/// The text of the last mission's scenario, or why it is not known.
fn scenario<'a>(recording: &'a Recording<'_>, summary: &Summary) -> Result<&'a str, String> {
    let texts = scenarios(recording);
    match (&texts[..], summary.mission.brief.as_ref()) {
        ([], _) => Err("keeps no scenario".into()),
        ([text], _) if summary.runs <= 1 => Ok(text),
        (texts, brief) => {
            let of_it = brief.and_then(|brief| scenario_of(recording, brief).ok().flatten());
            let unknown =
                || format!("keeps {} scenarios, none of them known to be of its last mission", texts.len());
            of_it.map(|(text, _)| text).ok_or_else(unknown)
        }
    }
}

/// What the messages of a recording say.
#[derive(Default)]
struct Summary {
    topics: BTreeMap<String, Topic>,
    /// Log times of the first and the last message.
    first: Option<MonotonicNs>,
    last: Option<MonotonicNs>,
    runs: u64,
    /// The last run.
    mission: Mission,
    skipped: SkippedMessages,
}

impl Summary {
    fn of(recording: &Recording<'_>) -> Self {
        let mut summary = Self::default();
        for entry in recording.entries() {
            summary.first.get_or_insert(entry.logged);
            summary.last = Some(entry.logged);
            let topic = summary.topics.entry(entry.topic.clone()).or_default();
            topic.messages += 1;
            topic.bytes += entry.data.len() as u64;
            topic.schema = entry.known.map_or("of others", Channel::schema).into();
            if let Some(error) = entry.undecodable() {
                summary.skipped.add(&error);
                continue;
            }
            match entry.message() {
                Ok(Some(RecordedMessage::Brief(brief))) if !summary.mission.is(brief.run) => {
                    summary.runs += 1;
                    summary.mission = Mission { brief: Some(brief), ..Mission::default() };
                }
                Ok(Some(message)) => summary.mission.on(&entry.topic, message),
                _ => {}
            }
        }
        summary
    }
}

impl Info {
    fn of(recording: &Recording<'_>, summary: Summary, file: &str, bytes: u64) -> Self {
        let Summary { topics, first, last, runs, mission, skipped } = summary;
        let duration_s = first.zip(last).map_or(0.0, |(first, last)| last.since_ns(first) as f64 / 1e9);
        let missing_topics = mission.missing_topics(&topics);
        let with_rate = |(name, topic): (String, Topic)| Topic {
            topic: name,
            hz: if duration_s > 0.0 { topic.messages as f64 / duration_s } else { 0.0 },
            ..topic
        };
        let Mission { brief, state, records, gaps, .. } = mission;
        let of_run =
            recording.metadata_of(brief.as_ref().map(|brief| brief.run), state.map(|state| state.digest));
        let mut metadata = recording.metadata.clone();
        metadata.retain(|name, _| name != "scenario" && !name.starts_with("scenario#"));
        Self {
            file: file.into(),
            bytes,
            whole: recording.is_whole(),
            fault: recording.fault.clone(),
            lost_bytes: recording.lost_bytes(),
            without_channel: recording.without_channel(),
            undecodable: skipped.messages,
            chunks: recording.chunks(),
            duration_s,
            scenario: brief.as_ref().map(|brief| brief.scenario.to_string()),
            seed: of_run.mission("seed").map(str::to_owned),
            version: of_run.recorder("version").map(str::to_owned),
            run: brief.map(|brief| brief.run),
            runs,
            decisions: state.map_or(0, |state| state.decision.0),
            records: records.len() as u64,
            complete: state.is_some_and(|state| records.len() as u64 >= state.decision.0),
            status: state.map(|state| state.status),
            digest: state.map(|state| state.digest),
            digest_at_end: of_run.end("digest").map(str::to_owned),
            gaps,
            missing_topics,
            topics: topics.into_iter().map(with_rate).collect(),
            metadata,
        }
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
        if self.undecodable > 0 {
            line("damaged", &format!("messages left out that cannot be decoded: {}", self.undecodable));
        }
        if self.run.is_none() {
            line("mission", &self.no_mission());
            return text + "\n" + &self.table();
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
        } else if self.gaps.is_empty() && self.missing_topics.is_empty() {
            line("missing", "nothing");
        } else if self.complete && !self.gaps.is_empty() {
            line("missing", "no decision: what queues lost is in hop/past");
        }
        for topic in &self.missing_topics {
            line("missing", &format!("all messages of {topic}"));
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
        text + "\n" + &self.table()
    }

    /// What a file without a mission is.
    fn no_mission(&self) -> String {
        let has_topic = self.topics.iter().any(|topic| topic.topic.starts_with("hop/"));
        match has_topic || self.metadata.contains_key("hopper") {
            true => format!("none: no message of {}, which tells what the mission is", Channel::Brief.name()),
            false => "none: not a recording of Hopper".into(),
        }
    }

    fn table(&self) -> String {
        let row = |topic: &Topic| {
            let Topic { topic, schema, messages, bytes, hz } = topic;
            [topic.clone(), schema.clone(), messages.to_string(), format!("{hz:.1}"), bytes.to_string()]
        };
        let rows: Vec<_> = self.topics.iter().map(row).collect();
        table(["topic", "schema", "messages", "a second", "bytes"], &rows)
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
        let recording = Recording::read(&bytes).unwrap();
        Info::of(&recording, Summary::of(&recording), "a.mcap", bytes.len() as u64)
    }

    /// The messages of the fixtures' mission, its own gap left out.
    fn flown() -> impl Iterator<Item = RecordedMessage> {
        hostile::recording::messages()
            .into_iter()
            .filter(|message| !matches!(message, RecordedMessage::Gap(_)))
    }

    /// The message as one of run `run`.
    fn of(run: RunId, message: RecordedMessage) -> RecordedMessage {
        match message {
            RecordedMessage::Brief(brief) => RecordedMessage::Brief(Brief { run, ..brief }),
            RecordedMessage::State(state) => RecordedMessage::State(State { run, ..state }),
            RecordedMessage::Patch(patch) => RecordedMessage::Patch(contract::MapPatch { run, ..patch }),
            RecordedMessage::Past(page) => RecordedMessage::Past(contract::PastPage { run, ..page }),
            other => other,
        }
    }

    /// P-BAG-LATE: What a late recorder has missed is reported, from the first decision on.
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
        assert_eq!((of("hop/state"), of("hop/map")), (vec![(0, 1)], vec![(1, 2)]));
        assert_eq!((late.decisions, late.records), (whole.decisions, whole.records));
        let text = late.text();
        assert!(text.contains("2 messages of hop/state") && !text.contains("nothing"), "{text}");
        assert!(late.complete && text.contains("missing     no decision"), "{text}");
    }

    /// The mission with a second robot, which looks ahead for the first.
    fn with_another(brief: &Brief) -> Brief {
        let first = brief.robots[0];
        let goal = contract::Goal::LookAhead(contract::LookAhead {});
        let robots = [first, contract::Robot { goal, required: false, ..first }];
        Brief { robots: contract::Robots::new(&robots).unwrap(), ..*brief }
    }

    /// P-BAG-TOPICS: A topic without messages, of which every recording of such a mission has some,
    /// is reported as missing.
    #[test]
    fn a_topic_without_messages_is_named_as_missing() {
        assert_eq!(told(flown()).missing_topics, [""; 0]);
        for channel in [Channel::State, Channel::Heartbeat, Channel::Command] {
            let without = told(flown().filter(|message| message.topic() != channel));
            assert_eq!(without.missing_topics, [channel.name()]);
            let need = format!("missing     all messages of {}", channel.name());
            assert!(without.text().contains(&need), "{}", without.text());
        }
        let is_map = |message: &RecordedMessage| {
            matches!(message, RecordedMessage::Patch(_) | RecordedMessage::Page(_))
        };
        let without = told(flown().filter(|message| !is_map(message)));
        assert_eq!(without.missing_topics, ["hop/map"]);
        let without = told(flown().filter(|message| message.topic() != Channel::Past));
        assert_eq!(without.missing_topics, ["hop/past"]);
        // Of a late recorder, which has the map from pages.
        let late = told(flown().filter(|message| message.topic() != Channel::Map));
        assert_eq!(late.missing_topics, [""; 0]);
        let team = told(flown().map(|message| match message {
            RecordedMessage::Brief(brief) => RecordedMessage::Brief(with_another(&brief)),
            other => other,
        }));
        assert_eq!(team.missing_topics, ["hop/team"]);
        let nothing = told(flown().filter(|message| message.topic() != Channel::Brief));
        assert_eq!(nothing.missing_topics, ["hop/brief"]);
        assert!(nothing.text().contains("mission     none: no message of hop/brief"), "{}", nothing.text());
    }

    /// P-BAG-RUNS: If a recording holds several missions, the report is on the last, and says so.
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
