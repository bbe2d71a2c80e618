//! What `--record` adds to the monitor: ports of its own, and the file.
//!
//! The recording itself is made by [`recording::Recorder`]; here messages are read and bytes are appended. It has
//! ports of its own so that it reads everything, whatever else of the monitor passes over. It looks the more
//! often the fuller its queues were, so that quick missions are whole and slow ones cost little.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use contract::{Decision, MonotonicNs, Refusal, RobotId, RunId};
use node::host::{self, Load};
use node::peer::refuse;
use node::{
    BriefReader, CommandReader, ControlReader, Exit, Failure, HeartbeatReader, MapReader, Node, NodeError,
    PastClient, PolicyReader, SnapshotClient, StateReader, TempoReader,
};
use recording::{Context, MachineLoad, RecordedMessage as Message, Requests};

/// Longest and shortest pause between two looks.
const PERIODS: [Duration; 2] = [Duration::from_millis(20), Duration::from_millis(1)];

/// Messages of one look at which the shortest queues, those of patches and commands, are a quarter full.
const MANY: usize = 4;

/// Pause between two looks at the machine's load, nanoseconds.
const HOST_PERIOD_NS: u64 = 500_000_000;

/// What to record, and what only the caller knows of it.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Recording")]
pub struct RecordArgs {
    /// Record every public message as MCAP, readable by Foxglove, Rerun, and Python's mcap.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Ask planners for their policies and record them too, which costs a planner time at every decision.
    #[arg(long, requires = "record")]
    pub record_policies: bool,
}

/// What only whoever flies the mission knows: kept in the recording, seen by nobody else.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct RecordNotes {
    /// Scenario file to keep in the recording: no public message tells it.
    #[arg(long, requires = "record", value_name = "FILE", help_heading = "Recording")]
    pub record_scenario: Option<PathBuf>,
    /// What else to note in the recording, e.g. seed=7 or pace=20.
    #[arg(long, requires = "record", value_name = "KEY=VALUE", value_parser = note, help_heading = "Recording")]
    pub record_note: Vec<(String, String)>,
}

fn note(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or_else(|| format!("a note needs KEY=VALUE, got {text:?}"))?;
    Ok((key.into(), value.into()))
}

/// Records until the mission ends.
pub struct Recorder {
    engine: recording::Recorder,
    file: File,
    path: PathBuf,
    ports: Ports,
    host: (Load, MonotonicNs),
    cores: u32,
    period: Duration,
    failed: bool,
}

struct Ports {
    briefs: BriefReader,
    states: StateReader,
    maps: MapReader,
    commands: CommandReader,
    beats: HeartbeatReader,
    controls: ControlReader,
    tempos: TempoReader,
    policies: Option<PolicyReader>,
    past: PastClient,
    snapshots: SnapshotClient,
}

impl Recorder {
    /// Opens ports and file at `now`; `None` unless a recording was asked for. `is_again` is true of a process
    /// that may have been restarted: a file that is there already is then left as it is, and the recording goes
    /// on in FILE-2, FILE-3, …
    ///
    /// # Errors
    /// If a port cannot be had, or the file is there already or cannot be made.
    pub fn open(
        (args, notes): (&RecordArgs, &RecordNotes),
        node: &mut Node,
        is_again: bool,
        now: MonotonicNs,
    ) -> Result<Option<Self>, Failure> {
        let Some(path) = &args.record else { return Ok(None) };
        let context = context(notes, node, now)?;
        let engine = recording::Recorder::new(&context, now).map_err(Failure::run)?;
        // The ports before the file: who cannot record leaves no file behind.
        let ports = Ports::open(node, args.record_policies)?;
        let (mut file, path) = create(path, is_again)?;
        file.write_all(&engine.bytes()).map_err(|error| unwritten(&path, &error))?;
        tracing::info!("recording to {}", path.display());
        Ok(Some(Self {
            engine,
            file,
            path,
            ports,
            host: (host::load(), now),
            cores: host::cores(),
            period: PERIODS[0],
            failed: false,
        }))
    }

    /// How long to wait for the next look.
    #[must_use]
    pub fn period(&self) -> Duration {
        self.period
    }

    /// Records what came since, and writes what is due at `now`. An error of the file ends the recording, and not
    /// the monitor.
    ///
    /// # Errors
    /// If there is no room to ask.
    pub fn turn(&mut self, now: MonotonicNs) -> Result<(), Failure> {
        if self.failed {
            return Ok(());
        }
        let (mut messages, most) = self.ports.receive();
        messages.extend(self.host(now, HOST_PERIOD_NS));
        self.period = if most >= MANY { PERIODS[1] } else { PERIODS[0].min(self.period * 2) };
        let mut wanted = Requests::default();
        for message in messages.into_iter().map(Some).chain([None]) {
            let more = match message {
                Some(message) => self.engine.on(message, now),
                None => self.engine.tick(now),
            };
            match more {
                Ok(more) => wanted = wanted.or(more),
                Err(error) => {
                    self.fail(&error);
                    return Ok(());
                }
            }
        }
        self.append();
        if let Some(request) = wanted.past {
            self.ports.past.request(&request)?;
        }
        if let Some(request) = wanted.map {
            self.ports.snapshots.request(&request)?;
        }
        Ok(())
    }

    /// Whether the record of every decision of `run` before `decision` is in the file, or never will be.
    #[must_use]
    pub fn is_whole_until(&self, run: RunId, decision: Decision) -> bool {
        self.failed || self.engine.is_whole_until(run, decision)
    }

    /// Records what came since, ends the file at `now`, and says how it went.
    ///
    /// # Errors
    /// If the file could not be written.
    pub fn finish(&mut self, now: MonotonicNs) -> Result<(), Failure> {
        // What could not be asked for any more does not keep the file from its end.
        let turned = self.turn(now);
        let last = self.host(now, 0);
        if !self.failed
            && let Err(error) = last
                .map_or(Ok(Requests::default()), |host| self.engine.on(host, now))
                .and_then(|_| self.engine.finish(now))
        {
            self.fail(&error);
        }
        self.append();
        for (topic, missing) in self.engine.missing() {
            tracing::warn!("{missing} messages of {topic} did not reach the recording");
        }
        if self.failed {
            let message = format!("{} ends early: see above", self.path.display());
            return Err(Failure::new(Exit::Failed, message));
        }
        turned
    }

    fn append(&mut self) {
        let bytes = self.engine.bytes();
        if let Err(error) = self.file.write_all(&bytes)
            && !self.failed
        {
            self.fail(&error);
        }
    }

    fn fail(&mut self, error: &dyn std::fmt::Display) {
        self.failed = true;
        tracing::error!(
            "the recording ends here: {}: {error}; what is written can be had by `hopper bag recover`",
            self.path.display()
        );
    }

    /// How busy the machine was since the last look, if that is at least so long ago.
    fn host(&mut self, now: MonotonicNs, least_ns: u64) -> Option<Message> {
        let (before, since) = self.host;
        if now.since_ns(since) < least_ns {
            return None;
        }
        let load = host::load();
        self.host = (load, now);
        Some(Message::Host(MachineLoad {
            since,
            until: now,
            busy: load.busy_since(&before),
            load_1min: load.load_1min,
            cores: self.cores,
        }))
    }
}

impl Ports {
    fn open(node: &mut Node, with_policies: bool) -> Result<Self, NodeError> {
        let robot = RobotId(0);
        Ok(Self {
            briefs: node.brief_reader()?,
            states: node.state_reader(robot)?,
            maps: node.map_reader(robot)?,
            commands: node.command_reader(robot)?,
            beats: node.heartbeat_reader()?,
            controls: node.control_reader(robot)?,
            tempos: node.tempo_reader(robot)?,
            policies: with_policies.then(|| node.policy_reader(robot)).transpose()?,
            past: node.past_client()?,
            snapshots: node.snapshot_client(robot)?,
        })
    }

    /// Everything that came, in the order of publication, and how many of one topic came at most.
    fn receive(&mut self) -> (Vec<Message>, usize) {
        // The page before the patches: with it come all patches published before it was made.
        let page = self.snapshots.receive().and_then(known).map(Message::Page);
        // States before patches, so that no patch comes without the state it belongs to.
        let mut told: Vec<Message> = self.states.drain().filter_map(known).map(Message::State).collect();
        let states = told.len();
        told.extend(self.maps.drain().filter_map(known).map(Message::Patch));
        let maps = told.len() - states;
        told.extend(self.commands.drain().filter_map(known).map(Message::Command));
        let commands = told.len() - states - maps;
        // Stable: what was published at one moment stays in the order of its topics.
        told.sort_by_key(Message::published);
        let mut messages: Vec<Message> =
            self.beats.drain().filter_map(known).map(Message::Heartbeat).collect();
        messages.extend(self.briefs.drain().filter_map(known).map(Message::Brief));
        messages.extend(self.tempos.drain().filter_map(known).map(Message::Tempo));
        messages.extend(self.controls.drain().filter_map(known).map(Message::Control));
        messages.append(&mut told);
        messages.extend(page);
        messages.extend(self.past.receive().and_then(known).map(Message::Past));
        messages.extend(
            self.policies.iter_mut().filter_map(|p| p.newest()).filter_map(known).map(Message::Policy),
        );
        (messages, maps.max(commands).max(states / 4))
    }
}

/// A message; a malformed one is told and dropped.
fn known<T>(message: Result<T, Refusal>) -> Option<T> {
    message.inspect_err(refuse).ok()
}

/// What is known before the first message.
fn context(notes: &RecordNotes, node: &Node, now: MonotonicNs) -> Result<Context, Failure> {
    let mut told = BTreeMap::from(
        [
            ("format", "1".into()),
            ("version", node::version().to_string()),
            ("instance", node.instance().name().to_owned()),
            ("clock", "CLOCK_MONOTONIC of the host, nanoseconds".into()),
            ("started_ns", now.0.to_string()),
            ("started_unix_s", format!("{:.6}", host::unix_time_s())),
            ("processor", host::processor()),
            ("cores", host::cores().to_string()),
            ("operating_system", host::operating_system()),
        ]
        .map(|(key, value): (&str, String)| (key.to_owned(), value)),
    );
    told.extend(notes.record_note.iter().cloned());
    let mut context = Context::from([("hopper".to_owned(), told)]);
    if let Some(path) = &notes.record_scenario {
        let text = std::fs::read_to_string(path).map_err(|error| {
            Failure::new(Exit::Usage, format!("--record-scenario {}: {error}", path.display()))
        })?;
        context.insert("scenario".into(), BTreeMap::from([("toml".to_owned(), text)]));
    }
    Ok(context)
}

/// FILE, FILE-2, FILE-3, …: where a recording goes, and where it goes on after each kill.
pub fn files(path: &Path) -> impl Iterator<Item = PathBuf> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let extension = path.extension().map(|text| format!(".{}", text.to_string_lossy())).unwrap_or_default();
    let first = path.to_owned();
    let others = first.clone();
    let numbered = (2..).map(move |number: u64| others.with_file_name(format!("{stem}-{number}{extension}")));
    std::iter::once(first).chain(numbered)
}

/// A new file for its owner only, and its path.
fn create(path: &Path, is_again: bool) -> Result<(File, PathBuf), Failure> {
    for path in files(path) {
        match OpenOptions::new().write(true).create_new(true).mode(0o600).open(&path) {
            Ok(file) => return Ok((file, path)),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists && is_again => {}
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {
                let message = format!("--record {} is there already: name another file", path.display());
                return Err(Failure::new(Exit::Usage, message));
            }
            Err(error) => {
                let message = format!("--record {} cannot be made: {error}", path.display());
                return Err(Failure::new(Exit::Usage, message));
            }
        }
    }
    unreachable!("numbers do not end")
}

fn unwritten(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Exit::Failed, format!("{} cannot be written: {error}", path.display()))
}
