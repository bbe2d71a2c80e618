//! One process's use of the middleware in its instance: what its ports share.

mod obstacle;
pub(crate) mod shutdown;

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
use obstacle::Obstacle;

/// How long to retry while other processes make or remove something.
pub(crate) const PATIENCE: Duration = Duration::from_secs(4);

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
    pub(crate) instance: Instance,
    _membership: MembershipLock,
}

impl Session {
    /// Joins the instance under the name of a role or a command.
    pub(crate) fn join(instance: &Instance, name: &str) -> Result<Self, NodeError> {
        set_log_level(LogLevel::Warn);
        let membership = MembershipLock::enter(instance)?;
        memory_budget::check_entry(name)?;
        let creation_lock = CreationLock::open(instance)?;
        let config = instance.config();
        let name = NodeName::new(name).expect("a role or a command is a short name");
        let builder =
            NodeBuilder::new().name(&name).signal_handling_mode(SignalHandlingMode::Disabled).config(&config);
        let node = retry(PATIENCE, "node", "creating a node", &config, &creation_lock, || {
            builder.clone().create::<Ipc>()
        })?;
        instance.refuse_foreign_files()?;
        instance.close_to_others()?;
        clean_up_dead_nodes(&config);
        Ok(Self { node, config, creation_lock, instance: instance.clone(), _membership: membership })
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
        let opened =
            retry(patience, service, "opening", &self.config, &self.creation_lock, || match open() {
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
        let port = retry(patience, service, what, &self.config, &self.creation_lock, create)?;
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

/// Tries until it works or `patience` has run out. Each try is made under the creation lock, after what the dead left
/// unfinished has been removed; between tries, what they left behind is freed.
fn retry<T, E: fmt::Display>(
    patience: Duration,
    service: &str,
    what: &'static str,
    config: &Config,
    creation_lock: &CreationLock,
    mut attempt: impl FnMut() -> Result<T, E>,
) -> Result<T, NodeError> {
    let started = Instant::now();
    let mut pause = Duration::from_millis(1);
    loop {
        let guard = creation_lock.hold(patience)?;
        guard.remove_unfinished();
        match attempt() {
            Ok(value) => return Ok(value),
            Err(error) if started.elapsed() > patience => {
                let (service, cause) = (service.into(), error.to_string());
                if cause.contains("ExceedsMaxSupported") {
                    return Err(NodeError::Full { service, what });
                }
                return Err(NodeError::Open { service, what, waited_s: patience.as_secs_f64(), cause });
            }
            Err(error) => tracing::debug!(service, what, "retrying: {error}"),
        }
        // The middleware names neither the file nor its owner.
        guard.refuse_foreign_files()?;
        drop(guard);
        clean_up_dead_nodes(config);
        std::thread::sleep(pause);
        pause = (pause * 2).min(PAUSE_MAX);
    }
}
