//! What only shows between processes: death, signals, lifelines.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::{CommandExt as _, ExitStatusExt};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::samples::{Own, ROBOT, eventually, state};
use contract::{PastRequest, Role, State, TruthRequest};
use node::inspect::{NodeHealth, inspect};
use node::{Cleaned, Exit, Instance, Joining, Node, NodeError, crash_point};
use process::{Ports, Reader as _, Writer as _};
use rustix::fs::{FlockOperation, flock};
use rustix::process::{Pid, Signal, kill_process};

const PART: &str = "NODE_TEST_PART";
const INSTANCE: &str = "NODE_TEST_INSTANCE";

/// A process of the test's own, which is this very executable playing a part.
struct Helper {
    child: Child,
    stdin: Option<ChildStdin>,
}

impl Helper {
    fn command(own: &Own, part: &str, crash: &str) -> Command {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args(["--exact", "processes::helper", "--nocapture"]);
        command.env(PART, part).env(INSTANCE, own.0.name()).env("HOPPER_CRASH", crash);
        command
    }

    fn spawn(mut command: Command) -> Child {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap()
    }

    /// Starts it and waits until it is ready.
    fn start(own: &Own, part: &str, crash: &str) -> Self {
        Self::started(Self::command(own, part, crash), part)
    }

    /// As [`Helper::start`], where a hangup has that effect in the beginning, whatever it has in these tests.
    fn start_with_hangup(effect: libc::sighandler_t, own: &Own, part: &str) -> Self {
        let mut command = Self::command(own, part, "");
        let set = move || {
            // SAFETY: the child has no handler.
            unsafe { libc::signal(libc::SIGHUP, effect) };
            Ok(())
        };
        // SAFETY: a system call, which allocates nothing.
        unsafe { command.pre_exec(set) };
        Self::started(command, part)
    }

    fn started(command: Command, part: &str) -> Self {
        let mut child = Self::spawn(command);
        let stdin = child.stdin.take();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap() == "ready"), "{part} does not get ready");
        std::thread::spawn(move || lines.count());
        Self { child, stdin }
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// How it ended, and how long that took.
    fn end(&mut self) -> (ExitStatus, Duration) {
        let started = Instant::now();
        (self.child.wait().unwrap(), started.elapsed())
    }
}

impl Drop for Helper {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn ready() {
    println!("\nready");
    std::io::stdout().flush().unwrap();
}

/// Not a test: the part that a [`Helper`] plays.
#[test]
fn helper() {
    let Ok(part) = std::env::var(PART) else { return };
    let instance = Instance::new(&std::env::var(INSTANCE).unwrap()).unwrap();
    let exit = play(&part, &instance);
    std::process::exit(exit.code().into());
}

fn play(part: &str, instance: &Instance) -> Exit {
    if part == "come and go" {
        ready();
        for _ in 0..10 {
            let mut node = Node::join(instance, Role::Monitor).unwrap();
            node.reader::<State>(ROBOT, false).unwrap();
        }
        return Exit::Done;
    }
    if part == "wait" {
        // Signals are watched from here on; another process holds the lock.
        let _shutdown = node::ShutdownSignal::new().unwrap();
        ready();
        let joining = Joining { patience: Duration::MAX, ..Joining::default() };
        return Node::join_with(instance, Role::Monitor, joining).unwrap_err().exit();
    }
    if let Some(file) = part.strip_prefix("lock ") {
        let lock = std::fs::File::create(instance.root().join(file)).unwrap();
        flock(&lock, FlockOperation::LockExclusive).unwrap();
        ready();
        std::thread::sleep(Duration::from_secs(600));
        return Exit::Done;
    }
    let _claim = (part == "claim").then(|| instance.claim(Role::HopperSim).unwrap());
    let mut node = Node::join(instance, Role::HopperSim).unwrap();
    let mut states = node.writer::<State>(ROBOT).unwrap();
    let _servers = (part == "serve")
        .then(|| (node.server::<PastRequest>(ROBOT).unwrap(), node.server::<TruthRequest>(ROBOT).unwrap()));
    if part.starts_with("lifeline") {
        node.hold_lifeline();
    }
    ready();
    for decision in 0.. {
        node.sleep(if part == "sleep" { Duration::from_secs(60) } else { Duration::from_millis(5) });
        if node.stop_requested() && part != "lifeline, hanging" {
            return Exit::Interrupted;
        }
        crash_point("helper.looped");
        states.publish(state(decision)).unwrap();
    }
    Exit::Done
}

/// P-NOHUP: A process that was started with `nohup` outlives the end of its terminal.
#[test]
fn a_hangup_that_is_ignored_when_a_process_begins_does_not_end_it() {
    let own = Own::new();
    let mut helper = Helper::start_with_hangup(libc::SIG_IGN, &own, "loop");
    for _ in 0..3 {
        helper.signal(Signal::HUP);
    }
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(helper.child.try_wait().unwrap(), None, "it lives on");
    helper.signal(Signal::TERM);
    assert_eq!(helper.end().0.code(), Some(130));
    own.assert_gone();
}

#[test]
fn a_signal_ends_even_a_long_sleep_at_once_and_nothing_is_left() {
    for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
        let own = Own::new();
        let mut helper = Helper::start_with_hangup(libc::SIG_DFL, &own, "sleep");
        helper.signal(signal);
        let (status, took) = helper.end();
        assert_eq!(status.code(), Some(130), "{signal:?}");
        assert!(took < Duration::from_secs(2), "{signal:?} took {took:?}");
        own.assert_gone();
    }
}

#[test]
fn quit_still_ends_a_process_the_hard_way() {
    let own = Own::new();
    let mut helper = Helper::start(&own, "sleep", "");
    helper.signal(Signal::QUIT);
    assert_eq!(helper.end().0.signal(), Some(Signal::QUIT.as_raw()));
    assert!(matches!(own.0.clean().unwrap(), Cleaned::Removed { .. }));
    own.assert_gone();
}

#[test]
fn the_end_of_the_parent_ends_a_process_even_one_that_hangs() {
    let own = Own::new();
    let mut tidy = Helper::start(&own, "lifeline", "");
    drop(tidy.stdin.take());
    let (status, took) = tidy.end();
    assert_eq!(status.code(), Some(130));
    assert!(took < Duration::from_secs(1), "{took:?}");
    own.assert_gone();

    let mut hanging = Helper::start(&own, "lifeline, hanging", "");
    drop(hanging.stdin.take());
    let (status, took) = hanging.end();
    assert_eq!(status.code(), Some(130));
    assert!((1..4).contains(&took.as_secs()), "{took:?}");
    assert!(matches!(own.0.clean().unwrap(), Cleaned::Removed { .. }));
    own.assert_gone();
}

#[test]
fn a_crash_point_kills_at_the_passage_it_names() {
    let own = Own::new();
    let mut helper = Helper::start(&own, "loop", "helper.looped:20");
    let started = Instant::now();
    assert_eq!(helper.end().0.signal(), Some(Signal::KILL.as_raw()));
    assert!(started.elapsed() >= Duration::from_millis(50), "it lived for 20 passages of 5 ms");
    own.0.clean().unwrap();
    own.assert_gone();
}

#[test]
fn a_killed_writer_s_place_is_free_for_the_next_and_its_reader_reads_on() {
    let own = Own::new();
    {
        let mut node = Node::visit(&own.0).unwrap();
        let mut reader = node.reader::<State>(ROBOT, false).unwrap();
        for _ in 0..3 {
            let mut writer = Helper::start(&own, "loop", "");
            eventually("a state", || reader.newest()).unwrap();
            writer.child.kill().unwrap();
            writer.end();
            reader.drain();
        }
        let mut last = node.writer::<State>(ROBOT).unwrap();
        last.publish(state(99)).unwrap();
        assert_eq!(reader.newest(), Some(Ok(state(99))));
    }
    own.assert_gone();
}

#[test]
fn the_dead_are_seen_and_freed_by_those_who_live() {
    let own = Own::new();
    {
        let _sim = Node::join(&own.0, Role::HopperSim).unwrap();
        let mut helper = Helper::start(&own, "loop", "");
        let alone = own.files().len();
        helper.child.kill().unwrap();
        helper.end();
        eventually("the clean-up", || {
            let nodes = inspect(&own.0).unwrap().nodes;
            nodes.iter().all(|node| node.health == NodeHealth::Alive).then_some(())
        });
        assert!(own.files().len() < alone, "its files are gone");
    }
    own.assert_gone();
}

/// P-START-KILL: Whenever a process is killed during its start, the next one can start.
#[test]
fn whenever_a_process_is_killed_in_its_start_the_next_one_can_begin() {
    let own = Own::new();
    for round in 0..25 {
        let mut child = Helper::spawn(Helper::command(&own, "claim", ""));
        std::thread::sleep(Duration::from_micros(1000 + 997 * round));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    {
        let mut peer = Node::join(&own.0, Role::Perception).unwrap();
        let mut reader = peer.reader::<State>(ROBOT, false).unwrap();
        for round in 0..25 {
            let mut child = Helper::spawn(Helper::command(&own, "claim", ""));
            std::thread::sleep(Duration::from_micros(1000 + 997 * round));
            child.kill().unwrap();
            child.wait().unwrap();
        }
        let _claim = own.0.claim(Role::HopperSim).unwrap();
        let mut sim = Node::join(&own.0, Role::HopperSim).unwrap();
        let mut writer = sim.writer::<State>(ROBOT).unwrap();
        reader.drain();
        writer.publish(state(7)).unwrap();
        assert_eq!(reader.newest(), Some(Ok(state(7))));
        eventually("the clean-up", || {
            let nodes = inspect(&own.0).unwrap().nodes;
            nodes.iter().all(|node| node.health == NodeHealth::Alive).then_some(())
        });
    }
    own.assert_gone();
}

/// P-DEAD-NODE-CLEANUP: A process that is killed while it cleans up after dead processes costs no
/// other process its slot in a service.
#[test]
fn whoever_is_killed_while_freeing_the_dead_costs_nobody_their_place() {
    let own = Own::new();
    {
        // It looks after the dead once a second only, and keeps the services alive.
        let mut peer = Node::join(&own.0, Role::Monitor).unwrap();
        let _clients =
            (peer.client::<PastRequest>(ROBOT).unwrap(), peer.client::<TruthRequest>(ROBOT).unwrap());
        let names = |folder: &Path| -> BTreeSet<String> {
            let entries = std::fs::read_dir(folder).unwrap().flatten();
            entries.map(|entry| entry.file_name().into_string().unwrap()).collect()
        };
        let (nodes, records) = (own.0.root().join("nodes"), own.0.root().join("dead"));
        for round in 0..3 {
            let before = names(&nodes);
            let mut server = Helper::start(&own, "serve", "");
            let after = names(&nodes);
            let id = after.difference(&before).find(|name| nodes.join(name).is_dir()).unwrap();
            let tags: Vec<String> =
                names(&nodes.join(id)).into_iter().filter(|name| name.ends_with(".port_tag")).collect();
            server.child.kill().unwrap();
            server.end();
            // As if somebody had written the tags down, removed them, and died before the places were free.
            std::fs::create_dir_all(&records).unwrap();
            std::fs::write(records.join(id), tags.join("\n")).unwrap();
            for tag in &tags {
                // Gone only if the peer has just freed it all.
                let _ = std::fs::remove_file(nodes.join(id).join(tag));
            }
            let mut next = Node::join(&own.0, Role::HopperSim).unwrap();
            let servers = (next.server::<PastRequest>(ROBOT), next.server::<TruthRequest>(ROBOT));
            assert!(tags.len() > 4 && servers.0.is_ok() && servers.1.is_ok(), "round {round}: {servers:?}");
        }
    }
    own.assert_gone();
}

/// P-HOLD-UP. A process that is stopped while it joins is named, and waited for until patience
/// ends.
#[test]
fn who_stops_while_joining_is_waited_for_patiently_and_named() {
    let own = Own::new();
    {
        let _peer = Node::join(&own.0, Role::Perception).unwrap();
        let mut stopped = Helper::start(&own, "lock creation.lock", "");
        stopped.signal(Signal::STOP);
        let join = |patience| {
            let joining = Joining { patience, ..Joining::default() };
            Node::join_with(&own.0, Role::Planner, joining).map(drop)
        };
        let error = join(Duration::from_millis(20)).unwrap_err();
        let told = error.to_string();
        let pid = stopped.child.id();
        assert!(matches!(error, NodeError::Busy { .. }), "{told}");
        let named = told.contains(&format!("process {pid} (")) && told.contains("processes::helper");
        assert!(named && told.contains("which is stopped"), "{told}");
        assert_eq!(own.0.held_up_by().map(|holder| (holder.pid, holder.is_stopped)), Some((pid, true)));
        let report = inspect(&own.0);
        assert!(report.unwrap().advice.iter().any(|advice| advice.contains(&format!("process {pid} ("))));
        std::thread::scope(|scope| {
            let joined = scope.spawn(|| join(Duration::MAX));
            stopped.child.kill().unwrap();
            stopped.end();
            joined.join().unwrap().unwrap();
        });
        assert_eq!(own.0.held_up_by(), None);
    }
    own.assert_gone();
}

/// P-HOLD-UP. A process that waits for another to join ends on a signal.
#[test]
fn a_signal_ends_the_wait_for_who_stopped_while_joining() {
    let own = Own::new();
    {
        let _peer = Node::join(&own.0, Role::Perception).unwrap();
        let holder = Helper::start(&own, "lock creation.lock", "");
        let mut waiting = Helper { child: Helper::spawn(Helper::command(&own, "wait", "")), stdin: None };
        let mut lines = BufReader::new(waiting.child.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap() == "ready"));
        // The first may come before the wait has begun.
        let status = eventually("the end of the wait", || {
            waiting.signal(Signal::TERM);
            waiting.child.try_wait().unwrap()
        });
        assert_eq!(status.code(), Some(130));
        drop(holder);
    }
    own.assert_gone();
}

#[test]
fn a_claim_dies_with_its_holder_and_names_it_until_then() {
    let own = Own::new();
    {
        let mut holder = Helper::start(&own, "claim", "");
        let pid = holder.child.id();
        let error = own.0.claim(Role::HopperSim).unwrap_err();
        assert!(matches!(error, NodeError::Held { holder: Some(got), .. } if got == pid), "{error}");
        holder.signal(Signal::STOP);
        assert!(own.0.claim(Role::HopperSim).is_err(), "a stopped process still holds it");
        assert_eq!(own.0.clean().unwrap(), Cleaned::Alive, "a stopped process lives");
        holder.child.kill().unwrap();
        holder.end();
        own.0.claim(Role::HopperSim).unwrap();
    }
    own.assert_gone();
}

#[test]
fn leftovers_of_the_killed_are_told_and_removed_and_a_newcomer_starts_clean() {
    let own = Own::new();
    let leave = || {
        let mut helper = Helper::start(&own, "claim", "");
        helper.child.kill().unwrap();
        helper.end();
        assert!(own.files().len() > 2);
    };
    leave();
    let report = inspect(&own.0).unwrap();
    assert!(!report.alive && !report.leftovers.is_empty());
    assert!(report.advice[0].contains("--clean"), "{:?}", report.advice);
    assert!(matches!(own.0.clean().unwrap(), Cleaned::Removed { files, bytes } if files > 0 && bytes > 0));
    own.assert_gone();
    leave();
    {
        let mut node = Node::join(&own.0, Role::HopperSim).unwrap();
        assert_eq!(inspect(&own.0).unwrap().nodes.iter().filter(|node| node.name == "hopper-sim").count(), 1);
        node.writer::<State>(ROBOT).unwrap();
    }
    own.assert_gone();
}

#[test]
fn processes_that_come_and_go_at_the_same_moment_leave_nothing() {
    let own = Own::new();
    let mut helpers: Vec<_> = (0..3).map(|_| Helper::start(&own, "come and go", "")).collect();
    for helper in &mut helpers {
        assert_eq!(helper.end().0.code(), Some(0));
    }
    own.assert_gone();
}
