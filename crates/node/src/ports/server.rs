//! Answering end of a request-response service.

use std::rc::Rc;

use contract::{Payload, Refusal, Request, RobotId};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::AllocationStrategy;

use super::service::{Active, Answer, MiddlewareServer, notify, open_request_response, responded};
use super::zero_copy::ZeroCopy;
use crate::error::NodeError;
use crate::memory_budget;
use crate::middleware::Ipc;
use crate::session::Session;
use crate::waiting::PATIENCE;

/// Answers a service, whose only server it is. An answer wakes the clients, so that many pages take a round trip each
/// rather than a tick each.
#[derive(Debug)]
pub struct Server<Q: Request> {
    server: MiddlewareServer<Q>,
    notifier: Notifier<Ipc>,
    name: String,
    _session: Rc<Session>,
}

impl<Q: Request> Server<Q> {
    pub(crate) fn new(session: &Rc<Session>, robot: RobotId) -> Result<Self, NodeError> {
        let name = Q::SERVICE.name_of(robot);
        memory_budget::check_server::<Q>(robot)?;
        let service = open_request_response::<Q>(session, robot, PATIENCE)?;
        let server = session.port(PATIENCE, &name, "serving", || {
            service
                .server_builder()
                .initial_max_slice_len(Q::SERVICE.page)
                .allocation_strategy(AllocationStrategy::Static)
                .max_loaned_responses_per_request(1)
                .create()
        })?;
        let notifier = session.notifier(&responded(&name))?;
        Ok(Self { server, notifier, name, _session: Rc::clone(session) })
    }

    fn next_request(&self) -> Option<Active<Q>> {
        self.server.receive().unwrap_or_else(|error| {
            tracing::debug!(service = self.name, "receiving a request: {error}");
            None
        })
    }

    /// Answers one request; `false` if its client is gone or has given up. It will ask again if it still wants to
    /// know.
    fn send(&self, request: &Active<Q>, page: &Answer<Q>) -> bool {
        let sent = request.loan_slice_uninit(page.cells()).map(|mut answer| {
            *answer.user_header_mut() = ZeroCopy(page.header());
            answer.write_from_fn(|index| ZeroCopy(page.cell(index))).send()
        });
        match sent {
            Ok(Ok(())) => return true,
            Ok(Err(error)) => tracing::debug!(service = self.name, "answering: {error}"),
            Err(error) => tracing::debug!(service = self.name, "answering: {error}"),
        }
        false
    }
}

impl<Q: Request> process::Server<Q> for Server<Q> {
    type Error = NodeError;

    /// At most one answer a client: a client that asks without end keeps neither the others nor the server waiting.
    /// What is left came meanwhile, and ends the next wait at once.
    fn serve(&mut self, mut answer: impl FnMut(&Q) -> Option<Answer<Q>>) -> Result<Vec<Refusal>, NodeError> {
        let mut refusals = Vec::new();
        let mut answered = false;
        // A client has one request at a time, so there are no more, however fast it asks again.
        for _ in 0..Q::SERVICE.max_clients {
            let Some(request) = self.next_request() else { break };
            let wire = request.payload().0;
            let question = match Q::from_wire(&(), &[wire]) {
                Ok(question) => question,
                Err(refusal) => {
                    refusals.push(refusal);
                    continue;
                }
            };
            let Some(page) = answer(&question) else { continue };
            let (need, got) = (Q::SERVICE.page, page.cells());
            if got > need {
                return Err(NodeError::Oversize { service: self.name.clone(), need, got });
            }
            answered |= self.send(&request, &page);
        }
        if answered {
            notify(&self.notifier);
        }
        Ok(refusals)
    }
}
