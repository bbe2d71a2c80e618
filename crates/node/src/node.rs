//! A process's membership of an instance: its ports, its sleep, its heartbeat.

use std::os::fd::BorrowedFd;
use std::rc::Rc;
use std::time::Duration;

use contract::limits::MAP_PATCH_CELLS;
use contract::roster::BEAT_PERIOD_NS;
use contract::service::{self, Exchange, Topic};
use contract::{Decision, Heartbeat, Incarnation, MonotonicNs, Name, Refusal, RobotId, Role, RunId, Status};
use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::FileDescriptorBased;
use rustix::event::{PollFd, PollFlags};

use crate::base::{Base, Ipc};
use crate::exchange::{
    Client, PastClient, PastServer, Server, SnapshotClient, SnapshotServer, TruthClient, TruthServer,
    answered, asked,
};
use crate::janitor::Janitor;
use crate::nonce::random_incarnation;
use crate::on_demand::{OnDemand, PolicyPort};
use crate::port::{
    BriefReader, BriefWriter, CommandReader, CommandWriter, ControlReader, ControlWriter, HeartbeatReader,
    HeartbeatWriter, MapReader, MapWriter, PolicyReader, PolicyWriter, Reader, SheetReader, SheetWriter,
    StateReader, StateWriter, TempoReader, TempoWriter, Writer,
};
use crate::vigil::{Stop, Vigil, sleep};
use crate::{Instance, NodeError, Question, clock};

/// Why [`Node::wait`] returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wake {
    /// A topic that is listened to has news.
    Event,
    /// The time is up.
    Timeout,
    /// There is a new reason to stop: see [`Node::stop_requested`].
    Stop,
}

/// One process in its instance. Ports are made on demand and may outlive it.
#[derive(Debug)]
pub struct Node {
    _janitor: Janitor,
    pulse: Option<Pulse>,
    beats: Option<HeartbeatReader>,
    listeners: Vec<(String, Listener<Ipc>)>,
    vigil: Vigil,
    incarnation: Incarnation,
    base: Rc<Base>,
}

/// What it takes to beat.
#[derive(Debug)]
struct Pulse {
    writer: HeartbeatWriter,
    last: Heartbeat,
    sent: Option<MonotonicNs>,
}

impl Node {
    /// Joins the instance in a role, or as a planner with its algorithm's name; [`Name::NONE`] for others.
    ///
    /// # Errors
    /// If the instance is another user's, or the middleware cannot be had.
    pub fn join(instance: &Instance, role: Role, planner: Name) -> Result<Self, NodeError> {
        let mut node = Self::enter(instance, Some(role), role.as_str())?;
        node.pulse = Some(Pulse {
            writer: Writer::new(&node.base, &service::heartbeat())?,
            last: Heartbeat {
                role,
                incarnation: node.incarnation,
                pid: node.pid(),
                version: version(),
                planner,
                counter: 0,
                run: RunId(0),
                decision: Decision(0),
                status: Status::Underway,
            },
            sent: None,
        });
        Ok(node)
    }

    /// Joins the instance as one who only looks: no role, no heartbeat.
    ///
    /// # Errors
    /// As [`Node::join`].
    pub fn visit(instance: &Instance) -> Result<Self, NodeError> {
        Self::enter(instance, None, "visitor")
    }

    fn enter(instance: &Instance, role: Option<Role>, name: &str) -> Result<Self, NodeError> {
        let vigil = Vigil::new()?;
        let base = Rc::new(Base::new(instance, name)?);
        Ok(Self {
            _janitor: Janitor::start(instance, role)?,
            pulse: None,
            beats: None,
            listeners: Vec::new(),
            vigil,
            incarnation: random_incarnation()?,
            base,
        })
    }

    /// Now on the host's monotonic clock.
    #[must_use]
    pub fn now() -> MonotonicNs {
        clock::now()
    }

    /// The instance.
    #[must_use]
    pub fn instance(&self) -> &Instance {
        &self.base.instance
    }

    /// This life.
    #[must_use]
    pub fn incarnation(&self) -> Incarnation {
        self.incarnation
    }

    /// This process.
    #[must_use]
    pub fn pid(&self) -> u32 {
        std::process::id()
    }

    /// From now on the end of standard input is a reason to stop: see [`Vigil::hold_lifeline`].
    pub fn hold_lifeline(&self) {
        self.vigil.hold_lifeline();
    }

    /// Why to stop, if there is a reason.
    #[must_use]
    pub fn stop_requested(&self) -> Option<Stop> {
        self.vigil.stop_requested()
    }

    /// Lets news of `topic` end [`Node::wait`].
    ///
    /// # Errors
    /// If the event service cannot be had.
    ///
    /// # Panics
    /// If the topic has no events.
    pub fn listen(&mut self, topic: &Topic) -> Result<(), NodeError> {
        assert!(topic.event, "{} has no events", topic.name);
        self.attach(&topic.name)
    }

    fn attach(&mut self, service: &str) -> Result<(), NodeError> {
        if !self.listeners.iter().any(|(known, _)| known == service) {
            self.listeners.push((service.into(), self.base.listener(service)?));
        }
        Ok(())
    }

    /// Sleeps until a topic that is listened to has news, there is a new reason to stop, or `timeout` has
    /// passed. News is a hint: look at the readers after every wake.
    pub fn wait(&mut self, timeout: Duration) -> Wake {
        let mut fds = Vec::with_capacity(1 + self.listeners.len());
        fds.push(PollFd::from_borrowed_fd(self.vigil.bell(), PollFlags::IN));
        fds.extend(
            self.listeners
                .iter()
                .map(|(_, listener)| PollFd::from_borrowed_fd(fd_of(listener), PollFlags::IN)),
        );
        if !sleep(&mut fds, timeout) {
            // A notifier that died half-way may have left its listener marked as notified: clear them all.
            self.listeners.iter().for_each(|(_, listener)| quiet(listener));
            return Wake::Timeout;
        }
        for ((_, listener), fd) in self.listeners.iter().zip(&fds[1..]) {
            if !fd.revents().is_empty() {
                quiet(listener);
            }
        }
        if self.vigil.heard(fds[0].revents()) { Wake::Stop } else { Wake::Event }
    }

    /// Beats if the last beat is [`BEAT_PERIOD_NS`] old, or if what there is to tell of the run and its end
    /// has changed. Call it once per work loop, with what was last seen.
    ///
    /// # Errors
    /// If there is no room for the beat.
    pub fn beat(&mut self, run: RunId, decision: Decision, status: Status) -> Result<(), NodeError> {
        let Some(pulse) = &mut self.pulse else { return Ok(()) };
        let now = clock::now();
        let due = pulse.sent.is_none_or(|sent| now.since_ns(sent) >= BEAT_PERIOD_NS);
        let news = (run, status) != (pulse.last.run, pulse.last.status);
        if !due && !news {
            return Ok(());
        }
        pulse.last = Heartbeat { counter: pulse.last.counter + 1, run, decision, status, ..pulse.last };
        pulse.sent = Some(now);
        pulse.writer.publish(&pulse.last)
    }

    /// The peers' heartbeats since the last call; our own are left out. The first call begins to listen.
    pub fn heartbeats(&mut self) -> Vec<Result<Heartbeat, Refusal>> {
        if self.beats.is_none() {
            match Reader::new(&self.base, &service::heartbeat()) {
                Ok(reader) => self.beats = Some(reader),
                Err(error) => tracing::error!("peers go unheard: {error}"),
            }
        }
        let ours = self.incarnation;
        let peers = |beat: &Result<Heartbeat, Refusal>| !matches!(beat, Ok(beat) if beat.incarnation == ours);
        self.beats.iter_mut().flat_map(Reader::drain).filter(peers).collect()
    }

    /// The writer of `hop/brief`.
    ///
    /// # Errors
    /// If the service cannot be had, or has a writer already. So for all ports.
    pub fn brief_writer(&self) -> Result<BriefWriter, NodeError> {
        Writer::new(&self.base, &service::brief())
    }

    /// A reader of `hop/brief`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn brief_reader(&self) -> Result<BriefReader, NodeError> {
        Reader::new(&self.base, &service::brief())
    }

    /// The writer of `hop/rN/state`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn state_writer(&self, robot: RobotId) -> Result<StateWriter, NodeError> {
        Writer::new(&self.base, &service::state(robot))
    }

    /// A reader of `hop/rN/state`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn state_reader(&self, robot: RobotId) -> Result<StateReader, NodeError> {
        Reader::new(&self.base, &service::state(robot))
    }

    /// The writer of `hop/rN/map`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn map_writer(&self, robot: RobotId) -> Result<MapWriter, NodeError> {
        SheetWriter::new(&self.base, &service::map(robot), MAP_PATCH_CELLS)
    }

    /// A reader of `hop/rN/map`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn map_reader(&self, robot: RobotId) -> Result<MapReader, NodeError> {
        SheetReader::new(&self.base, &service::map(robot))
    }

    /// A writer of `hop/rN/command`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn command_writer(&self, robot: RobotId) -> Result<CommandWriter, NodeError> {
        Writer::new(&self.base, &service::command(robot))
    }

    /// A reader of `hop/rN/command`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn command_reader(&self, robot: RobotId) -> Result<CommandReader, NodeError> {
        Reader::new(&self.base, &service::command(robot))
    }

    /// A writer of `hop/rN/control`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn control_writer(&self, robot: RobotId) -> Result<ControlWriter, NodeError> {
        Writer::new(&self.base, &service::control(robot))
    }

    /// A reader of `hop/rN/control`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn control_reader(&self, robot: RobotId) -> Result<ControlReader, NodeError> {
        Reader::new(&self.base, &service::control(robot))
    }

    /// The writer of `hop/rN/tempo`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn tempo_writer(&self, robot: RobotId) -> Result<TempoWriter, NodeError> {
        Writer::new(&self.base, &service::tempo(robot))
    }

    /// A reader of `hop/rN/tempo`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn tempo_reader(&self, robot: RobotId) -> Result<TempoReader, NodeError> {
        Reader::new(&self.base, &service::tempo(robot))
    }

    /// A writer of `hop/rN/policy` for a grid of `cells` cells.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn policy_writer(&self, robot: RobotId, cells: usize) -> Result<PolicyWriter, NodeError> {
        SheetWriter::new(&self.base, &service::policy(robot), cells)
    }

    /// A writer of `hop/rN/policy` that takes no room until there is a policy to publish.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn policy_port(&self, robot: RobotId) -> Result<PolicyPort, NodeError> {
        OnDemand::new(&self.base, service::policy(robot))
    }

    /// A reader of `hop/rN/policy`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn policy_reader(&self, robot: RobotId) -> Result<PolicyReader, NodeError> {
        SheetReader::new(&self.base, &service::policy(robot))
    }

    /// As [`Node::policy_reader`] for whoever can do without and must not wait, be all places taken.
    ///
    /// # Errors
    /// See [`Node::brief_writer`]; they come within a fraction of a second.
    pub fn try_policy_reader(&self, robot: RobotId) -> Result<PolicyReader, NodeError> {
        SheetReader::glimpse(&self.base, &service::policy(robot))
    }

    /// A reader of `hop/heartbeat` that hears us too; [`Node::heartbeats`] is what a work loop wants.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn heartbeat_reader(&self) -> Result<HeartbeatReader, NodeError> {
        Reader::new(&self.base, &service::heartbeat())
    }

    /// A writer of `hop/heartbeat` beside our own beats, for tests of who refuses what.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn heartbeat_writer(&self) -> Result<HeartbeatWriter, NodeError> {
        Writer::new(&self.base, &service::heartbeat())
    }

    /// The server of `hop/past`; requests end [`Node::wait`]. So for all servers.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn past_server(&mut self) -> Result<PastServer, NodeError> {
        self.server(service::past())
    }

    /// A client of `hop/past`; answers end [`Node::wait`]. So for all clients.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn past_client(&mut self) -> Result<PastClient, NodeError> {
        self.client(service::past())
    }

    /// The server of `truth/terrain`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn truth_server(&mut self) -> Result<TruthServer, NodeError> {
        self.server(service::truth())
    }

    /// A client of `truth/terrain`; not for planners.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn truth_client(&mut self) -> Result<TruthClient, NodeError> {
        self.client(service::truth())
    }

    /// The server of `hop/rN/snapshot`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn snapshot_server(&mut self, robot: RobotId) -> Result<SnapshotServer, NodeError> {
        self.server(service::snapshot(robot))
    }

    /// A client of `hop/rN/snapshot`.
    ///
    /// # Errors
    /// See [`Node::brief_writer`].
    pub fn snapshot_client(&mut self, robot: RobotId) -> Result<SnapshotClient, NodeError> {
        self.client(service::snapshot(robot))
    }

    fn server<Q: Question>(&mut self, exchange: Exchange) -> Result<Server<Q>, NodeError> {
        let bell = asked(&exchange);
        let server = Server::new(&self.base, exchange)?;
        self.attach(&bell)?;
        Ok(server)
    }

    fn client<Q: Question>(&mut self, exchange: Exchange) -> Result<Client<Q>, NodeError> {
        let bell = answered(&exchange);
        let client = Client::new(&self.base, exchange)?;
        self.attach(&bell)?;
        Ok(client)
    }
}

/// Version of this build, as heartbeats tell it.
#[must_use]
pub fn version() -> Name {
    env!("CARGO_PKG_VERSION").parse().unwrap_or(Name::NONE)
}

fn fd_of(listener: &Listener<Ipc>) -> BorrowedFd<'_> {
    // SAFETY: the listener owns the descriptor and keeps it open, and the same, as long as it lives; the
    // borrow ends with that of the listener.
    unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
}

/// Takes the news off a listener, so that it can ring again.
fn quiet(listener: &Listener<Ipc>) {
    if let Err(error) = listener.try_wait(|_| {}) {
        tracing::debug!("draining events: {error}");
    }
}
