//! A process in its instance: the ports of the real world.

use std::future::{Future, ready};
use std::os::fd::BorrowedFd;
use std::rc::Rc;
use std::time::Duration;

use contract::{Incarnation, Message, MonotonicNs, Name, Request, RobotId, Role};
use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::FileDescriptorBased;
use process::{Exit, Failure, Ports, Process};
use rustix::event::{PollFd, PollFlags};

use crate::cleanup::CleanupThread;
use crate::error::NodeError;
use crate::membership::build_id::version;
use crate::membership::instance::Instance;
use crate::middleware::Ipc;
use crate::nonce::random_incarnation;
use crate::ports::service::{requested, responded};
use crate::ports::{Client, Reader, Server, Writer};
use crate::session::{SHORT_PATIENCE, Session};
use crate::shutdown::{ShutdownSignal, StopReason, sleep};
use crate::waiting::{Joining, PATIENCE, Waiting};
use crate::{clock, crash, host};

/// What ended a [`Node::sleep`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wake {
    /// A message came for a port that wakes the process.
    Event,
    /// The time is up.
    Timeout,
    /// There is a new reason to stop: see [`Node::stop_reason`].
    Stop,
}

/// One process in its instance. Its ports may outlive it.
#[derive(Debug)]
pub struct Node {
    _cleanup: CleanupThread,
    listeners: Vec<(String, Listener<Ipc>)>,
    shutdown: Rc<ShutdownSignal>,
    incarnation: Incarnation,
    /// `None` of a visitor.
    role: Option<Role>,
    session: Rc<Session>,
}

impl Node {
    /// Joins the instance in a role.
    ///
    /// # Errors
    /// If the instance belongs to another user or another build, or if the middleware fails.
    pub fn join(instance: &Instance, role: Role) -> Result<Self, NodeError> {
        Self::join_with(instance, role, Joining::default())
    }

    /// As [`Node::join`], with other patience, or a parent.
    ///
    /// # Errors
    /// As [`Node::join`].
    pub fn join_with(instance: &Instance, role: Role, joining: Joining) -> Result<Self, NodeError> {
        Self::enter(instance, Some(role), role.as_str(), joining)
    }

    /// Joins the instance as an observer without a role, which may use every port.
    ///
    /// # Errors
    /// As [`Node::join`].
    pub fn visit(instance: &Instance) -> Result<Self, NodeError> {
        Self::visit_with(instance, Joining::default())
    }

    /// As [`Node::visit`], with other patience, or a parent.
    ///
    /// # Errors
    /// As [`Node::join`].
    pub fn visit_with(instance: &Instance, joining: Joining) -> Result<Self, NodeError> {
        Self::enter(instance, None, "visitor", joining)
    }

    fn enter(
        instance: &Instance,
        role: Option<Role>,
        name: &str,
        joining: Joining,
    ) -> Result<Self, NodeError> {
        let shutdown = Rc::new(ShutdownSignal::new()?);
        if joining.lifeline {
            shutdown.hold_lifeline();
        }
        let waiting = Waiting::new(joining.patience, Some(Rc::clone(&shutdown)));
        let session = Rc::new(Session::join(instance, name, waiting)?);
        Ok(Self {
            _cleanup: CleanupThread::start(instance, role)?,
            listeners: Vec::new(),
            shutdown,
            incarnation: random_incarnation()?,
            role,
            session,
        })
    }

    /// What tells it to stop; it goes on doing so when the node has left the instance.
    #[must_use]
    pub fn shutdown(&self) -> Rc<ShutdownSignal> {
        Rc::clone(&self.shutdown)
    }

    /// Now on the host's monotonic clock.
    #[must_use]
    pub fn now() -> MonotonicNs {
        clock::now()
    }

    /// The instance it has joined.
    #[must_use]
    pub fn instance(&self) -> &Instance {
        &self.session.instance
    }

    /// From now on the end of standard input is a reason to stop: see [`ShutdownSignal::hold_lifeline`].
    pub fn hold_lifeline(&self) {
        self.shutdown.hold_lifeline();
    }

    /// Why to stop, if there is a reason.
    #[must_use]
    pub fn stop_reason(&self) -> Option<StopReason> {
        self.shutdown.stop_reason()
    }

    /// Sleeps until a message wakes the process, there is a new reason to stop, or `timeout` has passed. A wake-up is a
    /// hint: look at every reader afterwards.
    pub fn sleep(&mut self, timeout: Duration) -> Wake {
        let mut fds = Vec::with_capacity(1 + self.listeners.len());
        fds.push(PollFd::from_borrowed_fd(self.shutdown.descriptor(), PollFlags::IN));
        fds.extend(
            self.listeners
                .iter()
                .map(|(_, listener)| PollFd::from_borrowed_fd(descriptor(listener), PollFlags::IN)),
        );
        if !sleep(&mut fds, timeout) {
            // A notifier that died half-way may have left its listener marked as notified: clear them all.
            self.listeners.iter().for_each(|(_, listener)| clear(listener));
            return Wake::Timeout;
        }
        for ((_, listener), fd) in self.listeners.iter().zip(&fds[1..]) {
            if !fd.revents().is_empty() {
                clear(listener);
            }
        }
        if self.shutdown.acknowledge(fds[0].revents()) { Wake::Stop } else { Wake::Event }
    }

    /// Lets events of a service end [`Node::sleep`].
    fn listen(&mut self, service: &str) -> Result<(), NodeError> {
        if !self.listeners.iter().any(|(known, _)| known == service) {
            self.listeners.push((service.into(), self.session.listener(service)?));
        }
        Ok(())
    }
}

/// Runs a process in `node` until it leaves, or is to stop.
///
/// # Errors
/// The first error of a turn.
pub fn run(mut node: Node, mut process: impl Process<Node>) -> Result<Exit, Failure> {
    process::block_on(process::run(&mut process, &mut node))
}

/// Nothing here suspends: what takes time is done before a future is returned.
impl Ports for Node {
    type Error = NodeError;
    type Reader<M: Message> = Reader<M>;
    type Writer<M: Message> = Writer<M>;
    type Client<Q: Request> = Client<Q>;
    type Server<Q: Request> = Server<Q>;

    fn reader<M: Message>(&mut self, robot: RobotId, wakes: bool) -> Result<Reader<M>, NodeError> {
        if wakes {
            assert!(M::SERVICE.event, "{} has no events", M::SERVICE.name);
            self.listen(&M::SERVICE.name_of(robot))?;
        }
        Reader::new(&self.session, robot, PATIENCE)
    }

    fn try_reader<M: Message>(&mut self, robot: RobotId) -> Result<Reader<M>, NodeError> {
        Reader::new(&self.session, robot, SHORT_PATIENCE)
    }

    /// # Panics
    /// If the node's role may not write the service.
    fn writer<M: Message>(&mut self, robot: RobotId) -> Result<Writer<M>, NodeError> {
        if let Some(role) = self.role {
            assert!(M::SERVICE.writers.contains(&role), "{role} must not write {}", M::SERVICE.name);
        }
        Writer::new(&self.session, robot)
    }

    fn client<Q: Request>(&mut self, robot: RobotId) -> Result<Client<Q>, NodeError> {
        let client = Client::new(&self.session, robot)?;
        self.listen(&responded(&Q::SERVICE.name_of(robot)))?;
        Ok(client)
    }

    /// # Panics
    /// If the node's role may not serve the service.
    fn server<Q: Request>(&mut self, robot: RobotId) -> Result<Server<Q>, NodeError> {
        if let Some(role) = self.role {
            assert!(Q::SERVICE.server == role, "{role} must not serve {}", Q::SERVICE.name);
        }
        let server = Server::new(&self.session, robot)?;
        self.listen(&requested(&Q::SERVICE.name_of(robot)))?;
        Ok(server)
    }

    fn now(&mut self) -> MonotonicNs {
        clock::now()
    }

    fn incarnation(&self) -> Incarnation {
        self.incarnation
    }

    fn pid(&self) -> u32 {
        std::process::id()
    }

    fn version(&self) -> Name {
        version()
    }

    fn process_exists(&self, pid: u32) -> bool {
        host::process_exists(pid)
    }

    fn stop_requested(&self) -> bool {
        self.stop_reason().is_some()
    }

    /// The peer may have been started by another user, whose instance of the same name is a different one.
    fn instance_name(&self) -> Option<&str> {
        Some(self.instance().name())
    }

    fn absence_hint(&self) -> String {
        self.instance().namesake_hint()
    }

    fn wait(&mut self, timeout_ns: u64) -> impl Future<Output = ()> {
        self.sleep(Duration::from_nanos(timeout_ns));
        ready(())
    }

    fn pass(&mut self, point: &'static str) -> impl Future<Output = ()> {
        crash::crash_point(point);
        ready(())
    }

    fn computed(&mut self) -> impl Future<Output = ()> {
        ready(())
    }
}

fn descriptor(listener: &Listener<Ipc>) -> BorrowedFd<'_> {
    // SAFETY: the listener owns the descriptor and keeps it open, and the same, as long as it lives; the borrow ends
    // with that of the listener.
    unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
}

/// Takes the events off a listener, so that the next one is noticed too.
fn clear(listener: &Listener<Ipc>) {
    if let Err(error) = listener.try_wait(|_| {}) {
        tracing::debug!("clearing events: {error}");
    }
}
