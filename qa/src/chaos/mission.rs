//! One mission flown by four real processes, with the faults of its plan injected into one of them.

use std::fs::OpenOptions;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use contract::{MonotonicNs, Role};
use hopper::mission::child::Supervised;
use hopper::mission::comparison::against_lockstep;
use hopper_sim::{Journal, JournalReader};
use node::{Exit, Failure, Instance, Node, ShutdownSignal};
use report::Summary;
use rustix::process::{Pid, Signal, kill_process};
use serde::Serialize;
use simulation::setup::Seat;

use super::plan::{Fault, FaultTime, Plan};
use super::world::{Undisturbed, World};

/// Pause between two checks of the processes.
const POLL: Duration = Duration::from_micros(300);

/// A mission without another decision for so long hangs, nanoseconds.
const PATIENCE_NS: u64 = 60_000_000_000;

/// Pause between two looks at the journal while no fault waits for a decision, nanoseconds.
const LOOK_NS: u64 = 500_000_000;

/// How long peers may take to end after the mission before their standard input is closed, nanoseconds.
const FAREWELL_NS: u64 = 1_500_000_000;

/// How long a process may take to end once it was told to, nanoseconds.
const ENDING_NS: u64 = 5_000_000_000;

/// Signal by which a process dies at a crash point.
const KILL: i32 = Signal::KILL.as_raw();

/// Exit code of a process that was told to end.
const TOLD: i32 = Exit::Interrupted as i32;

/// A fault that was injected.
#[derive(Clone, Copy, Debug)]
pub struct Delivered {
    /// The fault as planned.
    pub fault: Fault,
    /// From the fault, or from its end if it has one, to the next committed decision; `None` if no decision
    /// followed.
    pub recovery_ns: Option<u64>,
}

/// Result of a disturbed mission.
#[derive(Debug)]
pub struct Flown {
    /// Faults that were injected; a crash point that was never reached is not among them.
    pub delivered: Vec<Delivered>,
    /// Decisions in its journal.
    pub decisions: u64,
    /// The first promise that did not hold.
    pub broken: Option<Broken>,
}

/// A promise that did not hold.
#[derive(Clone, Debug, Serialize)]
pub struct Broken {
    /// The promise, in words.
    pub promise: &'static str,
    /// What was found instead, with the ends of the logs.
    pub detail: String,
}

/// Why a mission is not flown to its end.
enum Cut {
    /// A promise did not hold.
    Broken(Broken),
    /// The command itself cannot go on.
    Failed(Failure),
}

impl From<Failure> for Cut {
    fn from(failure: Failure) -> Self {
        Cut::Failed(failure)
    }
}

fn broken(promise: &'static str, detail: impl Into<String>) -> Cut {
    Cut::Broken(Broken { promise, detail: detail.into() })
}

/// Flies the mission of `plan` in `world`, in the empty `folder`, with processes of the program `hopper`.
///
/// # Errors
/// If a process cannot be started, or the command is interrupted (exit code 130).
pub fn fly(
    hopper: &Path,
    plan: &Plan,
    world: &World,
    folder: &Path,
    undisturbed: Undisturbed,
    shutdown: &ShutdownSignal,
) -> Result<Flown, Failure> {
    let instance = Instance::new(&format!("chaos-{}-{}-{}", std::process::id(), plan.victim, plan.seed))?;
    let mut flight = Flight {
        hopper,
        plan,
        world,
        shutdown,
        journal: folder.join("journal"),
        folder,
        instance: &instance,
        children: Vec::new(),
        victim: 0,
        moments: Vec::new(),
    };
    let result = flight.fly(undisturbed);
    // After a broken promise some still run: dropping them kills them.
    flight.children.clear();
    let (moments, journal) = (flight.moments, flight.journal);
    let broken = match result {
        Ok(()) => None,
        Err(Cut::Failed(failure)) => {
            instance.clean()?;
            return Err(failure);
        }
        Err(Cut::Broken(broken)) => {
            instance.clean()?;
            Some(broken)
        }
    };
    let committed = commit_moments(&journal);
    let delivered = moments.iter().map(|&(fault, at)| {
        let next = committed.iter().find(|&&committed| committed > at);
        Delivered { fault, recovery_ns: next.map(|next| next.since_ns(at)) }
    });
    Ok(Flown { delivered: delivered.collect(), decisions: committed.len() as u64, broken })
}

struct Flight<'a> {
    hopper: &'a Path,
    plan: &'a Plan,
    world: &'a World,
    shutdown: &'a ShutdownSignal,
    folder: &'a Path,
    journal: PathBuf,
    instance: &'a Instance,
    /// In the order in which they were started first.
    children: Vec<Supervised>,
    /// Index of the victim in `children`.
    victim: usize,
    /// Faults that were injected, with the moment at which each was over.
    moments: Vec<(Fault, MonotonicNs)>,
}

impl Flight<'_> {
    fn fly(&mut self, undisturbed: Undisturbed) -> Result<(), Cut> {
        std::fs::create_dir(self.folder.join("tmp")).map_err(Failure::run)?;
        self.world.write(&self.scenario())?;
        let mut faults = self.plan.faults.iter().copied();
        let mut due = faults.next();
        let seats = self.world.seats();
        for role in self.plan.order {
            let count = if role == Role::Planner { seats.len() } else { 1 };
            for (number, seat) in seats.iter().take(count).enumerate() {
                let arguments = self.arguments(role, seat);
                let is_victim = role == self.plan.victim && number == self.plan.planner.min(count - 1);
                if is_victim {
                    self.victim = self.children.len();
                }
                let fault = if is_victim { due } else { None };
                let child = Supervised::start_with(self.hopper, role, arguments, &|command| {
                    self.configure(role, fault, command);
                })?;
                self.children.push(child);
            }
        }
        // How many decisions the journal held when that was last looked at, and since when.
        let (mut held, mut since, mut looked) = (0, Node::now(), Node::now());
        // When the journal first held the decision that the next fault waits for.
        let mut reached = None;
        loop {
            if self.shutdown.wait(POLL) {
                return Err(Failure::new(Exit::Interrupted, "interrupted").into());
            }
            let now = Node::now();
            if now.since_ns(looked) > LOOK_NS {
                looked = now;
                let length = length(&self.journal);
                if length > held {
                    (held, since) = (length, now);
                }
            }
            if now.since_ns(since) > PATIENCE_NS {
                return Err(broken("a disturbed mission ends", self.with_logs("it does not end")));
            }
            if self.is_over(due)? {
                break;
            }
            let Some(fault) = due else { continue };
            if self.is_due(fault, &mut reached, now)? {
                self.inject(fault)?;
                due = faults.next();
                reached = None;
                if !matches!(fault, Fault::Pause { .. }) {
                    self.restart(due)?;
                }
            }
        }
        self.await_all(due)?;
        self.verify(undisturbed)
    }

    fn scenario(&self) -> PathBuf {
        self.folder.join("scenario.toml")
    }

    fn arguments(&self, role: Role, seat: &Seat) -> Vec<String> {
        let command = if role == Role::HopperSim { "sim" } else { role.as_str() };
        let mut words = vec![command.to_owned(), "--instance".to_owned(), self.instance.name().to_owned()];
        if role == Role::HopperSim {
            words.extend(["--format", "json", "--journal"].map(str::to_owned));
            words.push(self.journal.display().to_string());
            words.extend(["--seed".to_owned(), self.plan.seed.to_string()]);
            words.extend(["--pace".to_owned(), self.plan.pace.to_string()]);
            words.extend(["--scenario".to_owned(), self.scenario().display().to_string()]);
        }
        if role == Role::Planner {
            let robots: Vec<String> = seat.robots.iter().map(|robot| robot.to_string()).collect();
            words.extend(["--algorithm".to_owned(), seat.planner.to_string()]);
            words.extend(["--robot".to_owned(), robots.join(",")]);
        }
        words
    }

    /// Sends the log of `role` to the folder and sets its crash point.
    fn configure(&self, role: Role, fault: Option<Fault>, command: &mut Command) {
        command.env_remove("HOPPER_CRASH").env("TMPDIR", self.folder.join("tmp"));
        if let Some(Fault::Point { name, passage }) = fault {
            command.env("HOPPER_CRASH", format!("{name}:{passage}"));
        }
        if let Ok(log) = OpenOptions::new().create(true).append(true).open(self.log(role)) {
            command.stderr(log);
        }
    }

    fn log(&self, role: Role) -> PathBuf {
        self.folder.join(format!("{role}.log"))
    }

    fn victim(&mut self) -> &mut Supervised {
        &mut self.children[self.victim]
    }

    fn sim(&mut self) -> &mut Supervised {
        self.children.iter_mut().find(|child| child.role == Role::HopperSim).expect("one of them")
    }

    /// Whether hopper-sim has ended as it does with a mission. Any other process that has ended before breaks a
    /// promise, except a victim at its crash point.
    fn is_over(&mut self, due: Option<Fault>) -> Result<bool, Cut> {
        let at_a_point = matches!(due, Some(Fault::Point { .. }));
        let over = self.sim().ended()?.is_some_and(|status| matches!(status.code(), Some(0 | 1)));
        for index in 0..self.children.len() {
            let role = self.children[index].role;
            let Some(status) = self.children[index].ended()? else { continue };
            match status.code() {
                Some(0 | 1) if role == Role::HopperSim => {}
                Some(0) => {}
                Some(TOLD) if over => {}
                None if index == self.victim && at_a_point && status.signal() == Some(KILL) => {}
                _ => {
                    let detail = format!("{role} ended by itself ({status})");
                    return Err(broken("no process but the victim dies", self.with_logs(&detail)));
                }
            }
        }
        Ok(over)
    }

    fn is_due(
        &mut self,
        fault: Fault,
        reached: &mut Option<MonotonicNs>,
        now: MonotonicNs,
    ) -> Result<bool, Cut> {
        let journal = self.journal.clone();
        let victim = self.victim();
        Ok(match fault.at() {
            None => victim.ended()?.is_some_and(|status| status.code().is_none()),
            Some(FaultTime::StartUp { after_us }) => now.since_ns(victim.started) >= after_us * 1_000,
            Some(FaultTime::Flight { decisions, after_us }) => {
                if reached.is_none() && length(&journal) >= decisions {
                    *reached = Some(now);
                }
                reached.is_some_and(|since| now.since_ns(since) >= after_us * 1_000)
            }
        })
    }

    /// Injects the fault; returns once the victim is dead, or runs again after a pause.
    fn inject(&mut self, fault: Fault) -> Result<(), Cut> {
        let victim = self.victim();
        if victim.ended()?.is_some_and(|status| status.code().is_some()) {
            // It has ended with the mission.
            return Ok(());
        }
        match fault {
            Fault::Point { .. } => {}
            Fault::Kill(_) => {
                victim.kill();
                self.await_end(self.victim)?;
            }
            Fault::Pause { for_ms, .. } => {
                signal(victim, Signal::STOP);
                std::thread::sleep(Duration::from_millis(for_ms));
                signal(self.victim(), Signal::CONT);
            }
            Fault::Restart(_) => {
                signal(victim, Signal::TERM);
                self.await_end(self.victim)?;
            }
        }
        self.moments.push((fault, Node::now()));
        Ok(())
    }

    fn await_end(&mut self, index: usize) -> Result<(), Cut> {
        let told = Node::now();
        let role = self.children[index].role;
        loop {
            if self.children[index].ended()?.is_some() {
                return Ok(());
            }
            if Node::now().since_ns(told) > ENDING_NS {
                return Err(broken(
                    "a process that is told to end does so",
                    self.with_logs(&format!("{role} still runs")),
                ));
            }
            std::thread::sleep(POLL);
        }
    }

    /// Starts the victim again, unless it has ended by itself with its mission.
    fn restart(&mut self, next: Option<Fault>) -> Result<(), Cut> {
        if self.victim().ended()?.is_some_and(|status| matches!(status.code(), Some(0 | 1))) {
            return Ok(());
        }
        let (index, role) = (self.victim, self.plan.victim);
        let mut child = self.children.remove(index);
        let restarted = child.restart_with(&|command| self.configure(role, next, command));
        self.children.insert(index, child);
        Ok(restarted?)
    }

    /// Waits for the peers to end. A peer that was started after hopper-sim had gone waits for the next one, so it is
    /// told to end. A victim that reaches its crash point only now is started once more, to clean up.
    fn await_all(&mut self, mut due: Option<Fault>) -> Result<(), Cut> {
        loop {
            let over = Node::now();
            while Node::now().since_ns(over) < FAREWELL_NS && self.any_is_alive()? {
                std::thread::sleep(POLL);
            }
            for index in 0..self.children.len() {
                self.children[index].release();
                self.await_end(index)?;
            }
            self.is_over(due)?;
            let died = self.victim().ended()?.is_some_and(|status| status.code().is_none());
            let fault = due.take();
            if !died {
                return Ok(());
            }
            let Some(fault) = fault else { return Ok(()) };
            self.inject(fault)?;
            self.restart(None)?;
        }
    }

    fn any_is_alive(&mut self) -> Result<bool, Cut> {
        for child in &mut self.children {
            if child.ended()?.is_none() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn verify(&mut self, undisturbed: Undisturbed) -> Result<(), Cut> {
        let left = self.instance.paths().map_err(Failure::from)?;
        if !left.is_empty() {
            return Err(broken("nothing is left in shared memory", format!("left: {left:?}")));
        }
        let folders = [("tmp", &[][..]), ("journal", &["hops.journal", "lock"][..])];
        for (folder, expected) in folders {
            let strays = strays(&self.folder.join(folder), expected);
            if !strays.is_empty() {
                return Err(broken("nothing is left in folders", format!("left in {folder}: {strays:?}")));
            }
        }
        let verified = hopper_sim::verify(&self.journal)
            .map_err(|error| broken("the journal can be read", error.to_string()))?;
        if !verified.is_sound() {
            return Err(broken("the journal is sound", verified.faults().join("; ")));
        }
        if let Some(difference) = against_lockstep(&self.journal)? {
            return Err(broken("every decision is taken on the map of lockstep", difference.to_string()));
        }
        let told = self.sim().output();
        let summary: Summary = serde_json::from_str(&told).map_err(|error| {
            broken("hopper-sim prints a summary", self.with_logs(&format!("{error} in {told:?}")))
        })?;
        for (who, digest, outcome) in [
            ("the journal", verified.digest, verified.outcome.into()),
            ("the summary", summary.digest, summary.outcome),
        ] {
            if (digest, outcome) != (undisturbed.digest, report::Ending::Mission(undisturbed.outcome)) {
                let detail = format!(
                    "needs {} with {}, got {outcome} with {digest} in {who}",
                    undisturbed.outcome, undisturbed.digest
                );
                return Err(broken("the digest is that of lockstep", detail));
            }
        }
        Ok(())
    }

    /// `detail` with the last lines of every log.
    fn with_logs(&self, detail: &str) -> String {
        let mut text = detail.to_owned();
        for role in Role::ALL {
            let log = std::fs::read_to_string(self.log(role)).unwrap_or_default();
            let lines: Vec<&str> = log.lines().collect();
            for line in &lines[lines.len().saturating_sub(4)..] {
                text.push_str(&format!("\n  {role}: {line}"));
            }
        }
        text
    }
}

fn signal(child: &Supervised, signal: Signal) {
    if let Some(pid) = i32::try_from(child.pid()).ok().and_then(Pid::from_raw) {
        // Fails only if it has ended already.
        let _ = kill_process(pid, signal);
    }
}

/// Decisions in the journal so far.
fn length(journal: &Path) -> u64 {
    commit_moments(journal).len() as u64
}

/// When each decision was committed; empty if the journal cannot be read.
fn commit_moments(journal: &Path) -> Vec<MonotonicNs> {
    if !Journal::exists(journal) {
        return Vec::new();
    }
    let Ok(history) = JournalReader::open(journal) else { return Vec::new() };
    history.records().map_while(Result::ok).map(|record| record.timing.committed).collect()
}

/// Names in `folder` other than those expected.
fn strays(folder: &Path, expected: &[&str]) -> Vec<String> {
    let names = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.file_name());
    names
        .filter_map(|name| name.into_string().ok())
        .filter(|name| !expected.contains(&name.as_str()))
        .collect()
}
