//! Supervises the four processes of a mission: starts them, restarts those that die or hang, ends them.

use std::path::{Path, PathBuf};
use std::process::ExitStatus;
use std::time::Duration;

use contract::protocol::peer_table::SILENCE_NS;
use contract::{Heartbeat, MonotonicNs, Name, PeerTable, RobotId, Role, RunId};
use hopper_sim::{Journal, Pace};
use monitor::shell::ViewArgs;
use node::{Exit, Failure, Instance, Node};
use process::{Ports as _, Reader as _};
use report::{Process, Summary};

use super::OutputDir;
use super::child::{RESTART_WINDOW_NS, RESTARTS_MAX, Supervised};
use super::planner_command::PlannerCommand;

/// A child whose heartbeat has not advanced for this long counts as hung and is killed, nanoseconds.
const HANG_NS: u64 = 10 * SILENCE_NS;

/// How long children may take to end by themselves, nanoseconds.
const FAREWELL_NS: u64 = 3_000_000_000;

/// How long a mission that is to be recorded waits for the monitor's first heartbeat, nanoseconds.
const RECORDER_NS: u64 = 5_000_000_000;

/// Pause between two checks of the children.
const PERIOD: Duration = Duration::from_millis(20);

/// What the processes are started with.
#[derive(Clone, Debug)]
pub struct Launch {
    /// Instance that all four join.
    pub instance: String,
    /// Algorithm of each robot's planner, in the order of their numbers. Every robot has a process of its own.
    pub planners: Vec<Name>,
    /// The program that is each robot's planner in place of those algorithms.
    pub planner_command: Option<PlannerCommand>,
    /// Seed of the draws; the scenario itself is read from the output folder.
    pub seed: u64,
    /// Landings a second at most, simulated by hopper-sim.
    pub pace: Pace,
    /// The page that the monitor serves, if it does, and whether hopper-sim obeys orders and the monitor gives them.
    pub view: ViewArgs,
    /// What the monitor records, if it does.
    pub recording: Option<Recording>,
    /// How long the hopper holds when a process it needs was given up, or its journal is displaced, before the mission is
    /// stopped.
    pub patience: Duration,
}

/// The recording that the monitor makes.
#[derive(Clone, Debug)]
pub struct Recording {
    /// File to write, which must not exist yet.
    pub file: PathBuf,
    /// Whether policies are recorded too.
    pub with_policies: bool,
}

/// A mission flown by four processes.
#[derive(Debug)]
pub struct Flight {
    /// The summary; `None` if no decision was executed.
    pub summary: Option<Summary>,
    /// Whether it was interrupted, or the reason why it was stopped.
    pub verdict: Result<bool, Failure>,
    /// Whether the monitor ended without an error; only then is a recording complete.
    pub watched: bool,
    /// The monitor, if it serves its page on.
    pub page: Option<Supervised>,
}

/// Flies the mission with four processes. The `journal` is held until hopper-sim takes it over.
///
/// # Errors
/// If shared memory cannot be opened, or a process cannot be started.
pub fn fly(launch: &Launch, output_dir: &OutputDir, journal: Journal) -> Result<Flight, Failure> {
    let flown = supervise(launch, output_dir, journal);
    let refused = |failure: &Failure| matches!(failure.exit, Exit::Usage | Exit::Peer);
    if flown.as_ref().map_or(true, |flight| flight.verdict.as_ref().is_err_and(refused)) {
        output_dir.withdraw();
    }
    flown
}

fn supervise(launch: &Launch, output_dir: &OutputDir, journal: Journal) -> Result<Flight, Failure> {
    let instance = Instance::new(&launch.instance)?;
    instance.clean()?;
    let mut supervisor = Supervisor::start(launch, &instance, output_dir, journal)?;
    let verdict = supervisor.watch(launch).map_err(|failure| output_dir.with_resumption(failure));
    let serves_on = launch.view.serves_on() && verdict == Ok(false);
    supervisor.end(serves_on)?;
    let watched = supervisor.was_watched();
    let (printed, published) = (supervisor.summary(), supervisor.published);
    let verdict = match supervisor.sim.ended()?.and_then(|status| status.code()) {
        // It ends with this code when the mission failed too, but not before it has printed a summary.
        Some(1) if printed.is_none() && verdict == Ok(false) => Err(gave_in(Role::HopperSim, 1)),
        _ => verdict,
    };
    let page = supervisor.page();
    drop(supervisor);
    instance.clean()?;
    let summary = match (printed, &verdict) {
        // A program of the user's was refused, and hopper-sim ended in order.
        (Some(Summary { decisions: 0, .. }), Err(failure)) if failure.exit == Exit::Usage => None,
        (Some(summary), _) => Some(summary),
        (None, Ok(_)) => output_dir.summary_of_journal(published)?,
        // Whoever was refused has flown nothing.
        (None, Err(failure)) if matches!(failure.exit, Exit::Usage | Exit::Peer) => None,
        (None, Err(_)) => output_dir.summary_of_journal(published).unwrap_or_default(),
    };
    Ok(Flight { summary, verdict, watched, page })
}

impl Launch {
    fn words(&self, words: &[&str]) -> Vec<String> {
        words.iter().copied().chain(["--instance", &self.instance]).map(str::to_owned).collect()
    }

    fn sim(&self, output_dir: &OutputDir) -> Vec<String> {
        let mut words = self.words(&["sim", "--format", "json"]);
        for (flag, value) in [
            ("--seed", self.seed.to_string()),
            ("--pace", self.pace.to_string()),
            ("--scenario", text(&output_dir.scenario())),
            ("--journal", text(&output_dir.journal_dir())),
            ("--resume-run", output_dir.run().to_string()),
            ("--patience", format!("{}ns", self.patience.as_nanos())),
        ] {
            words.extend([flag.to_owned(), value]);
        }
        words.extend(self.view.control.then(|| "--control".to_owned()));
        words
    }

    /// The planner of a robot.
    fn planner(&self, program: &Path, robot: usize, algorithm: Name) -> Result<Supervised, Failure> {
        let robot = robot.to_string();
        match &self.planner_command {
            Some(command) => {
                let environment = vec![("HOPPER_INSTANCE", self.instance.clone()), ("HOPPER_ROBOT", robot)];
                Supervised::start_own(command.program(), command.arguments().to_vec(), environment)
            }
            None => {
                let words = ["planner", "--algorithm", algorithm.as_str(), "--robot", &robot];
                Supervised::start(program, Role::Planner, self.words(&words))
            }
        }
    }

    /// Whether a mission that goes on takes a decision within its patience, whatever its pace.
    fn decides_within_patience(&self) -> bool {
        !self.view.control && self.pace == Pace::Max
    }

    fn monitor(&self, output_dir: &OutputDir) -> Vec<String> {
        let mut words = self.words(&["monitor"]);
        let ViewArgs { web, ref web_host, web_exit, open, control } = self.view;
        words.extend(web.into_iter().flat_map(|address| ["--web".to_owned(), address.to_string()]));
        words.extend(web_host.iter().flat_map(|name| ["--web-host".to_owned(), name.clone()]));
        // Without a page, orders come from monitors started by hand.
        for (flag, is_set) in [("--control", control), ("--web-exit", web_exit), ("--open", open)] {
            words.extend((is_set && web.is_some()).then(|| flag.to_owned()));
        }
        let Some(recording) = &self.recording else { return words };
        words.extend(["--record".into(), text(&recording.file)]);
        words.extend(["--record-scenario".into(), text(&output_dir.scenario())]);
        for (key, value) in [
            ("seed", self.seed.to_string()),
            ("pace", self.pace.to_string()),
            ("commit", crate::COMMIT.to_owned()),
        ] {
            words.extend(["--record-note".into(), format!("{key}={value}")]);
        }
        words.extend(recording.with_policies.then(|| "--record-policies".to_owned()));
        words
    }
}

/// `path` as an argument.
fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

struct Supervisor {
    node: Node,
    beats: node::Reader<Heartbeat>,
    peer_table: PeerTable,
    sim: Supervised,
    run: RunId,
    /// Decisions of the run that hopper-sim is known to have published.
    published: u64,
    /// Those of its earlier flights.
    published_before: u64,
    peers: Vec<Supervised>,
    /// When the children were last checked.
    turned: MonotonicNs,
    /// When the supervisor itself was last found to have been stopped; heartbeats missed before that prove nothing.
    woke: MonotonicNs,
    /// Since when the hopper has been holding because a process it needs was given up.
    holding: Option<MonotonicNs>,
    /// Whether any monitor process exited with an error.
    monitor_failed: bool,
}

impl Supervisor {
    fn start(
        launch: &Launch,
        instance: &Instance,
        output_dir: &OutputDir,
        journal: Journal,
    ) -> Result<Self, Failure> {
        let mut node = Node::visit(instance)?;
        let mut beats = node.reader(RobotId(0), false)?;
        let program = std::env::current_exe().map_err(Failure::run)?;
        let published = journal.len();
        let start = |role, words| Supervised::start(&program, role, words);
        let mut monitor = start(Role::Monitor, launch.monitor(output_dir))?;
        if launch.recording.is_some() {
            // Only messages published after it has joined are recorded.
            await_heartbeat(&mut node, &mut beats, &mut monitor)?;
        }
        // From here on hopper-sim holds it; until then nobody else did.
        drop(journal);
        let sim = start(Role::HopperSim, launch.sim(output_dir))?;
        let mut peers = vec![start(Role::Perception, launch.words(&["perception"]))?];
        for (robot, planner) in launch.planners.iter().enumerate() {
            peers.push(launch.planner(&program, robot, *planner)?);
        }
        peers.push(monitor);
        Ok(Self {
            node,
            beats,
            peer_table: PeerTable::default(),
            run: output_dir.run(),
            published,
            published_before: published,
            sim,
            peers,
            turned: Node::now(),
            woke: Node::now(),
            holding: None,
            monitor_failed: false,
        })
    }

    /// Returns once hopper-sim has ended, with whether the mission was interrupted.
    fn watch(&mut self, launch: &Launch) -> Result<bool, Failure> {
        loop {
            self.node.sleep(PERIOD);
            if Node::now().since_ns(self.turned) > SILENCE_NS {
                self.woke = Node::now();
            }
            self.turned = Node::now();
            if self.node.stop_requested() {
                return Ok(true);
            }
            self.hear();
            if let Some(status) = self.sim.ended()? {
                match status.code() {
                    Some(0 | 1) => return Ok(false),
                    Some(130) => return Ok(true),
                    Some(code) => return Err(gave_in(Role::HopperSim, code)),
                    None => self.revive_sim(status)?,
                }
            }
            self.check_own(launch)?;
            self.revive_peers()?;
            self.kill_hung()?;
            self.hold_for_help(launch)?;
        }
    }

    /// Takes note of all heartbeats.
    fn hear(&mut self) {
        for beat in self.beats.drain().into_iter().flatten() {
            if self.sim.is(beat.pid) && beat.run == self.run {
                self.published = self.published.max(beat.decision.0);
            }
            if beat.role == Role::Planner {
                self.peers.iter_mut().for_each(|peer| peer.hear(beat.pid, Node::now()));
            }
            self.peer_table.observe(beat, Node::now());
        }
    }

    /// What was published is never flown again: the next life gets that number.
    fn revive_sim(&mut self, status: ExitStatus) -> Result<(), Failure> {
        if !self.sim.may_restart(Node::now()) {
            return Err(Failure::new(Exit::Failed, format!("hopper-sim {}", died_too_often(status))));
        }
        tracing::warn!("hopper-sim died ({status}): restarting it on its journal");
        self.sim.restart_told(&["--published".into(), self.published.to_string()])
    }

    /// Stops the mission if a program of the user's ends before it has joined, never joins, or joins and never commands:
    /// another start would change nothing.
    fn check_own(&mut self, launch: &Launch) -> Result<(), Failure> {
        let Some(command) = &launch.planner_command else { return Ok(()) };
        let (now, instance, patience) = (Node::now(), &launch.instance, launch.patience);
        let is_over = |since: MonotonicNs| u128::from(now.since_ns(since)) > patience.as_nanos();
        let mut ends = Vec::new();
        for peer in self.peers.iter_mut().filter(|peer| peer.is_own() && peer.joined().is_none()) {
            ends.extend(peer.ended()?.filter(|status| status.code().is_some()));
        }
        if !ends.is_empty() {
            // Its heartbeats may have come meanwhile.
            self.hear();
        }
        let stands = self.published == self.published_before && launch.decides_within_patience();
        for peer in self.peers.iter_mut().filter(|peer| peer.is_own()) {
            let ended = peer.ended()?.filter(|status| status.code().is_some());
            let got = match (peer.joined(), ended) {
                (None, Some(status)) => {
                    format!("ended with {status} before it joined: its output above may say why")
                }
                (None, None) if is_over(peer.started) => format!("has not joined within {patience:?}"),
                (Some(joined), None) if stands && is_over(joined) => {
                    format!(
                        "joined and has not commanded within {patience:?}: its output above may say why; a planner commands \
                         robot HOPPER_ROBOT"
                    )
                }
                _ => continue,
            };
            return Err(Failure::usage(format!(
                "--planner-command needs a program that joins instance {instance:?} (HOPPER_INSTANCE) by planner::main \
                 in Rust or hopper.fly in Python, got {command:?}, which {got}",
                command = command.to_string()
            )));
        }
        Ok(())
    }

    fn revive_peers(&mut self) -> Result<(), Failure> {
        for peer in &mut self.peers {
            let Some(status) = peer.ended()? else { continue };
            // A mission does not need its monitor, but one that refuses its arguments was given wrong ones.
            let is_vital = |code: &i32| peer.role != Role::Monitor || (*code == 2 && peer.restarts == 0);
            if let Some(code @ (2 | 4)) = status.code().filter(is_vital) {
                return Err(gave_in(peer.role, code));
            }
            let last = self.peer_table.by_pid(peer.beating_pid());
            // A program of the user's may leave a mission that goes on.
            let finished = !peer.is_own() || last.is_none_or(|peer| peer.beat.status.is_over());
            if status.success() && finished {
                continue;
            }
            self.monitor_failed |= peer.role == Role::Monitor && failed(status);
            if peer.given_up {
                continue;
            }
            if peer.may_restart(Node::now()) {
                tracing::warn!("{} died ({status}): restarting it", peer.role);
                peer.restart()?;
            } else {
                peer.given_up = true;
                tracing::error!("{} {}: giving it up", peer.role, died_too_often(status));
            }
        }
        Ok(())
    }

    /// Without perception or planner the hopper holds. Somebody may start another by hand until patience runs out.
    fn hold_for_help(&mut self, launch: &Launch) -> Result<(), Failure> {
        let now = Node::now();
        let wanted = |peer: &&Supervised| {
            peer.given_up && peer.role != Role::Monitor && !self.peer_table.has(peer.role, now)
        };
        let Some(role) = self.peers.iter().find(wanted).map(|peer| peer.role) else {
            self.holding = None;
            return Ok(());
        };
        let since = *self.holding.get_or_insert_with(|| {
            tracing::error!(
                "the hopper holds: start another {role} with `hopper {role} --instance {}` within {:?}",
                launch.instance,
                launch.patience
            );
            now
        });
        if u128::from(now.since_ns(since)) < launch.patience.as_nanos() {
            return Ok(());
        }
        let message =
            format!("the hopper held for {:?} without a {role}, and nobody started one", launch.patience);
        Err(Failure::new(Exit::Failed, message))
    }

    fn kill_hung(&mut self) -> Result<(), Failure> {
        let now = Node::now();
        for child in self.peers.iter_mut().chain([&mut self.sim]) {
            if child.is_own() && child.joined().is_none() {
                // An interpreter may take its time to begin; its end is that of patience.
                continue;
            }
            let heard = self
                .peer_table
                .by_pid(child.beating_pid())
                .map_or(child.started, |peer| peer.advanced)
                .max(self.woke);
            if child.ended()?.is_none() && now.since_ns(heard) > HANG_NS {
                tracing::warn!("{} hangs (no heartbeat): killing it", child.role);
                child.kill();
            }
        }
        Ok(())
    }

    /// Whether every monitor process exited without an error, and the last one was not killed.
    fn was_watched(&mut self) -> bool {
        let mut monitors = self.peers.iter_mut().filter(|peer| peer.role == Role::Monitor);
        let last_ended_well = monitors.all(|monitor| {
            let ended = monitor.ended().ok().flatten();
            ended.is_none() && monitor.has_spoken()
                || ended.is_some_and(|status| status.code().is_some() && !failed(status))
        });
        last_ended_well && !self.monitor_failed
    }

    /// Waits for all children to exit, and kills those that do not; a monitor that `serves_on` only needs to have said
    /// so.
    fn end(&mut self, serves_on: bool) -> Result<(), Failure> {
        let stays = |child: &Supervised| serves_on && child.role == Role::Monitor;
        for child in self.peers.iter_mut().chain([&mut self.sim]).filter(|child| !stays(child)) {
            child.release();
        }
        let deadline = Node::now().plus_ns(FAREWELL_NS);
        while Node::now() < deadline && self.any_is_alive()? {
            std::thread::sleep(Duration::from_millis(2));
        }
        for child in self.peers.iter_mut().chain([&mut self.sim]) {
            if child.ended()?.is_none() && !(stays(child) && child.has_spoken()) {
                tracing::warn!("{} does not exit: killing it", child.role);
                child.kill();
            }
        }
        Ok(())
    }

    /// The monitor, if it is alive and serves its page on.
    fn page(&mut self) -> Option<Supervised> {
        let serves = |peer: &mut Supervised| {
            peer.role == Role::Monitor && peer.has_spoken() && peer.ended().is_ok_and(|ended| ended.is_none())
        };
        let at = self.peers.iter_mut().position(serves)?;
        Some(self.peers.remove(at))
    }

    /// Whether a child is there that has not ended, nor said that all but its page is done.
    fn any_is_alive(&mut self) -> Result<bool, Failure> {
        for child in self.peers.iter_mut().chain([&mut self.sim]) {
            if child.ended()?.is_none() && !(child.role == Role::Monitor && child.has_spoken()) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The summary that hopper-sim printed, with restarts as counted here; `None` if it printed none.
    fn summary(&mut self) -> Option<Summary> {
        let mut summary: Summary = serde_json::from_str(&self.sim.output()).ok()?;
        let children: Vec<&Supervised> = std::iter::once(&self.sim).chain(&self.peers).collect();
        let own = children.iter().map(|child| Process {
            role: child.role,
            pid: child.pid(),
            restarts: child.restarts,
        });
        // Processes that were started by hand.
        let guests =
            summary.processes.iter().filter(|process| !children.iter().any(|child| child.is(process.pid)));
        summary.processes = own.chain(guests.copied()).collect();
        Some(summary)
    }
}

/// Waits for the first heartbeat of `child`, unless it ends, the command is interrupted, or [`RECORDER_NS`] pass.
fn await_heartbeat(
    node: &mut Node,
    beats: &mut node::Reader<Heartbeat>,
    child: &mut Supervised,
) -> Result<(), Failure> {
    let deadline = Node::now().plus_ns(RECORDER_NS);
    let mut is_heard = |pid| beats.drain().into_iter().flatten().any(|beat| beat.pid == pid);
    while !is_heard(child.pid()) {
        if child.ended()?.is_some() || node.stop_requested() {
            break;
        }
        if Node::now() >= deadline {
            tracing::warn!(
                "no heartbeat of the monitor yet: the first messages may be missing from the recording"
            );
            break;
        }
        node.sleep(PERIOD);
    }
    Ok(())
}

fn died_too_often(status: ExitStatus) -> String {
    let window = Duration::from_nanos(RESTART_WINDOW_NS);
    format!("died {} times within {window:?}, the last time with {status}", RESTARTS_MAX + 1)
}

/// Whether a process exited with an error: neither done nor interrupted.
fn failed(status: ExitStatus) -> bool {
    let without_error = [Exit::Done, Exit::Interrupted].map(|exit| i32::from(exit.code()));
    status.code().is_some_and(|code| !without_error.contains(&code))
}

/// Exit codes 2 and 4 are not worth a restart: the process would exit the same way again.
fn gave_in(role: Role, code: i32) -> Failure {
    let exit = match code {
        2 => Exit::Usage,
        4 => Exit::Peer,
        _ => Exit::Failed,
    };
    Failure::new(exit, format!("{role} exited with code {code}: its log above says why"))
}
