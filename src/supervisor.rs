//! Watches over the four processes of a mission: starts them, restarts the dead and the hung, ends them.

use std::process::ExitStatus;
use std::time::Duration;

use contract::roster::SILENCE_NS;
use contract::{MonotonicNs, Role, Roster, Status};
use node::{Exit, Failure, Instance, Node};
use report::{Process, Summary};

use crate::child::{RESTARTS_MAX, Supervised};
use crate::outbox::Outbox;
use crate::run::Args;

/// A child whose heartbeat stands still this long hangs, and is killed.
const HANG_NS: u64 = 10 * SILENCE_NS;

/// How long children may take to end by themselves.
const FAREWELL_NS: u64 = 3_000_000_000;

/// How often the supervisor looks.
const PERIOD: Duration = Duration::from_millis(20);

/// Flies the mission with four processes; says whether it was interrupted.
///
/// # Errors
/// If a process cannot be started, or hopper-sim ends without a summary.
pub fn fly(args: &Args, outbox: &Outbox) -> Result<(Summary, bool), Failure> {
    let instance = Instance::new(&args.instance)?;
    instance.clean()?;
    let mut supervisor = Supervisor::start(args, &instance, outbox)?;
    let watched = supervisor.watch(args);
    supervisor.end()?;
    let summary = supervisor.summary();
    drop(supervisor);
    instance.clean()?;
    let interrupted = watched?;
    Ok((summary?, interrupted))
}

struct Supervisor {
    node: Node,
    roster: Roster,
    sim: Supervised,
    peers: Vec<Supervised>,
    gave_up: Option<MonotonicNs>,
}

impl Supervisor {
    fn start(args: &Args, instance: &Instance, outbox: &Outbox) -> Result<Self, Failure> {
        let node = Node::visit(instance)?;
        let texts = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let mut sim = texts(&["sim", "--instance", &args.instance, "--format", "json"]);
        sim.extend(texts(&[
            "--seed",
            &args.mission.seed.to_string(),
            "--pace",
            &args.mission.pace.to_string(),
        ]));
        let scenario = outbox.dir().join("scenario.toml");
        sim.extend(texts(&["--scenario", &scenario.to_string_lossy()]));
        sim.extend(texts(&["--journal", &outbox.journal_dir().to_string_lossy()]));
        let peer = |words: &[&str]| {
            let mut arguments = texts(words);
            arguments.extend(texts(&["--instance", &args.instance]));
            arguments
        };
        Ok(Self {
            node,
            roster: Roster::default(),
            sim: Supervised::start(Role::HopperSim, sim)?,
            peers: vec![
                Supervised::start(Role::Perception, peer(&["perception"]))?,
                Supervised::start(Role::Planner, peer(&["planner", "--algorithm", &args.planner]))?,
                Supervised::start(Role::Monitor, peer(&["monitor"]))?,
            ],
            gave_up: None,
        })
    }

    /// Watches until hopper-sim has ended; says whether it was interrupted.
    fn watch(&mut self, args: &Args) -> Result<bool, Failure> {
        loop {
            self.node.wait(PERIOD);
            if self.node.stop_requested().is_some() {
                return Ok(true);
            }
            for beat in self.node.heartbeats().into_iter().flatten() {
                self.roster.observe(beat, Node::now());
            }
            if let Some(status) = self.sim.ended()? {
                match status.code() {
                    Some(0 | 1) => return Ok(false),
                    Some(130) => return Ok(true),
                    Some(code) => return Err(gave_in(Role::HopperSim, code)),
                    None => self.revive_sim(status)?,
                }
            }
            self.revive_peers()?;
            self.kill_hung()?;
            let helpless = self
                .gave_up
                .is_some_and(|since| u128::from(Node::now().since_ns(since)) >= args.patience.as_nanos());
            if helpless {
                return Err(Failure::new(
                    Exit::Failed,
                    format!(
                        "the hopper held for {:?} and no help came: the mission is stopped; \
                         the same command with --out resumes it",
                        args.patience
                    ),
                ));
            }
        }
    }

    fn revive_sim(&mut self, status: ExitStatus) -> Result<(), Failure> {
        if self.sim.restarts >= RESTARTS_MAX {
            return Err(Failure::new(
                Exit::Failed,
                format!(
                    "hopper-sim died {} times, last by {status}: the mission is stopped",
                    RESTARTS_MAX + 1
                ),
            ));
        }
        tracing::warn!("hopper-sim died ({status}): restarting it on its journal");
        self.sim.restart()
    }

    fn revive_peers(&mut self) -> Result<(), Failure> {
        for peer in &mut self.peers {
            let Some(status) = peer.ended()? else { continue };
            if let Some(code @ (2 | 4)) = status.code() {
                return Err(gave_in(peer.role, code));
            }
            let finished = status.success();
            if finished {
                continue;
            }
            if peer.restarts >= RESTARTS_MAX {
                if self.gave_up.is_none() {
                    tracing::error!(
                        "{} died {} times, last by {status}: the hopper holds until another is started by hand",
                        peer.role,
                        RESTARTS_MAX + 1
                    );
                    self.gave_up = Some(Node::now());
                }
                continue;
            }
            tracing::warn!("{} died ({status}): restarting it", peer.role);
            peer.restart()?;
        }
        let now = Node::now();
        if self.peers.iter().all(|peer| self.roster.has(peer.role, now)) {
            // Help came by hand.
            self.gave_up = None;
        }
        Ok(())
    }

    fn kill_hung(&mut self) -> Result<(), Failure> {
        let now = Node::now();
        for child in self.peers.iter_mut().chain([&mut self.sim]) {
            let heard = self.roster.by_pid(child.pid()).map_or(child.started, |peer| peer.advanced);
            if child.ended()?.is_none() && now.since_ns(heard) > HANG_NS {
                tracing::warn!("{} hangs: killing it", child.role);
                child.kill();
            }
        }
        Ok(())
    }

    /// Lets all children end by themselves, and kills those that do not.
    fn end(&mut self) -> Result<(), Failure> {
        for child in self.peers.iter_mut().chain([&mut self.sim]) {
            child.release();
        }
        let deadline = Node::now().plus_ns(FAREWELL_NS);
        while Node::now() < deadline && self.someone_lives()? {
            std::thread::sleep(Duration::from_millis(2));
        }
        for child in self.peers.iter_mut().chain([&mut self.sim]) {
            if child.ended()?.is_none() {
                tracing::warn!("{} does not end: killing it", child.role);
                child.kill();
            }
        }
        Ok(())
    }

    fn someone_lives(&mut self) -> Result<bool, Failure> {
        for child in self.peers.iter_mut().chain([&mut self.sim]) {
            if child.ended()?.is_none() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The summary that hopper-sim wrote, with the supervisor's count of restarts.
    fn summary(&mut self) -> Result<Summary, Failure> {
        let text = self.sim.output();
        let mut summary: Summary = serde_json::from_str(&text).map_err(|_| {
            Failure::new(Exit::Failed, "hopper-sim ended without a summary: its log above says why")
        })?;
        let process =
            |child: &Supervised| Process { role: child.role, pid: child.pid(), restarts: child.restarts };
        summary.processes = std::iter::once(&self.sim).chain(&self.peers).map(process).collect();
        if !summary.outcome.is_over() {
            summary.outcome = Status::Stopped;
        }
        Ok(summary)
    }
}

/// A child that ended with code 2 or 4 would do so again.
fn gave_in(role: Role, code: i32) -> Failure {
    let exit = match code {
        2 => Exit::Usage,
        4 => Exit::Peer,
        _ => Exit::Failed,
    };
    Failure::new(exit, format!("{role} gave up with exit code {code}: its log above says why"))
}
