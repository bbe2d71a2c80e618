//! Supervises the four processes of a mission: starts them, restarts those that die or hang, ends them.

use std::process::ExitStatus;
use std::time::Duration;

use contract::protocol::peer_table::SILENCE_NS;
use contract::{Heartbeat, MissingPeer, MonotonicNs, PeerTable, RobotId, RobotSet, Role, RunId, Team};
use hopper_sim::Journal;
use node::{Exit, Failure, Instance, Joining, LockHolder, Node};
use process::{Ports as _, Reader as _};
use report::{Process, Summary};

use super::OutputDir;
use super::child::{RESTART_WINDOW_NS, RESTARTS_MAX, Supervised};
use super::launch::Launch;

/// A child whose heartbeat has not advanced for this long counts as hung and is killed, nanoseconds.
const HANG_NS: u64 = 10 * SILENCE_NS;

/// How long a process holds the instance's lock at every look before it counts as in the way, nanoseconds.
const HOLD_UP_NS: u64 = 3 * SILENCE_NS;

/// How long children may take to end by themselves, nanoseconds.
const FAREWELL_NS: u64 = 3_000_000_000;

/// How long a mission that is to be recorded waits for the monitor's first heartbeat, nanoseconds.
const RECORDER_NS: u64 = 5_000_000_000;

/// Pause between two checks of the children.
const PERIOD: Duration = Duration::from_millis(20);

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
    instance.clean_patiently(Joining::patiently(launch.patience))?;
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
    if let Err(error) = instance.clean() {
        // What the mission came to is known, and reported.
        tracing::warn!("what is left of the instance could not be removed: {error}");
    }
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

/// A process that holds the instance's lock while a child waits for it.
#[derive(Debug)]
struct InTheWay {
    holder: LockHolder,
    /// When the holder was first seen; it was seen at every look since.
    since: MonotonicNs,
    /// Whether the log has named it.
    logged: bool,
}

struct Supervisor {
    node: Node,
    beats: node::Reader<Heartbeat>,
    peer_table: PeerTable,
    sim: Supervised,
    run: RunId,
    /// Decisions of the run that hopper-sim is known to have published.
    published: u64,
    /// Decisions of the run that earlier flights had published.
    published_before: u64,
    peers: Vec<Supervised>,
    /// When the children were last checked.
    turned: MonotonicNs,
    /// When the supervisor itself was last found to have been stopped; heartbeats missed before that prove nothing.
    woke: MonotonicNs,
    /// What has been missing that nobody will start again, and since when something has been.
    holding: Option<(MissingPeer, MonotonicNs)>,
    /// The robots that still act, as hopper-sim last told.
    acting: RobotSet,
    /// The robots as last published, read only where a program of the user's plans.
    teams: Option<node::Reader<Team>>,
    team: Option<Team>,
    /// When a decision was last published.
    advanced: MonotonicNs,
    /// The process that keeps a child from joining.
    in_the_way: Option<InTheWay>,
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
        let mut node = Node::visit_with(instance, Joining::patiently(launch.patience))?;
        let mut beats = node.reader(RobotId(0), false)?;
        let teams = launch.planner_command.as_ref().map(|_| node.reader(RobotId(0), false)).transpose()?;
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
        for (robot, planner) in (0..).map(RobotId).zip(&launch.planners) {
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
            acting: RobotSet::first(launch.planners.len() as u16),
            teams,
            team: None,
            advanced: Node::now(),
            in_the_way: None,
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
                    Some(1) if self.sim.restarts > 0 && !self.has_sim_joined() => self.revive_sim(status)?,
                    Some(0 | 1) => return Ok(false),
                    Some(130) => return Ok(true),
                    Some(code) => return Err(gave_in(Role::HopperSim, code)),
                    None => self.revive_sim(status)?,
                }
            }
            self.check_own(launch)?;
            self.revive_peers(launch)?;
            self.endure_hold_up(launch)?;
            self.kill_hung(launch)?;
            self.hold_for_help(launch)?;
        }
    }

    /// Takes note of all heartbeats.
    fn hear(&mut self) {
        for beat in self.beats.drain().into_iter().flatten() {
            if self.sim.is(beat.pid) && beat.run == self.run {
                if beat.decision.0 > self.published {
                    (self.published, self.advanced) = (beat.decision.0, Node::now());
                }
                self.acting = beat.robots;
            }
            if beat.role == Role::Planner {
                self.peers.iter_mut().for_each(|peer| peer.hear(beat.pid, Node::now()));
            }
            self.peer_table.observe(beat, Node::now());
        }
        let team = self.teams.as_mut().and_then(|teams| teams.newest()).and_then(Result::ok);
        self.team = team.filter(|team| team.run == self.run).or(self.team.take());
    }

    /// Whether the present hopper-sim has sent a heartbeat. One that has not and ends with an error could not join, which
    /// another may.
    fn has_sim_joined(&mut self) -> bool {
        self.hear();
        has_joined(&self.peer_table, &self.sim)
    }

    /// A process that was stopped while it joined, say, keeps others from joining. That lasts as long as patience does.
    fn endure_hold_up(&mut self, launch: &Launch) -> Result<(), Failure> {
        let now = Node::now();
        let mut waiting = None;
        for child in self.peers.iter_mut().chain([&mut self.sim]) {
            let has_time = now.since_ns(child.started) <= SILENCE_NS;
            if has_time || has_joined(&self.peer_table, child) || child.ended()?.is_some() {
                continue;
            }
            // A mission does without its monitor.
            let is_vital = child.role != Role::Monitor;
            if is_vital || waiting.is_none() {
                waiting = Some((is_vital, launch.name_of(child)));
            }
        }
        let is_of_interest = waiting.is_some() || self.in_the_way.is_some();
        let holder = if is_of_interest { self.node.instance().held_up_by() } else { None };
        let Some(holder) = holder else {
            self.in_the_way = None;
            return Ok(());
        };
        let known = self.in_the_way.take().filter(|known| known.holder.pid == holder.pid);
        let Some((is_vital, who)) = waiting else {
            // Whoever gave up waiting is started again, and the same process is still in its way.
            self.in_the_way = known;
            return Ok(());
        };
        let since = known.as_ref().map_or(now, |known| known.since);
        let lasts = now.since_ns(since);
        // Whoever makes its ports is seen at it many times, for a moment each.
        let is_in_the_way = holder.is_stopped || lasts >= HOLD_UP_NS;
        let was_logged = known.is_some_and(|known| known.logged);
        let patience = launch.patience;
        if is_vital && is_in_the_way && u128::from(lasts) >= patience.as_nanos() {
            let message = format!("{who} could not join for {patience:?}: in its way is {holder}");
            return Err(Failure::new(Exit::Failed, message));
        }
        if is_in_the_way && !was_logged {
            tracing::error!("{who} cannot join, for at most {patience:?}: in its way is {holder}");
        }
        self.in_the_way = Some(InTheWay { holder, since, logged: is_in_the_way || was_logged });
        Ok(())
    }

    /// What was published is never flown again: the next life gets that number.
    fn revive_sim(&mut self, status: ExitStatus) -> Result<(), Failure> {
        if !self.sim.may_restart(Node::now()) {
            return Err(Failure::new(Exit::Failed, format!("hopper-sim {}", died_too_often(status))));
        }
        tracing::warn!("hopper-sim died ({status}): restarting it on its journal");
        self.sim.restart_told(&["--published".into(), self.published.to_string().into()])
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
        let awaited = if launch.decides_within_patience() { self.awaits_first_command() } else { None };
        let advanced = self.advanced;
        for peer in self.peers.iter_mut().filter(|peer| peer.is_own()) {
            let beat = self.peer_table.live(now).find(|known| known.beat.pid == peer.beating_pid());
            let unplanned = beat.map_or(RobotSet::NONE, |known| peer.robots.without(known.beat.robots));
            let ended = peer.ended()?.filter(|status| status.code().is_some());
            let is_awaited = awaited.is_some_and(|robot| peer.robots.has(robot));
            let robots = if launch.planners.len() == 1 {
                String::new()
            } else {
                format!(" for robot {}", peer.robots)
            };
            let got = match (peer.joined(), ended) {
                (None, Some(status)) => {
                    format!("ended{robots} with {status} before it joined: its output above may say why")
                }
                (None, None) if is_over(peer.started) => {
                    format!("has not joined{robots} within {patience:?}")
                }
                (Some(_), None) if !unplanned.is_empty() => {
                    format!(
                        "joined and cannot plan for robot {unplanned} of this mission: its output above says what that needs"
                    )
                }
                (Some(joined), None) if is_awaited && is_over(joined.max(advanced)) => {
                    format!(
                        "joined and has not commanded{robots} within {patience:?}: its output above may say why; a planner \
                         commands robot HOPPER_ROBOT"
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

    /// The robot that is due, if nobody who lives has commanded it.
    fn awaits_first_command(&self) -> Option<RobotId> {
        let Some(team) = &self.team else {
            return (self.published == self.published_before).then_some(RobotId(0));
        };
        let leader = team.member(team.due)?.leader.incarnation;
        let is_led = self.peer_table.live(Node::now()).any(|peer| peer.beat.incarnation == leader);
        (!is_led).then_some(team.due)
    }

    fn revive_peers(&mut self, launch: &Launch) -> Result<(), Failure> {
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
                tracing::warn!("{} died ({status}): restarting it", launch.name_of(peer));
                peer.restart()?;
            } else {
                peer.given_up = true;
                tracing::error!("{} {}: giving it up", launch.name_of(peer), died_too_often(status));
            }
        }
        Ok(())
    }

    /// Without perception, or a planner of a robot that still acts, the mission holds. Somebody may start another by hand
    /// until patience runs out.
    fn hold_for_help(&mut self, launch: &Launch) -> Result<(), Failure> {
        let now = Node::now();
        // Once it has begun, a mission with a fallback goes on without anybody.
        let goes_on = launch.falls_back && self.published > 0;
        let missing = if goes_on { None } else { self.missing_for_good(now) };
        let Some(missing) = missing else {
            self.holding = None;
            return Ok(());
        };
        let (who, patience) = (launch.who_holds(), launch.patience);
        let since = self.holding.map_or(now, |(_, since)| since);
        if self.holding.is_none_or(|(known, _)| known != missing) {
            let commands = launch.commands_for(missing);
            tracing::error!(
                "{who} holds without {missing}: start another with {commands} within {patience:?}"
            );
        }
        self.holding = Some((missing, since));
        if u128::from(now.since_ns(since)) < patience.as_nanos() {
            return Ok(());
        }
        let message = format!("{who} held for {patience:?} without {missing}, and nobody started one");
        Err(Failure::new(Exit::Failed, message))
    }

    /// What the mission lacks, if no restart will bring it: who was given up, and who lives and cannot plan for its robots.
    fn missing_for_good(&self, now: MonotonicNs) -> Option<MissingPeer> {
        let given_up = |role| self.peers.iter().filter(move |peer| peer.role == role && peer.given_up);
        if given_up(Role::Perception).next().is_some() && !self.peer_table.has(Role::Perception, now) {
            return Some(MissingPeer::Perception);
        }
        let cannot_plan = |peer: &&Supervised| {
            let alive = self.peer_table.live(now).find(|known| known.beat.pid == peer.beating_pid());
            alive.is_some_and(|known| !peer.robots.without(known.beat.robots).is_empty())
        };
        let helpless = given_up(Role::Planner).chain(self.peers.iter().filter(cannot_plan));
        let robots = helpless.fold(RobotSet::NONE, |set, peer| set.union(peer.robots));
        let unplanned = self.peer_table.without_planner(robots.intersection(self.acting), now);
        (!unplanned.is_empty()).then_some(MissingPeer::Planner(unplanned))
    }

    fn kill_hung(&mut self, launch: &Launch) -> Result<(), Failure> {
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
            let is_in_the_way = self.in_the_way.as_ref().is_none_or(|known| child.is(known.holder.pid));
            if !is_in_the_way && !has_joined(&self.peer_table, child) {
                // It waits for the holder.
                continue;
            }
            if child.ended()?.is_none() && now.since_ns(heard) > HANG_NS {
                tracing::warn!("{} hangs (no heartbeat): killing it", launch.name_of(child));
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

/// Whether the child's present process has sent a heartbeat.
fn has_joined(peer_table: &PeerTable, child: &Supervised) -> bool {
    peer_table.by_pid(child.beating_pid()).is_some_and(|peer| peer.advanced >= child.started)
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
