//! Inspecting an instance from outside: who is there, who is dead, what is missing.

use std::time::Duration;

use contract::protocol::peer_table::{LISTENING_NS, SILENCE_NS};
use contract::{
    Brief, Heartbeat, Incarnation, Leader, MissingPeer, MonotonicNs, Name, PeerTable, Profile, RobotId,
    RobotSet, Role, RunId, State, Status, Team,
};
use iceoryx2::node::NodeView;
use iceoryx2::prelude::{CallbackProgression, Node as MiddlewareNode, NodeState, Service};
use process::{Ports, Reader as _, TICK_NS};
use serde::Serialize;

use crate::error::NodeError;
use crate::membership::foreign::ForeignFile;
use crate::membership::instance::Instance;
use crate::memory_budget::{MemoryBudget, free_bytes};
use crate::middleware::Ipc;
use crate::node::Node;
use crate::signature;

/// Longest sleep while listening.
const TICK: Duration = Duration::from_nanos(TICK_NS);

/// How the middleware sees a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NodeHealth {
    /// It holds its lock, which a stopped process does too.
    Alive,
    /// It died, and what it left behind is not freed yet.
    Dead,
    /// Its state cannot be read.
    Inaccessible,
}

/// One process as the middleware knows it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NodeReport {
    /// The name it joined with: a role, or `visitor`.
    pub name: String,
    /// Process number, where known.
    pub pid: Option<u32>,
    /// Path of its executable, `?` where unknown.
    pub executable: String,
    /// Whether it is alive, as the middleware sees it.
    pub health: NodeHealth,
}

/// One process according to its heartbeats.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ProcessReport {
    /// The role it joined in.
    pub role: Role,
    /// Number of the process.
    pub pid: u32,
    /// Version of its build.
    pub version: Name,
    /// Algorithm of a planner, empty of others.
    pub planner: Name,
    /// The robots that a planner plans for; of hopper-sim those that still act.
    pub robots: Vec<RobotId>,
    /// Whether it commands a robot.
    pub leads: bool,
    /// Heartbeats it has sent.
    pub counter: u64,
    /// The run it last saw.
    pub run: RunId,
    /// The decision it last saw.
    pub decision: u64,
    /// The status it last saw.
    pub status: Status,
    /// Time since its last heartbeat, milliseconds.
    pub age_ms: u64,
}

/// The mission according to its brief and state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MissionReport {
    /// Name of the scenario.
    pub scenario: Name,
    /// The reading of the model that the scenario uses.
    pub profile: Profile,
    /// Columns and rows, cells.
    pub grid: [u32; 2],
    /// Nonce of the run.
    pub run: RunId,
    /// `None` before the first state.
    pub progress: Option<Progress>,
}

/// Where the mission stands.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Progress {
    /// Number of the decision that is due.
    pub decision: u64,
    /// Steps so far, in the paper's count.
    pub steps: u64,
    /// Whether the mission is under way, or how it ended.
    pub status: Status,
    /// Who commands, under which term.
    pub leader: Leader,
}

/// One service as it was created.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ServiceReport {
    /// Name, such as `hop/state`.
    pub name: String,
    /// Types and quality of service.
    pub kind: String,
    /// Processes that have it open.
    pub nodes: usize,
}

/// Shared memory of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// Bytes the instance uses.
    pub used_bytes: u64,
    /// Bytes its mission needs in all, known once there is a brief.
    pub need_bytes: Option<u64>,
    /// Bytes that are still free.
    pub free_bytes: u64,
}

/// Everything about one instance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Name of the instance; `?` if it was left without one.
    pub instance: String,
    /// Whether a process of it lives.
    pub alive: bool,
    /// Processes that the middleware knows, visitors included.
    pub nodes: Vec<NodeReport>,
    /// Processes that send heartbeats.
    pub processes: Vec<ProcessReport>,
    /// `None` without a brief.
    pub mission: Option<MissionReport>,
    /// Its services, sorted by name.
    pub services: Vec<ServiceReport>,
    /// Shared memory it uses and needs.
    pub memory: Memory,
    /// Files that nobody alive owns, if no process lives.
    pub leftovers: Vec<String>,
    /// Files of other users that bear the instance's name.
    pub foreign: Vec<ForeignFile>,
    /// What to do next, most urgent first.
    pub advice: Vec<String>,
}

/// Inspects an instance. If it is alive, this listens for heartbeats for 0.4 s.
///
/// # Errors
/// If the instance cannot be visited or shared memory cannot be listed.
pub fn inspect(instance: &Instance) -> Result<Report, NodeError> {
    let alive = instance.is_alive()?;
    let files = instance.files();
    let mut report = Report {
        instance: instance.name().into(),
        alive,
        nodes: if instance.exists() { nodes(instance)? } else { Vec::new() },
        processes: Vec::new(),
        mission: None,
        services: Vec::new(),
        memory: Memory {
            used_bytes: files.iter().map(|(_, bytes)| bytes).sum(),
            need_bytes: None,
            free_bytes: free_bytes()?,
        },
        leftovers: Vec::new(),
        foreign: instance.foreign_files()?,
        advice: Vec::new(),
    };
    if alive {
        match report.listen(instance) {
            // What is known without joining is reported all the same.
            Err(
                error @ (NodeError::NoRoom { .. } | NodeError::ForeignFile { .. } | NodeError::Busy { .. }),
            ) => report.advice.push(format!("nobody can join: {error}")),
            listened => listened?,
        }
    } else {
        let folder = instance.exists().then(|| instance.root().to_path_buf());
        let paths = files.into_iter().map(|(path, _)| path).chain(folder);
        report.leftovers = paths.map(|path| path.display().to_string()).collect();
    }
    report.advise();
    let files = report.foreign.iter().map(|file| {
        format!("{file} keeps everybody out: its owner or root removes it, with `hopper doctor --instance {} --clean`", report.instance)
    });
    report.advice = files.chain(report.advice).collect();
    Ok(report)
}

/// The services of an instance, sorted by name.
///
/// # Errors
/// If they cannot be listed.
pub fn services(instance: &Instance) -> Result<Vec<ServiceReport>, NodeError> {
    let mut services = Vec::new();
    Ipc::list(&instance.config(), |details| {
        services.push(ServiceReport {
            name: details.static_details.name().to_string(),
            kind: signature::of_existing(&details.static_details),
            nodes: details.dynamic_details.map_or(0, |dynamic| dynamic.nodes.len()),
        });
        CallbackProgression::Continue
    })
    .map_err(|error| NodeError::Middleware { what: "listing services", cause: error.to_string() })?;
    services.sort_by(|a, b| (&a.name, &a.kind).cmp(&(&b.name, &b.kind)));
    Ok(services)
}

/// The processes of an instance as the middleware knows them, including dead ones that are not cleaned up yet.
///
/// # Errors
/// If they cannot be listed.
pub fn nodes(instance: &Instance) -> Result<Vec<NodeReport>, NodeError> {
    let mut nodes = Vec::new();
    let mut note = |view: Option<&dyn NodeView>, health| {
        let details = view.and_then(|view| view.details().as_ref());
        nodes.push(NodeReport {
            name: details.map_or_else(|| "?".into(), |details| details.name().to_string()),
            pid: details.and_then(|details| u32::try_from(details.process_id().value()).ok()),
            executable: details.map_or_else(|| "?".into(), |details| details.executable().to_string()),
            health,
        });
    };
    MiddlewareNode::<Ipc>::list(&instance.config(), |state| {
        match &state {
            NodeState::Alive(view) => note(Some(view), NodeHealth::Alive),
            NodeState::Dead(view) => note(Some(view), NodeHealth::Dead),
            NodeState::Inaccessible(_) | NodeState::Undefined(_) => note(None, NodeHealth::Inaccessible),
        }
        CallbackProgression::Continue
    })
    .map_err(|error| NodeError::Middleware { what: "listing nodes", cause: error.to_string() })?;
    nodes.sort_by(|a, b| (&a.name, a.pid).cmp(&(&b.name, b.pid)));
    Ok(nodes)
}

impl Report {
    /// Fills in what only messages show.
    fn listen(&mut self, instance: &Instance) -> Result<(), NodeError> {
        let mut visitor = Node::visit(instance)?;
        let robot = RobotId(0);
        let mut briefs = visitor.reader::<Brief>(robot, false)?;
        let mut states = visitor.reader::<State>(robot, false)?;
        let mut teams = visitor.reader::<Team>(robot, false)?;
        let mut heartbeats = visitor.reader::<Heartbeat>(robot, false)?;
        let mut peer_table = PeerTable::default();
        let (mut brief, mut state, mut team) = (None::<Brief>, None::<State>, None::<Team>);
        let until = Node::now().plus_ns(LISTENING_NS);
        while Node::now() < until && !visitor.stop_requested() {
            visitor.sleep(TICK);
            for beat in heartbeats.drain().into_iter().flatten() {
                peer_table.observe(beat, Node::now());
            }
            brief = briefs.newest().and_then(Result::ok).or(brief);
            state = states.newest().and_then(Result::ok).or(state);
            team = teams.newest().and_then(Result::ok).or(team);
        }
        let team = team.filter(|team| state.is_some_and(|state| state.run == team.run));
        let leads = |life| match &team {
            Some(team) => team.led_by(life).next().is_some(),
            None => state.is_some_and(|state| state.leader.incarnation == life),
        };
        self.processes = processes(&peer_table, leads, Node::now());
        self.services = services(instance)?;
        if let Some(brief) = brief {
            let budget = MemoryBudget::of(brief.grid.cells(), brief.robots.count())?;
            self.memory.need_bytes = Some(budget.need_bytes);
            self.mission = Some(mission(&brief, state.as_ref()));
        }
        Ok(())
    }

    fn advise(&mut self) {
        if !self.advice.is_empty() {
            return;
        }
        let name = &self.instance;
        let mut advice = Vec::new();
        if !self.alive {
            advice.push(if self.leftovers.is_empty() {
                format!(
                    "nothing runs: start `hopper sim --instance {name}`, or all at once with `hopper run --instance {name}`"
                )
            } else {
                format!("left over, nobody lives: remove with `hopper doctor --instance {name} --clean`")
            });
            self.advice = advice;
            return;
        }
        let over = self.mission.as_ref().and_then(|mission| mission.progress.as_ref());
        let over = over.map(|progress| progress.status).filter(|status| status.is_over());
        if let Some(status) = over {
            advice.push(format!("the mission is over ({status}); the processes end by themselves"));
        }
        if over.is_none() {
            advice.extend(self.absences());
        }
        for node in &self.nodes {
            let (who, pid) = (&node.name, node.pid.unwrap_or(0));
            let silent = who != "visitor" && !self.processes.iter().any(|process| process.pid == pid);
            match node.health {
                NodeHealth::Alive if silent => advice.push(format!(
                    "{who} (process {pid}) lives but does not beat: it is starting, hangs or is stopped"
                )),
                NodeHealth::Dead => {
                    advice.push(format!("{who} (process {pid}) died: the others free it within a second"));
                }
                _ => {}
            }
        }
        let mut versions: Vec<_> = self.processes.iter().map(|process| process.version).collect();
        versions.sort();
        versions.dedup();
        if versions.len() > 1 {
            let versions: Vec<_> = versions.iter().map(ToString::to_string).collect();
            advice.push(format!("versions differ ({}): restart the older ones", versions.join(", ")));
        }
        let Memory { used_bytes, need_bytes, free_bytes } = self.memory;
        if need_bytes.is_some_and(|need| need > used_bytes + free_bytes) {
            advice.push(
                "shared memory is short: enlarge it (in a container, --shm-size) or shrink the grid".into(),
            );
        }
        self.advice = advice;
    }
}

impl Report {
    /// Who is missing, and the command that starts it. Without a hopper-sim nobody knows which robots act.
    fn absences(&self) -> Vec<String> {
        let name = &self.instance;
        let of = |role| self.processes.iter().filter(move |process| process.role == role);
        let mut absences = Vec::new();
        for (role, command) in [
            (Role::HopperSim, "hopper sim"),
            (Role::Perception, "hopper perception"),
            (Role::Planner, "hopper planner"),
            (Role::Monitor, "hopper monitor"),
        ] {
            let acting = of(Role::HopperSim).flat_map(|sim| &sim.robots);
            let planned = |robot: &&RobotId| of(Role::Planner).any(|planner| planner.robots.contains(robot));
            let unplanned =
                acting.filter(|robot| !planned(robot)).fold(RobotSet::NONE, |set, robot| set.with(*robot));
            if role == Role::Planner && !unplanned.is_empty() {
                let missing = MissingPeer::Planner(unplanned);
                let (command, others) = (missing.command(Some(name)), missing.and_others());
                absences.push(format!("{missing} is missing: start `{command}`{others}"));
            } else if of(role).next().is_none() {
                absences.push(format!("no {role} beats: start `{command} --instance {name}`"));
            }
        }
        absences
    }
}

fn processes(
    peer_table: &PeerTable,
    leads: impl Fn(Incarnation) -> bool,
    now: MonotonicNs,
) -> Vec<ProcessReport> {
    let mut processes: Vec<_> = peer_table
        .live(now)
        .map(|peer| {
            let beat = peer.beat;
            ProcessReport {
                role: beat.role,
                pid: beat.pid,
                version: beat.version,
                planner: beat.planner,
                robots: beat.robots.iter().collect(),
                leads: leads(beat.incarnation),
                counter: beat.counter,
                run: beat.run,
                decision: beat.decision.0,
                status: beat.status,
                age_ms: now.since_ns(peer.advanced).min(SILENCE_NS) / 1_000_000,
            }
        })
        .collect();
    processes.sort_by_key(|process| (process.role, process.pid));
    processes
}

fn mission(brief: &Brief, state: Option<&State>) -> MissionReport {
    let state = state.filter(|state| state.run == brief.run);
    MissionReport {
        scenario: brief.scenario,
        profile: brief.profile,
        grid: [brief.grid.width, brief.grid.height],
        run: brief.run,
        progress: state.map(|state| Progress {
            decision: state.decision.0,
            steps: state.steps,
            status: state.status,
            leader: state.leader,
        }),
    }
}
