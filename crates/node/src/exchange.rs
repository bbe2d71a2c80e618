//! Both ends of the request-response services: the past, the truth, the map's snapshot.
//!
//! A request wakes the server and an answer wakes the clients, so that a rebuild of many pages takes a
//! round trip a page rather than a tick a page.

use std::rc::Rc;

use contract::service::{Exchange, NODES_MAX};
use contract::wire::Wire;
use contract::{MapRequest, PastRequest, Refusal, TruthRequest};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client as AskingPort;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server as AnsweringPort;
use iceoryx2::prelude::{AllocationStrategy, MessagingPattern};
use iceoryx2::service::port_factory::request_response::PortFactory;

use crate::base::{Base, Ipc, service_name};
use crate::parcel::Parcel;
use crate::port::ring;
use crate::{NodeError, Question, Sheet, room};

/// Answers for the past; only hopper-sim has one.
pub type PastServer = Server<PastRequest>;
/// Asks for the past.
pub type PastClient = Client<PastRequest>;
/// Answers for the truth; only hopper-sim has one.
pub type TruthServer = Server<TruthRequest>;
/// Asks for the truth; no planner may have one.
pub type TruthClient = Client<TruthRequest>;
/// Answers for the map; only perception has one.
pub type SnapshotServer = Server<MapRequest>;
/// Asks for the map.
pub type SnapshotClient = Client<MapRequest>;

type Request<Q> = Parcel<<Q as crate::Plain>::Wire>;
type Cells<Q> = [Parcel<<<Q as Question>::Answer as Sheet>::Cell>];
type Header<Q> = Parcel<<<Q as Question>::Answer as Sheet>::Header>;
type Questions<Q> = PortFactory<Ipc, Request<Q>, (), Cells<Q>, Header<Q>>;
type Pending<Q> = PendingResponse<Ipc, Request<Q>, (), Cells<Q>, Header<Q>>;

/// The only server of a service.
#[derive(Debug)]
pub struct Server<Q: Question> {
    server: AnsweringPort<Ipc, Request<Q>, (), Cells<Q>, Header<Q>>,
    bell: Notifier<Ipc>,
    exchange: Exchange,
    _base: Rc<Base>,
}

/// A client of a service, with one request at a time.
#[derive(Debug)]
pub struct Client<Q: Question> {
    pending: Option<Pending<Q>>,
    client: AskingPort<Ipc, Request<Q>, (), Cells<Q>, Header<Q>>,
    bell: Notifier<Ipc>,
    cells: Vec<<Q::Answer as Sheet>::Cell>,
    exchange: Exchange,
    _base: Rc<Base>,
}

/// Event service that wakes the server.
pub(crate) fn asked(exchange: &Exchange) -> String {
    format!("{}/asked", exchange.name)
}

/// Event service that wakes the clients.
pub(crate) fn answered(exchange: &Exchange) -> String {
    format!("{}/answered", exchange.name)
}

impl<Q: Question> Server<Q> {
    pub(crate) fn new(base: &Rc<Base>, exchange: Exchange) -> Result<Self, NodeError> {
        room::check_exchange(&exchange, size_of::<Q::Wire>(), page_bytes::<Q::Answer>(&exchange))?;
        let factory = open::<Q>(base, &exchange)?;
        let server = base.port(&exchange.name, "serving", || {
            factory
                .server_builder()
                .initial_max_slice_len(exchange.page)
                .allocation_strategy(AllocationStrategy::Static)
                .max_loaned_responses_per_request(1)
                .create()
        })?;
        Ok(Self { server, bell: base.notifier(&answered(&exchange))?, exchange, _base: Rc::clone(base) })
    }

    /// Answers the requests that are there, one a client at most: whoever asks without end keeps nobody else
    /// waiting, nor the server from its other work. What is left came meanwhile, and ends the next wait at
    /// once. `answer` may leave a request unanswered: the client will ask again. Returns the refusals of
    /// malformed requests.
    ///
    /// # Errors
    /// [`NodeError::Oversize`] if an answer has more cells than a page holds.
    pub fn serve<A: Into<Option<Q::Answer>>>(
        &mut self,
        mut answer: impl FnMut(&Q) -> A,
    ) -> Result<Vec<Refusal>, NodeError> {
        let service = &self.exchange.name;
        let mut refusals = Vec::new();
        let mut answered = false;
        // A client has one request at a time, so there are no more, however fast a client asks again.
        for _ in 0..self.exchange.max_clients {
            let request = match self.server.receive() {
                Ok(Some(request)) => request,
                Ok(None) => break,
                Err(error) => {
                    tracing::debug!(service, "receiving a request: {error}");
                    break;
                }
            };
            let wire = request.payload().0;
            let asked = match Q::from_wire(&wire) {
                Ok(asked) => asked,
                Err(refusal) => {
                    refusals.push(refusal);
                    continue;
                }
            };
            let Some(page) = answer(&asked).into() else { continue };
            if page.cells() > self.exchange.page {
                let (need, got) = (self.exchange.page, page.cells());
                return Err(NodeError::Oversize { service: service.clone(), need, got });
            }
            answered |= self.send(&request, &page);
        }
        if answered {
            ring(Some(&self.bell));
        }
        Ok(refusals)
    }

    /// Answers one request. If that fails, the client is gone, or gave up: it will ask again if it still
    /// wants to know.
    fn send(
        &self,
        request: &iceoryx2::active_request::ActiveRequest<Ipc, Request<Q>, (), Cells<Q>, Header<Q>>,
        page: &Q::Answer,
    ) -> bool {
        let service = &self.exchange.name;
        let sent = request.loan_slice_uninit(page.cells()).map(|mut answer| {
            *answer.user_header_mut() = Parcel(page.header());
            answer.write_from_fn(|index| Parcel(page.cell(index))).send()
        });
        match sent {
            Ok(Ok(())) => return true,
            Ok(Err(error)) => tracing::debug!(service, "answering: {error}"),
            Err(error) => tracing::debug!(service, "answering: {error}"),
        }
        false
    }
}

impl<Q: Question> Client<Q> {
    pub(crate) fn new(base: &Rc<Base>, exchange: Exchange) -> Result<Self, NodeError> {
        let factory = open::<Q>(base, &exchange)?;
        let client = base.port(&exchange.name, "asking", || factory.client_builder().create())?;
        Ok(Self {
            pending: None,
            client,
            bell: base.notifier(&asked(&exchange))?,
            cells: Vec::new(),
            exchange,
            _base: Rc::clone(base),
        })
    }

    /// Asks; a request before it that has no answer yet is given up.
    ///
    /// # Errors
    /// If there is no room for the request.
    pub fn request(&mut self, request: &Q) -> Result<(), NodeError> {
        self.request_wire(request.to_wire())
    }

    /// Asks with bytes that need not be a valid request, for tests of who refuses what.
    ///
    /// # Errors
    /// As [`Client::request`].
    pub fn request_wire(&mut self, request: Q::Wire) -> Result<(), NodeError> {
        self.pending = None;
        let service = &self.exchange.name;
        let send_error = |error: &dyn std::fmt::Display| NodeError::Send {
            service: service.clone(),
            cause: error.to_string(),
        };
        let sample = self.client.loan_uninit().map_err(|error| send_error(&error))?;
        match sample.write_payload(Parcel(request)).send() {
            Ok(pending) => self.pending = Some(pending),
            // The server comes or goes: the request is repeated at a later tick.
            Err(error) => tracing::debug!(service, "asking: {error}"),
        }
        ring(Some(&self.bell));
        Ok(())
    }

    /// The answer to the last request, once it is there.
    pub fn receive(&mut self) -> Option<Result<Q::Answer, Refusal>> {
        let answer = match self.pending.as_ref()?.receive() {
            Ok(answer) => answer?,
            Err(error) => {
                tracing::debug!(service = self.exchange.name, "receiving an answer: {error}");
                return None;
            }
        };
        let header = answer.user_header().0;
        self.cells.clear();
        self.cells.extend(answer.payload().iter().map(|cell| cell.0));
        drop(answer);
        self.pending = None;
        Some(Q::Answer::from_wire(&header, &self.cells))
    }

    /// Whether a request waits for its answer.
    #[must_use]
    pub fn is_waiting(&self) -> bool {
        self.pending.is_some()
    }
}

/// Bytes of a full page.
pub(crate) fn page_bytes<S: Sheet>(exchange: &Exchange) -> usize {
    size_of::<S::Header>() + exchange.page * size_of::<S::Cell>()
}

/// A service as its requests and answers ask for it, under its name.
pub(crate) fn text<Q: Question>(exchange: &Exchange) -> String {
    format!("{}: {}, pages of {}", exchange.name, need::<Q>(exchange), exchange.page)
}

fn need<Q: Question>(exchange: &Exchange) -> String {
    format!(
        "{} ({} bytes) answered by {} ({} bytes) with cells of {} ({} bytes), {} clients",
        Q::Wire::NAME,
        size_of::<Q::Wire>(),
        <Q::Answer as Sheet>::Header::NAME,
        size_of::<<Q::Answer as Sheet>::Header>(),
        <Q::Answer as Sheet>::Cell::NAME,
        size_of::<<Q::Answer as Sheet>::Cell>(),
        exchange.max_clients,
    )
}

fn open<Q: Question>(base: &Base, exchange: &Exchange) -> Result<Questions<Q>, NodeError> {
    let need = need::<Q>(exchange);
    base.open(&exchange.name, MessagingPattern::RequestResponse, &need, || {
        base.node()
            .service_builder(&service_name(&exchange.name))
            .request_response::<Request<Q>, Cells<Q>>()
            .response_user_header::<Header<Q>>()
            .max_servers(1)
            .max_clients(exchange.max_clients)
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
