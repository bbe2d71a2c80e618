//! What a process's ports stand on, and how services are opened.

use std::fmt;
use std::time::{Duration, Instant};

use contract::service::{NODES_MAX, Topic};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{
    Config, LogLevel, MessagingPattern, Node, NodeBuilder, NodeName, Service, ServiceName,
    SignalHandlingMode, ipc, set_log_level,
};
use iceoryx2::service::builder::event::{EventOpenError, EventOpenOrCreateError};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::builder::request_response::{
    RequestResponseOpenError, RequestResponseOpenOrCreateError,
};
use iceoryx2::service::static_config::StaticConfig;

use crate::presence::Presence;
use crate::scaffold::Scaffold;
use crate::undertaker::free_the_dead;
use crate::{Instance, NodeError, room};

/// The middleware's variant that we use.
pub(crate) type Ipc = ipc::Service;

/// How long to try again what others may be in the middle of.
pub(crate) const PATIENCE: Duration = Duration::from_secs(4);

/// How long to try again for what can be done without: a few tries, with the dead freed in between.
pub(crate) const GLIMPSE: Duration = Duration::from_millis(20);

/// Longest pause between two tries.
const PAUSE_MAX: Duration = Duration::from_millis(50);

/// Most listeners and notifiers of one event service.
const EVENT_PORTS_MAX: usize = 16;

/// What the ports of a process stand on. Its fields go in order: first the middleware's node, then the
/// membership, which tidies up behind the last.
#[derive(Debug)]
pub(crate) struct Base {
    node: Node<Ipc>,
    config: Config,
    scaffold: Scaffold,
    pub(crate) instance: Instance,
    _presence: Presence,
}

/// How a try failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    /// Somebody is in the middle of something, or died in it.
    Passing,
    /// The service exists with another type or other qualities.
    Mismatch,
}

impl Base {
    pub(crate) fn new(instance: &Instance, name: &str) -> Result<Self, NodeError> {
        set_log_level(LogLevel::Warn);
        let presence = Presence::enter(instance)?;
        room::check_entry(name)?;
        let scaffold = Scaffold::open(instance)?;
        let config = instance.config();
        let name = NodeName::new(name).expect("a role or a command is a short name");
        let builder =
            NodeBuilder::new().name(&name).signal_handling_mode(SignalHandlingMode::Disabled).config(&config);
        let node = persist(PATIENCE, "node", "creating a node", &config, &scaffold, || {
            builder.clone().create::<Ipc>()
        })?;
        instance.close_to_others()?;
        free_the_dead(&config);
        Ok(Self { node, config, scaffold, instance: instance.clone(), _presence: presence })
    }

    pub(crate) fn node(&self) -> &Node<Ipc> {
        &self.node
    }

    /// Opens or creates a service, trying again while others create or remove it.
    pub(crate) fn open<T, E: fmt::Display>(
        &self,
        service: &str,
        pattern: MessagingPattern,
        need: &dyn fmt::Display,
        open: impl FnMut() -> Result<T, E>,
    ) -> Result<T, NodeError>
    where
        Trouble: for<'e> From<&'e E>,
    {
        self.open_within(PATIENCE, service, pattern, need, open)
    }

    /// As [`Base::open`], for as long as `patience` lasts.
    pub(crate) fn open_within<T, E: fmt::Display>(
        &self,
        patience: Duration,
        service: &str,
        pattern: MessagingPattern,
        need: &dyn fmt::Display,
        mut open: impl FnMut() -> Result<T, E>,
    ) -> Result<T, NodeError>
    where
        Trouble: for<'e> From<&'e E>,
    {
        let mut mismatch = false;
        let opened = persist(patience, service, "opening", &self.config, &self.scaffold, || match open() {
            Err(error) if Trouble::from(&error) == Trouble::Mismatch => {
                mismatch = true;
                Ok(None)
            }
            other => other.map(Some),
        })?;
        opened.ok_or_else(|| {
            debug_assert!(mismatch);
            NodeError::Mismatch {
                service: service.into(),
                need: need.to_string(),
                got: self.describe(service, pattern),
            }
        })
    }

    /// Makes a port, trying again while the place of one who died is not yet free.
    pub(crate) fn port<T, E: fmt::Display>(
        &self,
        service: &str,
        what: &'static str,
        create: impl FnMut() -> Result<T, E>,
    ) -> Result<T, NodeError> {
        self.port_within(PATIENCE, service, what, create)
    }

    /// As [`Base::port`], for as long as `patience` lasts.
    pub(crate) fn port_within<T, E: fmt::Display>(
        &self,
        patience: Duration,
        service: &str,
        what: &'static str,
        create: impl FnMut() -> Result<T, E>,
    ) -> Result<T, NodeError> {
        let port = persist(patience, service, what, &self.config, &self.scaffold, create)?;
        room::reserve(&self.instance, &format!("service {service}"))?;
        Ok(port)
    }

    /// The service as it exists.
    fn describe(&self, service: &str, pattern: MessagingPattern) -> String {
        match Ipc::details(&service_name(service), &self.config, pattern) {
            Ok(Some(details)) => describe(&details.static_details),
            _ => "a service of another version of the middleware".into(),
        }
    }

    /// A listener of the topic's events.
    pub(crate) fn listener(&self, service: &str) -> Result<Listener<Ipc>, NodeError> {
        let factory = self.event(service)?;
        self.port(service, "listening", || factory.listener_builder().create())
    }

    /// A notifier of the topic's events.
    pub(crate) fn notifier(&self, service: &str) -> Result<Notifier<Ipc>, NodeError> {
        let factory = self.event(service)?;
        self.port(service, "notifying", || factory.notifier_builder().create())
    }

    fn event(
        &self,
        service: &str,
    ) -> Result<iceoryx2::service::port_factory::event::PortFactory<Ipc>, NodeError> {
        let need = format!("events, {EVENT_PORTS_MAX} notifiers, {EVENT_PORTS_MAX} listeners");
        self.open(service, MessagingPattern::Event, &need, || {
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

/// Our services have short names of ASCII.
pub(crate) fn service_name(name: &str) -> ServiceName {
    ServiceName::new(name).expect("a service has a short name of ASCII")
}

/// A service in the words of [`describe`], as `topic` and a type ask for it.
pub(crate) fn need(types: &str, topic: &Topic) -> String {
    format!(
        "{types}, {} publishers, {} subscribers, history {}, buffer {}, borrowed {}, {NODES_MAX} nodes",
        topic.max_publishers, topic.max_subscribers, topic.history, topic.buffer, topic.borrowed
    )
}

/// A service as it was created.
pub(crate) fn describe(service: &StaticConfig) -> String {
    use iceoryx2::service::static_config::messaging_pattern::MessagingPattern as Pattern;
    match service.messaging_pattern() {
        Pattern::PublishSubscribe(config) => {
            let types = config.message_type_details();
            format!(
                "{}, {} publishers, {} subscribers, history {}, buffer {}, borrowed {}, {} nodes",
                crate::port::type_text(&types.user_header, &types.payload),
                config.max_publishers(),
                config.max_subscribers(),
                config.history_size(),
                config.subscriber_max_buffer_size(),
                config.subscriber_max_borrowed_samples(),
                config.max_nodes()
            )
        }
        Pattern::Event(config) => {
            format!("events, {} notifiers, {} listeners", config.max_notifiers(), config.max_listeners())
        }
        Pattern::RequestResponse(config) => {
            let (request, response) =
                (config.request_message_type_details(), config.response_message_type_details());
            format!(
                "{} answered by {}, {} clients",
                crate::port::type_text(&request.user_header, &request.payload),
                crate::port::type_text(&response.user_header, &response.payload),
                config.max_clients()
            )
        }
        other => format!("{other:?}"),
    }
}

/// Tries until it works or `patience` has run out, each time as the only one of the instance that makes
/// something, on ground cleared of what the dead left unfinished; between tries, what they left behind is freed.
fn persist<T, E: fmt::Display>(
    patience: Duration,
    service: &str,
    what: &'static str,
    config: &Config,
    scaffold: &Scaffold,
    mut attempt: impl FnMut() -> Result<T, E>,
) -> Result<T, NodeError> {
    let started = Instant::now();
    let mut pause = Duration::from_millis(1);
    loop {
        let hold = scaffold.hold(patience)?;
        hold.clear_unfinished();
        match attempt() {
            Ok(value) => return Ok(value),
            Err(error) if started.elapsed() > patience => {
                let (service, cause) = (service.into(), error.to_string());
                if cause.contains("ExceedsMaxSupported") {
                    return Err(NodeError::Full { service, what });
                }
                return Err(NodeError::Open { service, what, waited_s: patience.as_secs_f64(), cause });
            }
            Err(error) => tracing::debug!(service, what, "trying again: {error}"),
        }
        drop(hold);
        free_the_dead(config);
        std::thread::sleep(pause);
        pause = (pause * 2).min(PAUSE_MAX);
    }
}

impl From<&PublishSubscribeOpenOrCreateError> for Trouble {
    fn from(error: &PublishSubscribeOpenOrCreateError) -> Self {
        use PublishSubscribeOpenError as E;
        let PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(error) = error else {
            return Trouble::Passing;
        };
        match error {
            E::IncompatibleTypes
            | E::IncompatibleMessagingPattern
            | E::IncompatibleAttributes
            | E::IncompatibleOverflowBehavior
            | E::DoesNotSupportRequestedMinBufferSize
            | E::DoesNotSupportRequestedMinHistorySize
            | E::DoesNotSupportRequestedMinSubscriberBorrowedSamples
            | E::DoesNotSupportRequestedAmountOfPublishers
            | E::DoesNotSupportRequestedAmountOfSubscribers
            | E::DoesNotSupportRequestedAmountOfNodes
            | E::VersionMismatch => Trouble::Mismatch,
            _ => Trouble::Passing,
        }
    }
}

impl From<&EventOpenOrCreateError> for Trouble {
    fn from(error: &EventOpenOrCreateError) -> Self {
        use EventOpenError as E;
        let EventOpenOrCreateError::EventOpenError(error) = error else { return Trouble::Passing };
        match error {
            E::IncompatibleMessagingPattern
            | E::IncompatibleAttributes
            | E::IncompatibleDeadline
            | E::IncompatibleNotifierCreatedEvent
            | E::IncompatibleNotifierDroppedEvent
            | E::IncompatibleNotifierDeadEvent
            | E::DoesNotSupportRequestedAmountOfNotifiers
            | E::DoesNotSupportRequestedAmountOfListeners
            | E::DoesNotSupportRequestedMaxEventId
            | E::DoesNotSupportRequestedAmountOfNodes
            | E::VersionMismatch => Trouble::Mismatch,
            _ => Trouble::Passing,
        }
    }
}

impl From<&RequestResponseOpenOrCreateError> for Trouble {
    fn from(error: &RequestResponseOpenOrCreateError) -> Self {
        use RequestResponseOpenError as E;
        let RequestResponseOpenOrCreateError::RequestResponseOpenError(error) = error else {
            return Trouble::Passing;
        };
        match error {
            E::IncompatibleRequestOrResponseType
            | E::IncompatibleAttributes
            | E::IncompatibleMessagingPattern
            | E::IncompatibleOverflowBehaviorForRequests
            | E::IncompatibleOverflowBehaviorForResponses
            | E::IncompatibleBehaviorForFireAndForgetRequests
            | E::DoesNotSupportRequestedAmountOfClientRequestLoans
            | E::DoesNotSupportRequestedAmountOfActiveRequestsPerClient
            | E::DoesNotSupportRequestedResponseBufferSize
            | E::DoesNotSupportRequestedAmountOfServers
            | E::DoesNotSupportRequestedAmountOfClients
            | E::DoesNotSupportRequestedAmountOfNodes
            | E::DoesNotSupportRequestedAmountOfBorrowedResponsesPerPendingResponse
            | E::VersionMismatch => Trouble::Mismatch,
            _ => Trouble::Passing,
        }
    }
}
