//! Typed ends of the services, one kind for every message: see [`contract::message`].
//!
//! A writer loans a slot, fills it and hands it over, then notifies the service's listeners. A reader copies a sample
//! first and validates the copy: its writer could still write to the slot.

mod client;
mod reader;
mod server;
mod writer;
mod zero_copy;

pub use client::Client;
pub use reader::Reader;
pub use server::Server;
pub use writer::Writer;
pub(crate) use zero_copy::ZeroCopy;

use std::time::Duration;

use contract::limits::NODES_MAX;
use contract::{Message, Payload, Request, RobotId};
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client as AskingPort;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server as AnsweringPort;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::MessagingPattern;
use iceoryx2::service::port_factory::{publish_subscribe, request_response};

use crate::error::NodeError;
use crate::middleware::{Ipc, service_name};
use crate::session::Session;
use crate::signature;

/// The cells of a message as the middleware sees them.
pub(crate) type Cells<P> = [ZeroCopy<<P as Payload>::Cell>];
/// The header of a message as the middleware sees it.
pub(crate) type Header<P> = ZeroCopy<<P as Payload>::Header>;
pub(crate) type MiddlewarePublisher<M> = Publisher<Ipc, Cells<M>, Header<M>>;
pub(crate) type MiddlewareSubscriber<M> = Subscriber<Ipc, Cells<M>, Header<M>>;
pub(crate) type PublishSubscribe<M> = publish_subscribe::PortFactory<Ipc, Cells<M>, Header<M>>;
/// A request has one cell and no header.
type Question<Q> = ZeroCopy<<Q as Payload>::Cell>;
type Answer<Q> = <Q as Request>::Response;
type MiddlewareClient<Q> = AskingPort<Ipc, Question<Q>, (), Cells<Answer<Q>>, Header<Answer<Q>>>;
type MiddlewareServer<Q> = AnsweringPort<Ipc, Question<Q>, (), Cells<Answer<Q>>, Header<Answer<Q>>>;
type Pending<Q> = PendingResponse<Ipc, Question<Q>, (), Cells<Answer<Q>>, Header<Answer<Q>>>;
type Active<Q> = ActiveRequest<Ipc, Question<Q>, (), Cells<Answer<Q>>, Header<Answer<Q>>>;
type RequestResponse<Q> =
    request_response::PortFactory<Ipc, Question<Q>, (), Cells<Answer<Q>>, Header<Answer<Q>>>;

/// Opens or creates the service of a message.
pub(crate) fn open_publish_subscribe<M: Message>(
    session: &Session,
    robot: RobotId,
    patience: Duration,
) -> Result<PublishSubscribe<M>, NodeError> {
    let (service, name) = (M::SERVICE, M::SERVICE.name_of(robot));
    session.open(patience, &name, MessagingPattern::PublishSubscribe, &signature::of_message::<M>(), || {
        session
            .node()
            .service_builder(&service_name(&name))
            .publish_subscribe::<Cells<M>>()
            .user_header::<Header<M>>()
            .max_publishers(service.max_publishers)
            .max_subscribers(service.max_subscribers)
            .max_nodes(NODES_MAX)
            .history_size(service.history)
            .subscriber_max_buffer_size(service.buffer)
            .subscriber_max_borrowed_samples(service.borrowed)
            .enable_safe_overflow(true)
            .open_or_create()
    })
}

fn open_request_response<Q: Request>(
    session: &Session,
    robot: RobotId,
    patience: Duration,
) -> Result<RequestResponse<Q>, NodeError> {
    let (service, name) = (Q::SERVICE, Q::SERVICE.name_of(robot));
    session.open(patience, &name, MessagingPattern::RequestResponse, &signature::of_request::<Q>(), || {
        session
            .node()
            .service_builder(&service_name(&name))
            .request_response::<Question<Q>, Cells<Answer<Q>>>()
            .response_user_header::<Header<Answer<Q>>>()
            .max_servers(1)
            .max_clients(service.max_clients)
            .max_nodes(NODES_MAX)
            .max_active_requests_per_client(1)
            .max_loaned_requests(1)
            .max_response_buffer_size(1)
            .max_borrowed_responses_per_pending_response(1)
            .enable_safe_overflow_for_requests(true)
            .enable_safe_overflow_for_responses(true)
            .enable_fire_and_forget_requests(false)
            .open_or_create()
    })
}

/// Event service that wakes the server of `service`.
pub(crate) fn requested(service: &str) -> String {
    format!("{service}/asked")
}

/// Event service that wakes the clients of `service`.
pub(crate) fn responded(service: &str) -> String {
    format!("{service}/answered")
}

/// Wakes the listeners. Events are hints: every process also looks at its readers at every tick.
fn notify(notifier: &Notifier<Ipc>) {
    if let Err(error) = notifier.notify() {
        tracing::debug!("waking: {error}");
    }
}

/// Connects to ports that came since, and hands late readers the history.
fn connect(service: &str, port: &impl UpdateConnections) {
    if let Err(error) = port.update_connections() {
        tracing::debug!(service, "connecting: {error}");
    }
}

/// Readers at present, those that died and are not yet cleaned up included.
pub(crate) fn count_readers<M: Message>(service: &PublishSubscribe<M>) -> usize {
    use iceoryx2::prelude::PortFactory as _;
    service.dynamic_config().number_of_subscribers()
}

/// Writers at present, those that died and are not yet cleaned up included.
pub(crate) fn count_writers<M: Message>(service: &PublishSubscribe<M>) -> usize {
    use iceoryx2::prelude::PortFactory as _;
    service.dynamic_config().number_of_publishers()
}
