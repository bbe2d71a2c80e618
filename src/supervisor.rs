//! Watches over the four processes of a mission: starts them, restarts the dead and the hung, ends them.

use std::path::Path;
use std::process::ExitStatus;
use std::time::Duration;

use contract::roster::SILENCE_NS;
use contract::{Heartbeat, MonotonicNs, RobotId, Role, Roster};
use node::{Exit, Failure, Instance, Node, Reader};
use process::{Ports, Reader as _};
use report::{Process, Summary};

use crate::child::{RESTARTS_MAX, Supervised};
use crate::outbox::Outbox;
use crate::run::Args;

/// A child whose heartbeat stands still this long hangs, and is killed.
const HANG_NS: u64 = 10 * SILENCE_NS;

/// How long children may take to end by themselves.
const FAREWELL_NS: u64 = 3_000_000_000;

/// How long a mission that is to be recorded waits for its recorder, nanoseconds.
const RECORDER_NS: u64 = 5_000_000_000;

/// How often the supervisor looks.
const PERIOD: Duration = Duration::from_millis(20);

/// A mission flown by four processes.
#[derive(Debug)]
pub struct Flight {
    /// What it came to, as far as anything was executed.
    pub summary: Option<Summary>,
    /// Whether it was interrupted, or why it could not go on.
    pub verdict: Result<bool, Failure>,
    /// Whether the monitor, and with it a recording that was asked for, ended well.
    pub watched: bool,
}

/// Flies the mission with four processes.
///
/// # Errors
/// If shared memory or a process cannot be had at all.
pub fn fly(args: &Args, outbox: &Outbox) -> Result<Flight, Failure> {
    let instance = Instance::new(&args.instance)?;
    instance.clean()?;
    let mut supervisor = Supervisor::start(args, &instance, outbox)?;
    let verdict = supervisor.watch(args);
    supervisor.end()?;
    let watched = supervisor.was_watched();
    let summary = match supervisor.summary() {
        Some(summary) => Some(summary),
        None => outbox.summary_of_journal()?,
    };
    drop(supervisor);
    instance.clean()?;
    let verdict = verdict.map_err(|failure| outbox.with_resumption(failure));
    Ok(Flight { summary, verdict, watched })
}

struct Supervisor {
    node: Node,
    heartbeats: Reader<Heartbeat>,
    roster: Roster,
    sim: Supervised,
    peers: Vec<Supervised>,
    /// When the last turn of the watch was, and when the supervisor itself last woke from a pause: the
    /// children's silence before that proves nothing.
    turned: MonotonicNs,
    woke: MonotonicNs,
    /// Since when the hopper holds for want of a process that was given up.
    holding: Option<MonotonicNs>,
    /// Whether a life of the monitor said that it failed.
    monitor_failed: bool,
}

impl Supervisor {
    fn start(args: &Args, instance: &Instance, outbox: &Outbox) -> Result<Self, Failure> {
        let mut node = Node::visit(instance)?;
        let mut heartbeats = node.reader(RobotId(0), false)?;
        let texts = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let mut sim = texts(&["sim", "--instance", &args.instance, "--format", "json"]);
        sim.extend(texts(&[
            "--seed",
            &args.mission.seed().to_string(),
            "--pace",
            &args.mission.pace.to_string(),
        ]));
        let scenario = outbox.dir().join("scenario.toml");
        sim.extend(texts(&["--scenario", &scenario.to_string_lossy()]));
        sim.extend(texts(&["--journal", &outbox.journal_dir().to_string_lossy()]));
        let mut monitor = texts(&["monitor", "--instance", &args.instance]);
        if let Some(address) = args.view.web {
            monitor.extend(texts(&["--web", &address.to_string()]));
        }
        if args.view.control {
            monitor.push("--control".into());
            sim.push("--control".into());
        }
        monitor.extend(recording(args, &scenario));
        let peer = |words: &[&str]| {
            let mut arguments = texts(words);
            arguments.extend(texts(&["--instance", &args.instance]));
            arguments
        };
        let mut monitor = Supervised::start(Role::Monitor, monitor)?;
        if args.record.record.is_some() {
            // Recorded is what is published once it listens.
            await_beat(&mut node, &mut heartbeats, &mut monitor)?;
        }
        Ok(Self {
            node,
            heartbeats,
            roster: Roster::default(),
            sim: Supervised::start(Role::HopperSim, sim)?,
            peers: vec![
                Supervised::start(Role::Perception, peer(&["perception"]))?,
                Supervised::start(Role::Planner, peer(&["planner", "--algorithm", &args.planner]))?,
                monitor,
            ],
            turned: Node::now(),
            woke: Node::now(),
            holding: None,
            monitor_failed: false,
        })
    }

    /// Watches until hopper-sim has ended; says whether it was interrupted.
    fn watch(&mut self, args: &Args) -> Result<bool, Failure> {
        loop {
            self.node.sleep(PERIOD);
            if Node::now().since_ns(self.turned) > SILENCE_NS {
                self.woke = Node::now();
            }
            self.turned = Node::now();
            if self.node.stop_requested() {
                return Ok(true);
            }
            for beat in self.heartbeats.drain().into_iter().flatten() {
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
            self.hold_for_help(args)?;
        }
    }

    fn revive_sim(&mut self, status: ExitStatus) -> Result<(), Failure> {
        if self.sim.restarts >= RESTARTS_MAX {
            return Err(Failure::new(
                Exit::Failed,
                format!("hopper-sim died {} times, last by {status}", RESTARTS_MAX + 1),
            ));
        }
        tracing::warn!("hopper-sim died ({status}): restarting it on its journal");
        self.sim.restart()
    }

    fn revive_peers(&mut self) -> Result<(), Failure> {
        for peer in &mut self.peers {
            let Some(status) = peer.ended()? else { continue };
            // Nobody needs a monitor to hop; but one that refuses from the first was asked for something it cannot do.
            let is_vital = |code: &i32| peer.role != Role::Monitor || (*code == 2 && peer.restarts == 0);
            if let Some(code @ (2 | 4)) = status.code().filter(is_vital) {
                return Err(gave_in(peer.role, code));
            }
            let finished = status.success();
            if finished {
                continue;
            }
            self.monitor_failed |= peer.role == Role::Monitor && failed(status);
            if peer.restarts < RESTARTS_MAX {
                tracing::warn!("{} died ({status}): restarting it", peer.role);
                peer.restart()?;
            } else if !peer.given_up {
                peer.given_up = true;
                tracing::error!(
                    "{} died {} times, last by {status}: giving it up",
                    peer.role,
                    RESTARTS_MAX + 1
                );
            }
        }
        Ok(())
    }

    /// Without perception or planner the hopper holds; help may come by hand, for as long as patience lasts.
    /// Nobody needs a monitor to hop.
    fn hold_for_help(&mut self, args: &Args) -> Result<(), Failure> {
        let now = Node::now();
        let wanted = |peer: &&Supervised| {
            peer.given_up && peer.role != Role::Monitor && !self.roster.has(peer.role, now)
        };
        let Some(role) = self.peers.iter().find(wanted).map(|peer| peer.role) else {
            self.holding = None;
            return Ok(());
        };
        let since = *self.holding.get_or_insert_with(|| {
            tracing::error!(
                "the hopper holds: start another by hand with `hopper {role} --instance {}`; waiting {:?}",
                args.instance,
                args.patience
            );
            now
        });
        if u128::from(now.since_ns(since)) < args.patience.as_nanos() {
            return Ok(());
        }
        let message =
            format!("the hopper held for {:?} for want of a {role}, and no help came", args.patience);
        Err(Failure::new(Exit::Failed, message))
    }

    fn kill_hung(&mut self) -> Result<(), Failure> {
        let now = Node::now();
        for child in self.peers.iter_mut().chain([&mut self.sim]) {
            let heard =
                self.roster.by_pid(child.pid()).map_or(child.started, |peer| peer.advanced).max(self.woke);
            if child.ended()?.is_none() && now.since_ns(heard) > HANG_NS {
                tracing::warn!("{} hangs: killing it", child.role);
                child.kill();
            }
        }
        Ok(())
    }

    /// Whether the monitor ended well: none of its lives said that it failed, nor was the last one killed.
    fn was_watched(&mut self) -> bool {
        let mut monitors = self.peers.iter_mut().filter(|peer| peer.role == Role::Monitor);
        let last_ended_well = monitors.all(|monitor| {
            let ended = monitor.ended().ok().flatten();
            ended.is_some_and(|status| status.code().is_some() && !failed(status))
        });
        last_ended_well && !self.monitor_failed
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

    /// The summary that hopper-sim wrote, with the supervisor's count of restarts; `None` if it wrote none.
    fn summary(&mut self) -> Option<Summary> {
        let mut summary: Summary = serde_json::from_str(&self.sim.output()).ok()?;
        let children: Vec<&Supervised> = std::iter::once(&self.sim).chain(&self.peers).collect();
        let own = children.iter().map(|child| Process {
            role: child.role,
            pid: child.pid(),
            restarts: child.restarts,
        });
        // Whoever came by hand is told too.
        let guests =
            summary.processes.iter().filter(|process| !children.iter().any(|child| child.is(process.pid)));
        summary.processes = own.chain(guests.copied()).collect();
        Some(summary)
    }
}

/// Waits until a child beats; not for ever, and not if it has ended or somebody wants to stop.
fn await_beat(
    node: &mut Node,
    heartbeats: &mut Reader<Heartbeat>,
    child: &mut Supervised,
) -> Result<(), Failure> {
    let deadline = Node::now().plus_ns(RECORDER_NS);
    while !heartbeats.drain().iter().flatten().any(|beat| beat.pid == child.pid()) {
        if child.ended()?.is_some() || node.stop_requested() {
            break;
        }
        if Node::now() >= deadline {
            tracing::warn!("the recorder does not beat: what happens until it does may not be recorded");
            break;
        }
        node.sleep(PERIOD);
    }
    Ok(())
}

/// Whether a process said that it failed: neither all went as asked, nor was it told to end.
fn failed(status: ExitStatus) -> bool {
    let as_asked = [Exit::Done, Exit::Interrupted].map(|exit| i32::from(exit.code()));
    status.code().is_some_and(|code| !as_asked.contains(&code))
}

/// What the monitor needs to know to record.
fn recording(args: &Args, scenario: &Path) -> Vec<String> {
    let Some(file) = &args.record.record else { return Vec::new() };
    let mut words = vec!["--record".into(), file.to_string_lossy().into_owned()];
    words.extend(["--record-scenario".into(), scenario.to_string_lossy().into_owned()]);
    for (key, value) in [
        ("seed", args.mission.seed().to_string()),
        ("pace", args.mission.pace.to_string()),
        ("commit", env!("HOPPER_COMMIT").to_owned()),
    ] {
        words.extend(["--record-note".into(), format!("{key}={value}")]);
    }
    words.extend(args.record.record_policies.then(|| "--record-policies".to_owned()));
    words
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
