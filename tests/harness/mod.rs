//! Real processes under test: each test has an instance and a folder of its own, and leaves nothing behind.

#![allow(dead_code, reason = "each test binary uses its part of the harness")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::Value;

/// Nothing here waits longer; a test that gets this far has failed.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// An instance with its folder; dropping it kills its processes and checks what they left.
pub struct Mission {
    pub name: String,
    dir: tempfile::TempDir,
    checked: bool,
}

impl Mission {
    /// A fresh instance named after `test`.
    pub fn new(test: &str) -> Self {
        static COUNTER: AtomicU32 = AtomicU32::new(0);
        let count = COUNTER.fetch_add(1, Ordering::Relaxed);
        let name = format!("{test}-{}-{count}", std::process::id());
        Self { name, dir: tempfile::tempdir().unwrap(), checked: false }
    }

    /// The folder of this mission.
    pub fn path(&self, file: &str) -> PathBuf {
        self.dir.path().join(file)
    }

    pub fn journal(&self) -> PathBuf {
        self.path("journal")
    }

    /// `hopper WORDS`, in the mission's folder.
    pub fn hopper(&self, words: &[&str]) -> Command {
        let mut command = hopper(words);
        command.current_dir(self.dir.path());
        command
    }

    /// Flies a whole mission by `hopper run`, its files in `out`.
    pub fn fly(&self, words: &[&str]) -> Output {
        let mut command = self.hopper(&["run", "--instance", &self.name, "--out", "out", "--format", "json"]);
        command.args(words).output().unwrap()
    }

    /// Starts `hopper ROLE --instance …` with further `words`.
    pub fn start(&self, role: &str, words: &[&str]) -> Process {
        self.start_with(role, words, &[])
    }

    /// Starts a role with environment variables, e.g. a crash point.
    pub fn start_with(&self, role: &str, words: &[&str], environment: &[(&str, &str)]) -> Process {
        let mut command = self.hopper(&[role, "--instance", &self.name]);
        if role == "sim" {
            command.args(["--format", "json"]);
            if !words.contains(&"--journal") {
                command.args(["--journal", "journal"]);
            }
        }
        command.args(words).envs(environment.iter().copied());
        Process::spawn(role, command, self.dir.path())
    }

    /// Starts a mission so slow that it cannot end before a test has done what it wants to do; end it
    /// with [`Mission::hurry`].
    pub fn start_slow_sim(&self, seed: &str) -> Process {
        self.start("sim", &["--seed", seed, "--pace", "0.5"])
    }

    /// Kills a slow hopper-sim and lets another finish its journal at full pace.
    pub fn hurry(&self, mut slow: Process, seed: &str) -> Process {
        slow.kill();
        let mut sim = self.start("sim", &["--seed", seed]);
        sim.code();
        sim
    }

    /// Starts a mission of which hopper-sim dies once its journal has got so many records: however slow the machine, it goes no
    /// further before a test has done what it wants to do.
    pub fn start_sim_until(&self, records: u32, words: &[&str]) -> Process {
        self.start_with("sim", words, &[("HOPPER_CRASH", &format!("sim.appended:{records}"))])
    }

    /// Hands a robot over to another planner in a mission that [`Mission::start_sim_until`] has begun and that goes on with
    /// `words`. The old planner is stopped meanwhile, and lives on.
    pub fn hand_over(
        &self,
        mut begun: Process,
        words: &[&str],
        old: Option<&Process>,
        new: &[&str],
    ) -> (Process, Process) {
        assert_eq!(begun.code(), -1, "{}", begun.log());
        if let Some(old) = old {
            old.stop();
        }
        let new = self.start("planner", &[new, &["--takeover"]].concat());
        new.await_log("joined");
        let sim = self.start("sim", words);
        new.await_log("in command");
        if let Some(old) = old {
            old.signal(rustix::process::Signal::CONT);
        }
        (sim, new)
    }

    /// Starts perception, planner and monitor.
    pub fn start_peers(&self) -> Vec<Process> {
        ["perception", "planner", "monitor"].map(|role| self.start(role, &[])).into()
    }

    /// Reads the journal through `hopper journal verify`.
    pub fn verified(&self) -> Value {
        verify(&self.journal())
    }

    /// The journal in `folder` has the digest and the map of lockstep at every decision.
    pub fn assert_as_lockstep(&self, folder: &str) {
        let output = self.hopper(&["journal", "verify", folder, "--against-lockstep"]).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "{text}{}", String::from_utf8_lossy(&output.stderr));
        assert!(text.contains("the same digest and map at each of"), "{text}");
    }

    /// Flies a scenario of two robots, each with a planner process of its own. The second robot's planner, perception,
    /// hopper-sim and the first robot's planner are killed and started again once there are so many decisions. The journal is
    /// that of lockstep, and each planner leads in its second term.
    pub fn kill_each_of_two(&self, scenario: &[&str], pace: &str, planners: [&str; 2], at: [u64; 4]) {
        let sim_words = [scenario, &["--pace", pace]].concat();
        let [of_first, of_second] = [0, 1].map(|robot| {
            let number = ["0", "1"][robot];
            ["--robot", number, "--algorithm", planners[robot]]
        });
        let mut sim = self.start("sim", &sim_words);
        let mut perception = self.start("perception", &[]);
        let mut first = self.start("planner", &of_first);
        let mut second = self.start("planner", &of_second);
        self.await_decisions(at[0]);
        second.kill();
        let mut second = self.start("planner", &of_second);
        self.await_decisions(at[1]);
        perception.kill();
        let mut perception = self.start("perception", &[]);
        self.await_decisions(at[2]);
        sim.kill();
        let mut sim = self.start("sim", &sim_words);
        self.await_decisions(at[3]);
        first.kill();
        let mut first = self.start("planner", &of_first);
        assert_eq!(sim.code(), 0, "{}", sim.log());
        for process in [&mut perception, &mut first, &mut second] {
            assert_eq!(process.code(), 0, "{}", process.log());
        }
        let verified = self.verified();
        assert_eq!((&verified["contiguous"], &verified["duplicates"]), (&true.into(), &0.into()));
        assert_eq!(verified["digest"], lockstep(scenario)["digest"]);
        let led = leaders(&verified);
        for (robot, planner) in (0..).zip(planners) {
            assert!(led.contains(&(robot, 2, planner.into())), "{led:?}");
        }
        self.assert_as_lockstep("journal");
    }

    /// Decisions in the journal so far; 0 while there is none.
    pub fn decisions(&self) -> u64 {
        if !self.journal().join("hops.journal").exists() {
            return 0;
        }
        let output = self.hopper(&["journal", "verify", "journal", "--format", "json"]).output().unwrap();
        serde_json::from_slice::<Value>(&output.stdout)
            .ok()
            .and_then(|value| value["decisions"].as_u64())
            .unwrap_or(0)
    }

    /// Waits until the journal holds `count` decisions.
    pub fn await_decisions(&self, count: u64) {
        eventually(&format!("{count} decisions in {}", self.name), || self.decisions() >= count);
    }

    /// Nothing of the instance may be left in shared memory.
    pub fn assert_nothing_left(&mut self) {
        self.checked = true;
        let left = self.leftovers();
        assert!(left.is_empty(), "{} left {left:?} in shared memory", self.name);
    }

    pub fn instance(&self) -> node::Instance {
        node::Instance::new(&self.name).unwrap()
    }

    fn leftovers(&self) -> Vec<PathBuf> {
        self.instance().paths().unwrap()
    }
}

impl Drop for Mission {
    fn drop(&mut self) {
        // Tests that kill leave files by design: they are removed the documented way, then none may stay.
        if !self.checked {
            // With the program as it is: whoever is panicking builds nothing.
            let doctor = &["doctor", "--clean", "--instance", &self.name];
            let _ = of_test(&mut Command::new(built("hopper")), doctor).output();
        }
        let left = self.leftovers();
        if !std::thread::panicking() {
            assert!(left.is_empty(), "doctor --clean left {left:?} of {}", self.name);
        }
    }
}

/// `hopper WORDS`, free of the caller's settings; the program that serves the command is built too.
pub fn hopper(words: &[&str]) -> Command {
    if let Some(tool) =
        words.iter().find(|word| **word != "help").and_then(|command| hopper::tool::serving(command))
    {
        program(tool);
    }
    let mut command = Command::new(program("hopper"));
    of_test(&mut command, words);
    command
}

fn of_test<'a>(command: &'a mut Command, words: &[&str]) -> &'a mut Command {
    command.args(words).env_remove("HOPPER_INSTANCE").env_remove("HOPPER_CRASH").stdin(Stdio::null())
}

/// Where the program `name` of this build lies, if it is there.
fn built(name: &str) -> PathBuf {
    let test = std::env::current_exe().unwrap();
    test.ancestors().nth(2).unwrap().join(name)
}

/// The program `name` of this build. `cargo test` builds every program of the workspace; with `-p` it builds those of
/// that package only, and another that is missing or out of date is built here.
pub fn program(name: &str) -> PathBuf {
    // One lock for each: a live test that polls `hopper` must not stand still while another test builds a tool.
    static BUILDING: Mutex<BTreeMap<String, Arc<Mutex<()>>>> = Mutex::new(BTreeMap::new());
    let lock = {
        let mut locks = BUILDING.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(locks.entry(name.to_owned()).or_default())
    };
    let _alone = lock.lock().unwrap_or_else(PoisonError::into_inner);
    let path = built(name);
    if !is_up_to_date(&path) {
        let mut cargo = Command::new(env!("CARGO"));
        // Of no package by name, from the root of the workspace: so what is compiled already has the same features.
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .ancestors()
            .find(|folder| folder.join("Cargo.lock").exists());
        cargo.args(["build", "--quiet", "--bin", name]).current_dir(root.unwrap());
        let profile = if path.parent().unwrap().ends_with("release") { &["--release"][..] } else { &[] };
        assert!(cargo.args(profile).status().unwrap().success(), "{name} cannot be built");
    }
    path
}

/// Whether the program is there and newer than each of its sources, which Cargo lists beside it.
fn is_up_to_date(program: &Path) -> bool {
    let modified = |path: &Path| path.metadata().and_then(|metadata| metadata.modified()).ok();
    let Some(built) = modified(program) else { return false };
    let list = std::fs::read_to_string(program.with_extension("d")).unwrap_or_default();
    let sources = list.split_once(": ").map_or("", |(_, sources)| sources);
    sources
        .split_whitespace()
        .all(|source| modified(Path::new(source)).is_some_and(|changed| changed <= built))
}

/// A process that is killed when the test ends.
pub struct Process {
    pub role: String,
    child: Child,
    dir: PathBuf,
    tag: u32,
}

impl Process {
    pub fn spawn(role: &str, mut command: Command, dir: &Path) -> Self {
        static COUNTER: AtomicU32 = AtomicU32::new(0);
        let tag = COUNTER.fetch_add(1, Ordering::Relaxed);
        let file = |stream: &str| File::create(dir.join(format!("{role}-{tag}.{stream}"))).unwrap();
        let child = command.stdout(file("out")).stderr(file("err")).spawn().unwrap();
        Self { role: role.into(), child, dir: dir.into(), tag }
    }

    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    pub fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, signal).unwrap();
    }

    /// Stops it where nobody has to wait for it: while it makes something in the instance, or frees what the dead left, it holds a lock.
    pub fn stop(&self) {
        use rustix::process::Signal;
        self.signal(Signal::STOP);
        while holds_lock(self.pid()) {
            self.signal(Signal::CONT);
            std::thread::sleep(Duration::from_millis(5));
            self.signal(Signal::STOP);
        }
    }

    /// The processes that it has started and that have not been waited for.
    pub fn children(&self) -> Vec<i32> {
        let tasks = std::fs::read_dir(format!("/proc/{}/task", self.pid())).into_iter().flatten();
        tasks
            .filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("children")).ok())
            .flat_map(|text| text.split_whitespace().filter_map(|pid| pid.parse().ok()).collect::<Vec<_>>())
            .collect()
    }

    /// Kills the child process that was started as `hopper ROLE`; waits for it if it is still to come.
    pub fn kill_child(&self, role: &str) {
        let find = || {
            self.children().into_iter().find(|pid| {
                std::fs::read(format!("/proc/{pid}/cmdline"))
                    .is_ok_and(|line| line.split(|byte| *byte == 0).nth(1) == Some(role.as_bytes()))
            })
        };
        let mut pid = None;
        eventually("the child to run", || {
            pid = find();
            pid.is_some()
        });
        let pid = rustix::process::Pid::from_raw(pid.unwrap()).unwrap();
        rustix::process::kill_process(pid, rustix::process::Signal::KILL).unwrap();
    }

    /// kill -9, and the corpse is buried.
    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    pub fn has_ended(&mut self) -> Option<ExitStatus> {
        self.child.try_wait().unwrap()
    }

    /// Waits for the end; the exit code, or −1 for a signal.
    pub fn code(&mut self) -> i32 {
        let since = Instant::now();
        loop {
            if let Some(status) = self.has_ended() {
                return status.code().unwrap_or(-1);
            }
            assert!(since.elapsed() < PATIENCE, "{} did not end; it says:\n{}", self.role, self.log());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn stream(&self, stream: &str) -> String {
        std::fs::read_to_string(self.dir.join(format!("{}-{}.{stream}", self.role, self.tag)))
            .unwrap_or_default()
    }

    /// What it wrote to standard error.
    pub fn log(&self) -> String {
        self.stream("err")
    }

    /// What it wrote to standard output.
    pub fn out(&self) -> String {
        self.stream("out")
    }

    /// The JSON object it wrote to standard output.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out())
            .unwrap_or_else(|error| panic!("{error} in {:?}\n{}", self.out(), self.log()))
    }

    /// Waits until its log tells of hop `least` or a later one: the monitor writes a line a second, not one for each hop.
    pub fn await_hop(&self, least: u32) {
        eventually(&format!("hop {least} or a later one in the log of {}", self.role), || {
            let log = self.log();
            let hops =
                log.split("hop ").skip(1).filter_map(|rest| rest.split_once(',')?.0.parse::<u32>().ok());
            hops.max().is_some_and(|hop| hop >= least)
        });
    }

    /// Waits until its log holds `text`.
    pub fn await_log(&self, text: &str) {
        let since = Instant::now();
        while !self.log().contains(text) {
            let others = || logs_of_all(&self.dir);
            assert!(
                since.elapsed() < PATIENCE,
                "{} never says {text:?}:\n{}\n{}",
                self.role,
                self.log(),
                others()
            );
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Whether a process holds a file alone, as the kernel lists it: `1: FLOCK  ADVISORY  WRITE 1234 00:1a:5678 0 EOF`.
fn holds_lock(pid: u32) -> bool {
    let locks = std::fs::read_to_string("/proc/locks").unwrap_or_default();
    let pid = pid.to_string();
    locks.lines().any(|line| {
        let words: Vec<_> = line.split_whitespace().collect();
        (words.get(1), words.get(3), words.get(4)) == (Some(&"FLOCK"), Some(&"WRITE"), Some(&pid.as_str()))
    })
}

/// The end of what each process of a mission has logged.
fn logs_of_all(dir: &Path) -> String {
    let files = std::fs::read_dir(dir).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut logs: Vec<_> =
        files.filter(|path| path.extension().is_some_and(|ending| ending == "err")).collect();
    logs.sort();
    let end_of = |path: &PathBuf| {
        let log = std::fs::read_to_string(path).unwrap_or_default();
        let from = log.lines().count().saturating_sub(6);
        let lines: Vec<_> = log.lines().skip(from).collect();
        format!("--- {}\n{}", path.file_name().unwrap_or_default().display(), lines.join("\n"))
    };
    logs.iter().map(end_of).collect::<Vec<_>>().join("\n")
}

/// Says that part of a test is left out here, whatever the test runner captures.
pub fn skip(what: &str, why: &str) {
    let _ = writeln!(std::io::stderr(), "SKIPPED: {what}: {why}");
}

/// Waits until `claim` holds.
pub fn eventually(what: &str, mut claim: impl FnMut() -> bool) {
    let since = Instant::now();
    while !claim() {
        assert!(since.elapsed() < PATIENCE, "waited {PATIENCE:?} for {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// `hopper journal verify DIR --format json`.
pub fn verify(journal: &Path) -> Value {
    json(&hopper(&["journal", "verify", &journal.to_string_lossy(), "--format", "json"]).output().unwrap())
}

/// The undisturbed mission: summary of `hopper run --lockstep`.
pub fn lockstep(words: &[&str]) -> Value {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let mut command = hopper(&["run", "--lockstep", "--format", "json", "--out", &out.to_string_lossy()]);
    json(&command.args(words).output().unwrap())
}

/// The JSON object that a finished command wrote to standard output.
pub fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", stderr(output)))
}

/// Standard error of a finished command.
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Who led which robot in which term, by what algorithm.
pub fn leaders(verified: &Value) -> Vec<(u64, u64, String)> {
    let planners = verified["planners"].as_array().unwrap();
    let leader = |planner: &Value| {
        let name = planner["name"].as_str().unwrap().to_owned();
        (planner["robot"].as_u64().unwrap_or(0), planner["term"].as_u64().unwrap(), name)
    };
    planners.iter().map(leader).collect()
}
