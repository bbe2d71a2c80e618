//! `hopper view` of a recording: its last run on the page of running missions.

use std::path::PathBuf;

use contract::{MonotonicNs, RobotId};
use hopper::commands::view::{ServeArgs, serve};
use monitor::{Event, History, Input, Watcher};
use node::{Exit, Failure};
use recording::{RecordedMessage, Recording};

use crate::bag::{load, open};

/// Arguments of `hopper view` where the path is a recording.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[arg(value_name = "RECORDING")]
    file: PathBuf,
    #[command(flatten)]
    serve: ServeArgs,
}

/// Serves the page of the recording until Ctrl-C.
///
/// # Errors
/// If it cannot be read or holds a malformed message, or the address cannot be had.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let bytes = load(&args.file)?;
    let recording = open(&args.file, &bytes)?;
    serve(history(&recording)?, &args.serve)
}

/// The history that the recorded messages tell; of several runs the last.
///
/// # Errors
/// If a message is malformed.
pub fn history(recording: &Recording<'_>) -> Result<History, Failure> {
    let robot = RobotId(0);
    let (mut history, mut watcher) = (History::new(robot), Watcher::new(robot));
    let mut last = MonotonicNs(0);
    for message in recording.messages() {
        let (now, message) = message.map_err(Failure::usage)?;
        last = now;
        match message {
            RecordedMessage::Brief(brief) => {
                history.on(Input::Brief(&brief), now);
                watcher.on(Event::Brief(brief), now);
            }
            RecordedMessage::State(state) => {
                history.on(Input::State(&state), now);
                watcher.on(Event::State(state), now);
            }
            RecordedMessage::Past(page) => {
                history.on(Input::Past(&page), now);
                watcher.on(Event::Past(page), now);
            }
            RecordedMessage::Patch(patch) => {
                watcher.on(Event::Map(patch.clone()), now);
                history.on(Input::Patch(patch), now);
                history.on(Input::Tick, now);
            }
            RecordedMessage::Page(page) => _ = history.on(Input::Page(&page), now),
            RecordedMessage::Heartbeat(beat) => {
                history.on(Input::Heartbeat(&beat), now);
                watcher.on(Event::Heartbeat(beat), now);
            }
            RecordedMessage::Policy(policy) => _ = history.on(Input::Policy(policy), now),
            RecordedMessage::Pacing(pacing) => _ = history.on(Input::Pacing(pacing), now),
            RecordedMessage::Command(_)
            | RecordedMessage::Control(_)
            | RecordedMessage::Host(_)
            | RecordedMessage::Gap(_) => {}
        }
    }
    history.on(Input::Tick, last);
    if let Some(progress) = watcher.progress(last) {
        history.set_progress(progress);
    }
    Ok(history)
}
