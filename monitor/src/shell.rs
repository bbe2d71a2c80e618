//! The monitor process: shared memory, clock and standard error around the [`Watcher`].
//!
//! It is never woken by a message: it looks twenty times a second, so that watching costs the watched
//! nothing, and fills what it missed from `hop/past`.

use std::time::Duration;

use contract::{Name, RobotId, Role};
use node::peer::{Attendance, PeerArgs, TICK};
use node::{Exit, Failure, Instance, Node, crash_point};

use crate::recorder::{RecordArgs, RecordNotes, Recorder};
use crate::{Display, Effect, Event, Watcher};

/// Points at which a test may kill this process: see [`node::crash_point`].
pub const CRASH_POINTS: &[&str] = &["monitor.joined", "monitor.state_received"];

/// How often the monitor looks.
const PERIOD: Duration = Duration::from_millis(50);

/// Arguments of `monitor` and of `hopper monitor`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    peer: PeerArgs,
    /// Print the last progress as one JSON object on standard output when the mission ends.
    #[arg(long, default_value = "text")]
    format: report::Format,
    #[command(flatten)]
    record: RecordArgs,
    #[command(flatten)]
    notes: RecordNotes,
}

/// Runs the process until the mission ends.
///
/// # Errors
/// If shared memory fails, or nobody came within `--wait`.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let robot = RobotId(0);
    let instance = Instance::new(&args.peer.instance)?;
    let mut node = Node::join(&instance, Role::Monitor, Name::NONE)?;
    if args.peer.lifeline {
        node.hold_lifeline();
    }
    let mut briefs = node.brief_reader()?;
    let mut states = node.state_reader(robot)?;
    let mut maps = node.map_reader(robot)?;
    let mut past = node.past_client()?;
    let recording = (&args.record, &args.notes);
    let mut recorder = Recorder::open(recording, &mut node, args.peer.lifeline, Node::now())?;
    let finish = |recorder: Option<Recorder>, exit| match recorder {
        Some(mut recorder) => recorder.finish(exit, Node::now()),
        None => Ok(exit),
    };
    crash_point("monitor.joined");
    tracing::info!("joined instance {:?}", args.peer.instance);

    let mut watcher = Watcher::new(robot);
    let mut display = Display::on_stderr();
    let mut attendance = Attendance::new(&args.peer, &instance);
    loop {
        let period = if past.is_waiting() { TICK } else { PERIOD };
        node.wait(recorder.as_ref().map_or(period, |recorder| recorder.period().min(period)));
        if node.stop_requested().is_some() {
            display.finish();
            return finish(recorder, Exit::Interrupted);
        }
        recorder.as_mut().map_or(Ok(()), |recorder| recorder.turn(Node::now()))?;
        let mut events: Vec<Event> = Vec::new();
        for beat in node.heartbeats() {
            if beat.as_ref().is_ok_and(|beat| !attendance.hear(beat)) {
                continue;
            }
            events.push(heard(beat, Event::Heartbeat));
        }
        events.extend(briefs.newest().map(|brief| heard(brief, Event::Brief)));
        // The map first: the mission may end with the last of these states.
        events.extend(maps.newest().map(|map| heard(map, Event::Map)));
        for state in states.drain() {
            crash_point("monitor.state_received");
            events.push(heard(state, Event::State));
        }
        while let Some(page) = past.receive() {
            events.push(heard(page, Event::Past));
        }
        events.push(Event::Tick);
        for event in events {
            for effect in watcher.on(event, Node::now()) {
                match effect {
                    Effect::RequestPast(request) => past.request(&request)?,
                    Effect::Progress(progress) => display.show(&progress, Node::now()),
                    Effect::Finished(status) => {
                        display.finish();
                        print(&watcher, args.format)?;
                        attendance.mission_ended(status);
                    }
                }
            }
        }
        let seen = recorder.as_ref().map_or(watcher.seen(), |recorder| recorder.seen(watcher.seen()));
        if attendance.close_turn(&mut node, seen, watcher.waits_for())? {
            return finish(recorder, Exit::Done);
        }
    }
}

/// A message as the watcher hears it; a malformed one is counted there.
fn heard<T>(message: Result<T, contract::Refusal>, event: impl Fn(T) -> Event) -> Event {
    message.map_or_else(Event::Refused, event)
}

/// The last progress on standard output, for programs.
fn print(watcher: &Watcher, format: report::Format) -> Result<(), Failure> {
    use std::io::Write;
    let (report::Format::Json, Some(progress)) = (format, watcher.progress(Node::now())) else {
        return Ok(());
    };
    let text = serde_json::to_string(&progress).map_err(Failure::run)?;
    writeln!(std::io::stdout(), "{text}").map_err(Failure::run)
}
