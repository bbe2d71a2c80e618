//! Asking end of a request-response service.

use std::rc::Rc;

use contract::{Payload, Refusal, Request, RobotId};
use iceoryx2::port::notifier::Notifier;

use super::service::{Answer, MiddlewareClient, Pending, notify, open_request_response, requested};
use super::zero_copy::ZeroCopy;
use crate::error::NodeError;
use crate::middleware::Ipc;
use crate::session::Session;
use crate::waiting::PATIENCE;

/// Asks a service, one request at a time. A request wakes the server.
#[derive(Debug)]
pub struct Client<Q: Request> {
    pending: Option<Pending<Q>>,
    client: MiddlewareClient<Q>,
    notifier: Notifier<Ipc>,
    cells: Vec<<Answer<Q> as Payload>::Cell>,
    name: String,
    _session: Rc<Session>,
}

impl<Q: Request> Client<Q> {
    pub(crate) fn new(session: &Rc<Session>, robot: RobotId) -> Result<Self, NodeError> {
        let name = Q::SERVICE.name_of(robot);
        let service = open_request_response::<Q>(session, robot, PATIENCE)?;
        let client = session.port(PATIENCE, &name, "asking", || service.client_builder().create())?;
        let notifier = session.notifier(&requested(&name))?;
        let (pending, cells) = (None, Vec::new());
        Ok(Self { pending, client, notifier, cells, name, _session: Rc::clone(session) })
    }

    /// Asks with bytes that need not be a valid request, for tests of what servers refuse.
    ///
    /// # Errors
    /// As [`process::Client::request`].
    pub fn request_wire(&mut self, request: Q::Cell) -> Result<(), NodeError> {
        self.pending = None;
        let service = &self.name;
        let sample = self
            .client
            .loan_uninit()
            .map_err(|error| NodeError::Send { service: service.clone(), cause: error.to_string() })?;
        match sample.write_payload(ZeroCopy(request)).send() {
            Ok(pending) => self.pending = Some(pending),
            // The server comes or goes: the request will be repeated.
            Err(error) => tracing::debug!(service, "asking: {error}"),
        }
        notify(&self.notifier);
        Ok(())
    }
}

impl<Q: Request> process::Client<Q> for Client<Q> {
    type Error = NodeError;

    fn request(&mut self, request: Q) -> Result<(), NodeError> {
        debug_assert_eq!(request.cells(), 1, "a request has one cell");
        self.request_wire(request.cell(0))
    }

    fn receive(&mut self) -> Option<Result<Q::Response, Refusal>> {
        let answer = match self.pending.as_ref()?.receive() {
            Ok(answer) => answer?,
            Err(error) => {
                tracing::debug!(service = self.name, "receiving an answer: {error}");
                return None;
            }
        };
        let header = answer.user_header().0;
        self.cells.clear();
        self.cells.extend(answer.payload().iter().map(|cell| cell.0));
        drop(answer);
        self.pending = None;
        Some(Q::Response::from_wire(&header, &self.cells))
    }

    fn is_waiting(&self) -> bool {
        self.pending.is_some()
    }
}
