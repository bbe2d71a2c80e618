//! One process's use of the middleware in its instance: what its ports share.

mod obstacle;

use std::fmt;
use std::time::{Duration, Instant};

use contract::limits::NODES_MAX;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{
    Config, LogLevel, MessagingPattern, Node, NodeBuilder, NodeName, Service, SignalHandlingMode,
    set_log_level,
};
use iceoryx2::service::port_factory::event::PortFactory;

use crate::cleanup::{CreationLock, clean_up_dead_nodes};
use crate::error::NodeError;
use crate::membership::instance::Instance;
use crate::membership::lock::MembershipLock;
use crate::memory_budget;
use crate::middleware::{Ipc, service_name};
use crate::signature::{self, EVENT_PORTS_MAX};
use crate::waiting::{HoldUp, PATIENCE, Waiting, holder_of};
use obstacle::Obstacle;

/// How long to retry for a port that a process can do without: a few tries, with the dead cleaned up in between.
pub(crate) const SHORT_PATIENCE: Duration = Duration::from_millis(20);

/// Longest pause between two tries.
const PAUSE_MAX: Duration = Duration::from_millis(50);

/// A process's membership of its instance and its node in the middleware. Its fields are dropped in order: first the
/// node, then the membership, which cleans up behind the last process.
#[derive(Debug)]
pub(crate) struct Session {
    node: Node<Ipc>,
    config: Config,
    creation_lock: CreationLock,
    /// For other processes that are in the way.
    waiting: Waiting,
    pub(crate) instance: Instance,
    _membership: MembershipLock,
}

impl Session {
    /// Joins the instance under the name of a role or a command.
    pub(crate) fn join(instance: &Instance, name: &str, waiting: Waiting) -> Result<Self, NodeError> {
        set_log_level(LogLevel::Warn);
        let membership = MembershipLock::enter(instance, &waiting)?;
        memory_budget::check_entry(name)?;
        let creation_lock = CreationLock::open(instance)?;
        let config = instance.config();
        let name = NodeName::new(name).expect("a role or a command is a short name");
        let builder =
            NodeBuilder::new().name(&name).signal_handling_mode(SignalHandlingMode::Disabled).config(&config);
        let place = Place { instance, config: &config, creation_lock: &creation_lock, waiting: &waiting };
        let node = place.retry(PATIENCE, "node", "creating a node", || builder.clone().create::<Ipc>())?;
        instance.refuse_foreign_files()?;
        instance.close_to_others()?;
        clean_up_dead_nodes(&config);
        Ok(Self { node, config, creation_lock, waiting, instance: instance.clone(), _membership: membership })
    }

    fn place(&self) -> Place<'_> {
        let Self { instance, config, creation_lock, waiting, .. } = self;
        Place { instance, config, creation_lock, waiting }
    }

    pub(crate) fn node(&self) -> &Node<Ipc> {
        &self.node
    }

    /// Opens or creates a service, retrying while others create or remove it.
    pub(crate) fn open<T, E: fmt::Display>(
        &self,
        patience: Duration,
        service: &str,
        pattern: MessagingPattern,
        need: &str,
        mut open: impl FnMut() -> Result<T, E>,
    ) -> Result<T, NodeError>
    where
        Obstacle: for<'e> From<&'e E>,
    {
        let opened = self.place().retry(patience, service, "opening", || match open() {
            Err(error) if Obstacle::from(&error) == Obstacle::Mismatch => Ok(None),
            other => other.map(Some),
        })?;
        opened.ok_or_else(|| NodeError::Mismatch {
            service: service.into(),
            need: need.into(),
            got: self.describe(service, pattern),
        })
    }

    /// Makes a port, retrying while the place of a dead process is not yet free, and reserves its memory.
    pub(crate) fn port<T, E: fmt::Display>(
        &self,
        patience: Duration,
        service: &str,
        what: &'static str,
        create: impl FnMut() -> Result<T, E>,
    ) -> Result<T, NodeError> {
        let port = self.place().retry(patience, service, what, create)?;
        self.instance.refuse_foreign_files()?;
        memory_budget::reserve(&self.instance, &format!("service {service}"))?;
        Ok(port)
    }

    /// The service as it exists.
    fn describe(&self, service: &str, pattern: MessagingPattern) -> String {
        match Ipc::details(&service_name(service), &self.config, pattern) {
            Ok(Some(details)) => signature::of_existing(&details.static_details),
            _ => "a service of another version of the middleware".into(),
        }
    }

    /// A listener of the events of a service.
    pub(crate) fn listener(&self, service: &str) -> Result<Listener<Ipc>, NodeError> {
        let factory = self.events(service)?;
        self.port(PATIENCE, service, "listening", || factory.listener_builder().create())
    }

    /// A notifier of the events of a service.
    pub(crate) fn notifier(&self, service: &str) -> Result<Notifier<Ipc>, NodeError> {
        let factory = self.events(service)?;
        self.port(PATIENCE, service, "notifying", || factory.notifier_builder().create())
    }

    fn events(&self, service: &str) -> Result<PortFactory<Ipc>, NodeError> {
        self.open(PATIENCE, service, MessagingPattern::Event, &signature::of_event(), || {
            self.node
                .service_builder(&service_name(service))
                .event()
                .max_nodes(NODES_MAX)
                .max_notifiers(EVENT_PORTS_MAX)
                .max_listeners(EVENT_PORTS_MAX)
                .event_id_max_value(0)
                .open_or_create()
        })
    }
}

/// Where a process makes nodes, services and ports.
struct Place<'a> {
    instance: &'a Instance,
    config: &'a Config,
    creation_lock: &'a CreationLock,
    waiting: &'a Waiting,
}

impl Place<'_> {
    /// Tries until it works or `patience` has run out, waits for other processes not counted. Each try is made under the creation
    /// lock, after what the dead left unfinished has been removed; between tries, what they left behind is freed.
    fn retry<T, E: fmt::Display>(
        &self,
        patience: Duration,
        service: &str,
        what: &'static str,
        mut attempt: impl FnMut() -> Result<T, E>,
    ) -> Result<T, NodeError> {
        // Who can do without does not wait for others either.
        let waiting = if patience < PATIENCE { &self.waiting.at_most(patience) } else { self.waiting };
        let (mut tried, mut hold_up) = (Duration::ZERO, HoldUp::begin());
        let mut pause = Duration::from_millis(1);
        loop {
            let guard = self.creation_lock.hold(waiting)?;
            let began = Instant::now();
            guard.remove_unfinished();
            let error = match attempt() {
                Ok(value) => return Ok(value),
                Err(error) => error.to_string(),
            };
            // The middleware names neither the file nor its owner.
            guard.refuse_foreign_files()?;
            drop(guard);
            if tried > patience {
                // The places of the dead are taken until they are freed, which one process at a time does.
                let lock = self.instance.cleanup_lock();
                if holder_of(&lock).is_none() {
                    return Err(failed(service, what, patience, error));
                }
                waiting.endure(&mut hold_up, &lock)?;
            }
            tracing::debug!(service, what, "retrying: {error}");
            clean_up_dead_nodes(self.config);
            std::thread::sleep(pause);
            pause = (pause * 2).min(PAUSE_MAX);
            tried += began.elapsed();
        }
    }
}

fn failed(service: &str, what: &'static str, patience: Duration, cause: String) -> NodeError {
    let service = service.into();
    if cause.contains("ExceedsMaxSupported") {
        return NodeError::Full { service, what };
    }
    NodeError::Open { service, what, waited_s: patience.as_secs_f64(), cause }
}
