//! The file of a recording, and the machine's load beside it.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use contract::MonotonicNs;
use monitor::record_args::{RecordArgs, RecordNotes, files};
use node::host::{self, Load};
use node::{Exit, Failure, Node};
use recording::{Context, MachineLoad};

use crate::{Recorder, RecorderPorts, Sink};

/// A file of the user's, and what the machine did meanwhile.
struct RecordingFile {
    file: File,
    path: PathBuf,
    host: (Load, MonotonicNs),
    cores: u32,
}

/// Opens ports and file. `is_again` is true of a process that may have been restarted: a file that is there already is
/// then left as it is, and the recording goes on in FILE-2, FILE-3, …
///
/// # Errors
/// If a port cannot be had, or the file is there already or cannot be made.
///
/// # Panics
/// If no recording was asked for.
pub fn open(
    args: &RecordArgs,
    notes: &RecordNotes,
    node: &mut Node,
    is_again: bool,
) -> Result<Box<dyn monitor::process::Observer<Node>>, Failure> {
    let path = args.record.as_ref().expect("a recording was asked for");
    let now = Node::now();
    let context = context(notes, node, now)?;
    // The ports before the file: a process that cannot record leaves no file behind.
    let ports = RecorderPorts::open(node, args.record_policies)?;
    let (file, path) = create(path, is_again)?;
    tracing::info!("recording to {}", path.display());
    let sink = RecordingFile { file, path, host: (host::load(), now), cores: host::cores() };
    Ok(Box::new(Recorder::begin(&context, ports, sink, now)?))
}

impl Write for RecordingFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

impl Sink for RecordingFile {
    fn name(&self) -> String {
        self.path.display().to_string()
    }

    fn load(&mut self, now: MonotonicNs, least_ns: u64) -> Option<MachineLoad> {
        let (before, since) = self.host;
        if now.since_ns(since) < least_ns {
            return None;
        }
        let load = host::load();
        self.host = (load, now);
        let busy = load.busy_since(&before);
        Some(MachineLoad { since, until: now, busy, load_1min: load.load_1min, cores: self.cores })
    }
}

/// What is known before the first message.
fn context(notes: &RecordNotes, node: &Node, now: MonotonicNs) -> Result<Context, Failure> {
    let mut known = BTreeMap::from(
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
    known.extend(notes.record_note.iter().cloned());
    let mut context = Context::from([("hopper".to_owned(), known)]);
    if let Some(path) = &notes.record_scenario {
        let text = std::fs::read_to_string(path).map_err(|error| {
            Failure::new(Exit::Usage, format!("--record-scenario {}: {error}", path.display()))
        })?;
        context.insert("scenario".into(), BTreeMap::from([("toml".to_owned(), text)]));
    }
    Ok(context)
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
