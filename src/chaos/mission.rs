//! One mission flown by four real processes, of which one suffers as its plan says.

use std::fs::OpenOptions;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use contract::{Digest, MonotonicNs, Role, Status};
use hopper_sim::{History, Journal};
use node::{Exit, Failure, Instance, Node, ShutdownSignal};
use report::Summary;
use rustix::process::{Pid, Signal, kill_process};
use serde::Serialize;

use super::plan::{Fault, Moment, Plan};
use crate::child::Supervised;

/// How often the processes are looked at.
const POLL: Duration = Duration::from_micros(300);

/// A mission that takes longer hangs.
const PATIENCE_NS: u64 = 60_000_000_000;

/// How long peers may take to end after the mission, before they are told to.
const FAREWELL_NS: u64 = 1_500_000_000;

/// How long a process may take to end once it was told to.
const ENDING_NS: u64 = 5_000_000_000;

/// What a crash point dies of.
const KILL: i32 = Signal::KILL.as_raw();

/// Exit code of who was told to end.
const TOLD: i32 = Exit::Interrupted as i32;

/// What the undisturbed mission comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undisturbed {
    /// Its digest.
    pub digest: Digest,
    /// Its end.
    pub outcome: Status,
}

/// A fault that befell the victim.
#[derive(Clone, Copy, Debug)]
pub struct Delivered {
    /// Which.
    pub fault: Fault,
    /// From the fault, or from its end if it has one, to the next decision that was committed; `None` if
    /// there was none left to make.
    pub recovery_ns: Option<u64>,
}

/// What a mission came to.
#[derive(Debug)]
pub struct Flown {
    /// Faults that befell the victim; a crash point that was never passed is none.
    pub delivered: Vec<Delivered>,
    /// Decisions executed.
    pub decisions: u64,
    /// What was promised, and did not come true.
    pub broken: Option<Broken>,
}

/// A promise that was broken.
#[derive(Clone, Debug, Serialize)]
pub struct Broken {
    /// The promise.
    pub promise: &'static str,
    /// What happened instead.
    pub detail: String,
}

/// Why a flight ended before its time.
enum Cut {
    /// A promise is broken.
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

/// Flies the mission of `plan` in `folder`, which is empty.
///
/// # Errors
/// If a process cannot be started, or the command is interrupted (exit code 130).
pub fn fly(
    plan: &Plan,
    folder: &Path,
    undisturbed: Undisturbed,
    shutdown: &ShutdownSignal,
) -> Result<Flown, Failure> {
    let instance = Instance::new(&format!("chaos-{}-{}-{}", std::process::id(), plan.victim, plan.seed))?;
    let mut flight = Flight {
        plan,
        shutdown,
        journal: folder.join("journal"),
        folder,
        instance: &instance,
        crew: Vec::new(),
        moments: Vec::new(),
    };
    let result = flight.fly(undisturbed);
    // Whoever still lives after a broken promise goes with the crew.
    flight.crew.clear();
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
    plan: &'a Plan,
    shutdown: &'a ShutdownSignal,
    folder: &'a Path,
    journal: PathBuf,
    instance: &'a Instance,
    crew: Vec<Supervised>,
    /// What befell the victim, and when it was over.
    moments: Vec<(Fault, MonotonicNs)>,
}

impl Flight<'_> {
    fn fly(&mut self, undisturbed: Undisturbed) -> Result<(), Cut> {
        std::fs::create_dir(self.folder.join("tmp")).map_err(Failure::run)?;
        let started = Node::now();
        let mut faults = self.plan.faults.iter().copied();
        let mut due = faults.next();
        for role in self.plan.order {
            let arguments = self.arguments(role);
            let fault = due.filter(|_| role == self.plan.victim);
            let child = Supervised::start_as(role, arguments, &|command| self.dress(role, fault, command))?;
            self.crew.push(child);
        }
        // Since when the present fault's decision has been in the journal.
        let mut reached = None;
        loop {
            if self.shutdown.wait(POLL) {
                return Err(Failure::new(Exit::Interrupted, "interrupted").into());
            }
            let now = Node::now();
            if now.since_ns(started) > PATIENCE_NS {
                return Err(broken("a disturbed mission ends", self.last_words("it goes on for ever")));
            }
            if self.look(due)? {
                break;
            }
            let Some(fault) = due else { continue };
            if self.is_due(fault, &mut reached, now)? {
                self.strike(fault)?;
                due = faults.next();
                reached = None;
                if !matches!(fault, Fault::Pause { .. }) {
                    self.revive(due)?;
                }
            }
        }
        self.part(due)?;
        self.verify(undisturbed)
    }

    fn arguments(&self, role: Role) -> Vec<String> {
        let command = if role == Role::HopperSim { "sim" } else { role.as_str() };
        let mut words = vec![command.to_owned(), "--instance".to_owned(), self.instance.name().to_owned()];
        if role == Role::HopperSim {
            words.extend(["--format", "json", "--journal"].map(str::to_owned));
            words.push(self.journal.display().to_string());
            words.extend(["--seed".to_owned(), self.plan.seed.to_string()]);
            words.extend(["--pace".to_owned(), self.plan.pace.to_string()]);
        }
        words
    }

    /// A life of `role`: its log in the folder, its crash point set.
    fn dress(&self, role: Role, fault: Option<Fault>, command: &mut Command) {
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
        let victim = self.plan.victim;
        self.crew.iter_mut().find(|child| child.role == victim).expect("the victim is one of the crew")
    }

    /// Whether hopper-sim has ended as a mission ends; whoever else has ended before it broke a promise,
    /// but for a victim at its crash point.
    fn look(&mut self, due: Option<Fault>) -> Result<bool, Cut> {
        let at_a_point = matches!(due, Some(Fault::Point { .. }));
        let sim = self.crew.iter_mut().find(|child| child.role == Role::HopperSim).expect("one of the crew");
        let over = sim.ended()?.is_some_and(|status| matches!(status.code(), Some(0 | 1)));
        for index in 0..self.crew.len() {
            let role = self.crew[index].role;
            let Some(status) = self.crew[index].ended()? else { continue };
            match status.code() {
                Some(0 | 1) if role == Role::HopperSim => {}
                Some(0) => {}
                Some(TOLD) if over => {}
                None if role == self.plan.victim && at_a_point && status.signal() == Some(KILL) => {}
                _ => {
                    let detail = format!("{role} ended by itself ({status})");
                    return Err(broken("nobody but the victim dies", self.last_words(&detail)));
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
            Some(Moment::StartUp { after_us }) => now.since_ns(victim.started) >= after_us * 1_000,
            Some(Moment::Flight { decisions, after_us }) => {
                if reached.is_none() && length(&journal) >= decisions {
                    *reached = Some(now);
                }
                reached.is_some_and(|since| now.since_ns(since) >= after_us * 1_000)
            }
        })
    }

    /// Does what the fault says; returns once the victim is dead, or goes on.
    fn strike(&mut self, fault: Fault) -> Result<(), Cut> {
        let victim = self.victim();
        if victim.ended()?.is_some_and(|status| status.code().is_some()) {
            // It has seen the end of the mission.
            return Ok(());
        }
        match fault {
            Fault::Point { .. } => {}
            Fault::Kill(_) => {
                victim.kill();
                self.await_end(self.plan.victim)?;
            }
            Fault::Pause { for_ms, .. } => {
                signal(victim, Signal::STOP);
                std::thread::sleep(Duration::from_millis(for_ms));
                signal(self.victim(), Signal::CONT);
            }
            Fault::Restart(_) => {
                signal(victim, Signal::TERM);
                self.await_end(self.plan.victim)?;
            }
        }
        self.moments.push((fault, Node::now()));
        Ok(())
    }

    fn await_end(&mut self, role: Role) -> Result<(), Cut> {
        let told = Node::now();
        loop {
            let child = self.crew.iter_mut().find(|child| child.role == role).expect("one of the crew");
            if child.ended()?.is_some() {
                return Ok(());
            }
            if Node::now().since_ns(told) > ENDING_NS {
                return Err(broken(
                    "who is told to end does so",
                    self.last_words(&format!("{role} goes on")),
                ));
            }
            std::thread::sleep(POLL);
        }
    }

    /// The victim's next life, unless it ended well.
    fn revive(&mut self, next: Option<Fault>) -> Result<(), Cut> {
        let victim = self.plan.victim;
        if self.victim().ended()?.is_some_and(|status| matches!(status.code(), Some(0 | 1))) {
            return Ok(());
        }
        let index = self.crew.iter().position(|child| child.role == victim).expect("one of the crew");
        let mut child = self.crew.swap_remove(index);
        let restarted = child.restart_as(&|command| self.dress(victim, next, command));
        self.crew.push(child);
        Ok(restarted?)
    }

    /// Lets the peers end by themselves. Who was started when hopper-sim had gone waits for the next: it is
    /// told to end. A victim that comes to its crash point only now, the last of all, leaves what it held to
    /// the next life.
    fn part(&mut self, mut due: Option<Fault>) -> Result<(), Cut> {
        loop {
            let over = Node::now();
            while Node::now().since_ns(over) < FAREWELL_NS && self.someone_lives()? {
                std::thread::sleep(POLL);
            }
            for role in Role::ALL {
                self.crew.iter_mut().filter(|child| child.role == role).for_each(Supervised::release);
                self.await_end(role)?;
            }
            self.look(due)?;
            let died = self.victim().ended()?.is_some_and(|status| status.code().is_none());
            let Some(fault) = due.take().filter(|_| died) else { return Ok(()) };
            self.strike(fault)?;
            self.revive(None)?;
        }
    }

    fn someone_lives(&mut self) -> Result<bool, Cut> {
        for child in &mut self.crew {
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
        let sim = self.crew.iter_mut().find(|child| child.role == Role::HopperSim).expect("one of the crew");
        let told = sim.output();
        let summary: Summary = serde_json::from_str(&told).map_err(|error| {
            broken(
                "hopper-sim tells what the mission came to",
                self.last_words(&format!("{error} in {told:?}")),
            )
        })?;
        for (who, digest, outcome) in [
            ("the journal", verified.digest, verified.outcome),
            ("the summary", summary.digest, summary.outcome),
        ] {
            if (digest, outcome) != (undisturbed.digest, undisturbed.outcome) {
                let detail = format!(
                    "needs {} with {}, got {outcome} with {digest} in {who}",
                    undisturbed.outcome, undisturbed.digest
                );
                return Err(broken("the digest is that of lockstep", detail));
            }
        }
        Ok(())
    }

    /// `detail` with the last lines of everybody's log.
    fn last_words(&self, detail: &str) -> String {
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
        // Fails only if it has ended already, and not been waited for.
        let _ = kill_process(pid, signal);
    }
}

/// Decisions that the journal holds so far.
fn length(journal: &Path) -> u64 {
    commit_moments(journal).len() as u64
}

/// When each decision was committed.
fn commit_moments(journal: &Path) -> Vec<MonotonicNs> {
    if !Journal::exists(journal) {
        return Vec::new();
    }
    let Ok(history) = History::open(journal) else { return Vec::new() };
    history.records().map_while(Result::ok).map(|record| record.timing.committed).collect()
}

/// What lies in `folder` beside what is expected there.
fn strays(folder: &Path, expected: &[&str]) -> Vec<String> {
    let names = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.file_name());
    names
        .filter_map(|name| name.into_string().ok())
        .filter(|name| !expected.contains(&name.as_str()))
        .collect()
}
