//! Every program that says that it is ready has been watching signals before.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::harness::{Mission, eventually, hopper, program, skip};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::pipe::{PipeFlags, SpliceFlags, fcntl_setpipe_size, pipe, pipe_with, tee};
use rustix::process::{Pid, Signal, kill_process};

/// Signals that ask a program to end.
const WATCHED: [Signal; 3] = [Signal::HUP, Signal::INT, Signal::TERM];

/// Commands of `hopper` that say nothing of being ready: they end by themselves, or, as `run`, leave that to their children.
const SILENT: [&str; 19] = [
    "run",
    "scenario",
    "terrain",
    "journal",
    "doctor",
    "motion",
    "validate",
    "gif",
    "bag",
    "latency",
    "coverage",
    "known",
    "gallery",
    "scouting",
    "simulate",
    "chaos",
    "endure",
    "completions",
    "man",
];

/// A program whose standard error takes one line at a time: it stands still in the middle of writing each line until the one
/// before has been read.
struct Slow {
    child: Child,
    lines: File,
}

impl Slow {
    fn spawn(mut command: Command) -> Self {
        let (lines, other_end) = pipe_with(PipeFlags::DIRECT).unwrap();
        // Room for one write.
        fcntl_setpipe_size(&other_end, 4096).unwrap();
        let mut first = File::from(other_end.try_clone().unwrap());
        first.write_all(b"nothing yet").unwrap();
        let stdout = Stdio::null();
        let child = command.stdin(Stdio::piped()).stdout(stdout).stderr(other_end).spawn().unwrap();
        Self { child, lines: lines.into() }
    }

    /// Whether a thread of the program stands still in writing to standard error.
    fn is_writing(&self) -> bool {
        let tasks = std::fs::read_dir(format!("/proc/{}/task", self.child.id()));
        tasks.into_iter().flatten().flatten().any(|task| {
            let call = std::fs::read_to_string(task.path().join("syscall")).unwrap_or_default();
            let mut words = call.split_whitespace();
            words.next().is_some_and(|number| number == WRITE) && words.next() == Some("0x2")
        })
    }

    /// The signals that the program handles. A hangup that these tests ignore, as under `nohup`, it ignores too.
    fn handled(&self) -> Vec<Signal> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap_or_default();
        let mask = |name: &str| {
            let mask = status.lines().find_map(|line| line.strip_prefix(name)).unwrap_or("0");
            u64::from_str_radix(mask.trim(), 16).unwrap()
        };
        let is_in = |mask: u64, signal: &Signal| mask >> (signal.as_raw() - 1) & 1 == 1;
        let (caught, ignored) = (mask("SigCgt:"), mask("SigIgn:"));
        let is_handled =
            |signal: &Signal| is_in(caught, signal) || *signal == Signal::HUP && is_in(ignored, signal);
        WATCHED.into_iter().filter(is_handled).collect()
    }

    /// The line that waits to be read, which stays there.
    fn waiting(&self) -> String {
        poll(&mut [PollFd::new(&self.lines, PollFlags::IN)], None).unwrap();
        let (copy, other_end): (OwnedFd, OwnedFd) = pipe().unwrap();
        tee(&self.lines, &other_end, 4096, SpliceFlags::empty()).unwrap();
        drop(other_end);
        // At once: what a shorter read leaves of a packet is gone.
        let mut packet = [0; 4096];
        let count = File::from(copy).read(&mut packet).unwrap();
        String::from_utf8_lossy(&packet[..count]).into_owned()
    }

    /// The signals that the program handles while it says a line with `ready` in it.
    fn handled_when(&mut self, ready: &str) -> Vec<Signal> {
        let mut said = String::new();
        loop {
            eventually(&format!("{ready:?} after {said}"), || {
                assert!(self.child.try_wait().unwrap().is_none(), "it ended, and said {said}");
                self.is_writing()
            });
            let handled = self.handled();
            let mut read = [0; 4096];
            let count = self.lines.read(&mut read).unwrap();
            said += &String::from_utf8_lossy(&read[..count]);
            let line = self.waiting();
            if line.contains(ready) {
                return handled;
            }
        }
    }
}

impl Drop for Slow {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The number of the system call, as the kernel shows it.
const WRITE: &str = if cfg!(target_arch = "x86_64") { "1" } else { "64" };

/// P-READY: Every program watches signals before it reports that it is ready; a signal at that
/// moment ends it in order.
#[test]
fn every_program_watches_signals_before_it_says_that_it_is_ready() {
    if !Path::new("/proc/self/syscall").exists() {
        return skip(
            "signals of programs that say that they are ready",
            "the kernel does not show system calls",
        );
    }
    let mission = Mission::new("ready");
    let flown = mission.hopper(&["run", "--lockstep", "--seed", "1", "--out", "flown"]).output().unwrap();
    assert_eq!(flown.status.code(), Some(0), "{}", String::from_utf8_lossy(&flown.stderr));
    let recording = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/hard.mcap");
    let address = "127.0.0.1:0";
    let rows: [(&[&str], &str); 12] = [
        (&["sim"], "joined instance"),
        (&["perception"], "joined instance"),
        (&["planner"], "joined instance"),
        (&["monitor"], "joined instance"),
        (&["monitor", "--web", address], "page at "),
        (&["monitor", "--foxglove", address], "viewers connect to "),
        (&["link", "--udp", "127.0.0.1:9"], "joined instance"),
        (&["view", "flown", "--web", address], "page at "),
        (&["view", recording, "--web", address], "page at "),
        (&["topic", "echo", "state", "--wait", "10m"], "is not running yet"),
        (&["topic", "hz", "state", "--wait", "10m"], "is not running yet"),
        (&["campaign", "run", "p23-tables", "--out", "campaign"], "trials are in the folder"),
    ];
    for (words, ready) in rows {
        watches(mission.hopper(words), &mission.name, words, ready);
    }
    for (name, ready) in
        ["hopper-sim", "perception", "planner", "monitor"].map(|name| (name, "joined instance"))
    {
        let mut command = Command::new(program(name));
        command.current_dir(mission.path(""));
        watches(command, &mission.name, &[name], ready);
    }
    // Whoever adds a command says which kind it is.
    let help = String::from_utf8(hopper(&["--help"]).output().unwrap().stdout).unwrap();
    let listed = help.split("Commands:").nth(1).unwrap().split("\n\n").next().unwrap();
    let named = |line: &str| line.strip_prefix("  ")?.split(' ').next().map(str::to_owned);
    let commands: BTreeSet<String> =
        listed.lines().filter_map(named).filter(|name| !name.is_empty() && name != "help").collect();
    let ready = rows.iter().map(|(words, _)| words[0]);
    let known: BTreeSet<String> = ready.chain(SILENT).map(str::to_owned).collect();
    assert_eq!(commands, known);
}

fn watches(mut command: Command, instance: &str, words: &[&str], ready: &str) {
    command.env("HOPPER_INSTANCE", instance).env_remove("HOPPER_CRASH");
    let mut slow = Slow::spawn(command);
    let handled = slow.handled_when(ready);
    assert_eq!(handled, WATCHED, "{words:?} handles only these when it says {ready:?}");
    kill_process(Pid::from_child(&slow.child), Signal::INT).unwrap();
    let mut lines = slow.lines.try_clone().unwrap();
    let reader = std::thread::spawn(move || std::io::copy(&mut lines, &mut std::io::sink()));
    let status = slow.child.wait().unwrap();
    assert!(matches!(status.code(), Some(0 | 1 | 130)), "{words:?} ended with {status}");
    reader.join().unwrap().unwrap();
}
