//! Both ends of `hop/past`.
//!
//! A request wakes the server and an answer wakes the clients, so that a rebuild of many pages takes a
//! round trip a page rather than a tick a page.

use std::rc::Rc;

use contract::limits::PAST_PAGE_RECORDS;
use contract::service::{NODES_MAX, PAST, PAST_CLIENTS_MAX};
use contract::wire::{PastHeaderV1, PastRequestV1, RecordV2, page_from_wire};
use contract::{PastPage, PastRequest, Refusal};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::{AllocationStrategy, MessagingPattern};
use iceoryx2::service::port_factory::request_response::PortFactory;

use crate::NodeError;
use crate::base::{Base, Ipc, service_name};
use crate::parcel::Parcel;
use crate::port::ring;

/// Event service that wakes the server.
pub(crate) const ASKED: &str = "hop/past/asked";

/// Event service that wakes the clients.
pub(crate) const ANSWERED: &str = "hop/past/answered";

type Request = Parcel<PastRequestV1>;
type Records = [Parcel<RecordV2>];
type Header = Parcel<PastHeaderV1>;

/// Answers for the past; only hopper-sim has one.
#[derive(Debug)]
pub struct PastServer {
    server: Server<Ipc, Request, (), Records, Header>,
    bell: Notifier<Ipc>,
    _base: Rc<Base>,
}

/// Asks for the past, one request at a time.
#[derive(Debug)]
pub struct PastClient {
    pending: Option<PendingResponse<Ipc, Request, (), Records, Header>>,
    client: Client<Ipc, Request, (), Records, Header>,
    bell: Notifier<Ipc>,
    records: Vec<RecordV2>,
    _base: Rc<Base>,
}

impl PastServer {
    pub(crate) fn new(base: &Rc<Base>) -> Result<Self, NodeError> {
        let factory = open(base)?;
        let server = base.port(PAST, "serving", || {
            factory
                .server_builder()
                .initial_max_slice_len(PAST_PAGE_RECORDS)
                .allocation_strategy(AllocationStrategy::Static)
                .max_loaned_responses_per_request(1)
                .create()
        })?;
        Ok(Self { server, bell: base.notifier(ANSWERED)?, _base: Rc::clone(base) })
    }

    /// Answers every request that is there. `page` may leave one unanswered: the client will ask again.
    /// Returns the refusals of malformed requests.
    ///
    /// # Errors
    /// [`NodeError::Oversize`] if a page has more than [`PAST_PAGE_RECORDS`] records.
    pub fn serve<R: Into<Option<PastPage>>>(
        &mut self,
        mut page: impl FnMut(&PastRequest) -> R,
    ) -> Result<Vec<Refusal>, NodeError> {
        let mut refusals = Vec::new();
        let mut answered = false;
        loop {
            let request = match self.server.receive() {
                Ok(Some(request)) => request,
                Ok(None) => break,
                Err(error) => {
                    tracing::debug!("receiving a request for the past: {error}");
                    break;
                }
            };
            let wire = request.payload().0;
            let asked = match PastRequest::try_from(&wire) {
                Ok(asked) => asked,
                Err(refusal) => {
                    refusals.push(refusal);
                    continue;
                }
            };
            let Some(page) = page(&asked).into() else { continue };
            let records = &page.records;
            if records.len() > PAST_PAGE_RECORDS {
                let (need, got) = (PAST_PAGE_RECORDS, records.len());
                return Err(NodeError::Oversize { service: PAST.into(), need, got });
            }
            let sent = request.loan_slice_uninit(records.len()).map(|mut answer| {
                *answer.user_header_mut() = Parcel((&page).into());
                answer.write_from_fn(|index| Parcel((&records[index]).into())).send()
            });
            match sent {
                Ok(Ok(())) => answered = true,
                // The client is gone, or gave up: it will ask again if it still wants to know.
                Ok(Err(error)) => tracing::debug!("answering for the past: {error}"),
                Err(error) => tracing::debug!("answering for the past: {error}"),
            }
        }
        if answered {
            ring(Some(&self.bell));
        }
        Ok(refusals)
    }
}

impl PastClient {
    pub(crate) fn new(base: &Rc<Base>) -> Result<Self, NodeError> {
        let factory = open(base)?;
        let client = base.port(PAST, "asking", || factory.client_builder().create())?;
        Ok(Self {
            pending: None,
            client,
            bell: base.notifier(ASKED)?,
            records: Vec::new(),
            _base: Rc::clone(base),
        })
    }

    /// Asks; a request before it that has no answer yet is given up.
    ///
    /// # Errors
    /// If there is no room for the request.
    pub fn request(&mut self, request: &PastRequest) -> Result<(), NodeError> {
        self.pending = None;
        let send_error = |error: &dyn std::fmt::Display| NodeError::Send {
            service: PAST.into(),
            cause: error.to_string(),
        };
        let sample = self.client.loan_uninit().map_err(|error| send_error(&error))?;
        match sample.write_payload(Parcel(request.into())).send() {
            Ok(pending) => self.pending = Some(pending),
            // The server comes or goes: the request is repeated at the next tick.
            Err(error) => tracing::debug!("asking for the past: {error}"),
        }
        ring(Some(&self.bell));
        Ok(())
    }

    /// The answer to the last request, once it is there.
    pub fn receive(&mut self) -> Option<Result<PastPage, Refusal>> {
        let answer = match self.pending.as_ref()?.receive() {
            Ok(answer) => answer?,
            Err(error) => {
                tracing::debug!("receiving the past: {error}");
                return None;
            }
        };
        let header = answer.user_header().0;
        self.records.clear();
        self.records.extend(answer.payload().iter().map(|record| record.0));
        drop(answer);
        self.pending = None;
        Some(page_from_wire(&header, &self.records))
    }

    /// Whether a request waits for its answer.
    #[must_use]
    pub fn is_waiting(&self) -> bool {
        self.pending.is_some()
    }
}

fn open(base: &Base) -> Result<PortFactory<Ipc, Request, (), Records, Header>, NodeError> {
    let need = format!(
        "hop.PastRequest.v1 (32 bytes) answered by hop.PastHeader.v1 (32 bytes) with cells of hop.Record.v2 ({} bytes), {PAST_CLIENTS_MAX} clients",
        size_of::<RecordV2>()
    );
    base.open(PAST, MessagingPattern::RequestResponse, &need, || {
        base.node()
            .service_builder(&service_name(PAST))
            .request_response::<Request, Records>()
            .response_user_header::<Header>()
            .max_servers(1)
            .max_clients(PAST_CLIENTS_MAX)
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
