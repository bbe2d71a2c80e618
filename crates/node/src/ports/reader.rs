//! Reading end of a publish-subscribe service.

use std::rc::Rc;
use std::time::Duration;

use bytemuck::Zeroable;
use contract::{Message, Refusal, RobotId};

use super::{MiddlewareSubscriber, PublishSubscribe, connect, count_writers, open_publish_subscribe};
use crate::error::NodeError;
use crate::session::Session;

/// Reads a service. It copies every message into the same buffer before it validates it.
#[derive(Debug)]
pub struct Reader<M: Message> {
    subscriber: MiddlewareSubscriber<M>,
    service: PublishSubscribe<M>,
    header: M::Header,
    cells: Vec<M::Cell>,
    name: String,
    _session: Rc<Session>,
}

impl<M: Message> Reader<M> {
    pub(crate) fn new(session: &Rc<Session>, robot: RobotId, patience: Duration) -> Result<Self, NodeError> {
        let name = M::SERVICE.name_of(robot);
        let service = open_publish_subscribe::<M>(session, robot, patience)?;
        let subscriber =
            session.port(patience, &name, "subscribing", || service.subscriber_builder().create())?;
        connect(&name, &subscriber);
        Ok(Self {
            subscriber,
            service,
            header: M::Header::zeroed(),
            cells: Vec::new(),
            name,
            _session: Rc::clone(session),
        })
    }

    /// How many write at present, including those that died and are not yet cleaned up.
    #[must_use]
    pub fn writers(&self) -> usize {
        count_writers::<M>(&self.service)
    }

    /// Copies the next sample into the buffer; `false` if there is none.
    fn copy_next(&mut self) -> bool {
        match self.subscriber.receive() {
            Ok(Some(sample)) => {
                self.header = sample.user_header().0;
                self.cells.clear();
                self.cells.extend(sample.payload().iter().map(|cell| cell.0));
                true
            }
            Ok(None) => false,
            Err(error) => {
                tracing::debug!(service = self.name, "receiving: {error}");
                false
            }
        }
    }
}

impl<M: Message> process::Reader<M> for Reader<M> {
    fn receive(&mut self) -> Option<Result<M, Refusal>> {
        self.copy_next().then(|| M::from_wire(&self.header, &self.cells))
    }

    fn depth(&self) -> usize {
        M::SERVICE.depth()
    }

    /// The newest message; older ones are not even validated.
    fn newest(&mut self) -> Option<Result<M, Refusal>> {
        let mut copied = 0;
        while copied < M::SERVICE.depth() && self.copy_next() {
            copied += 1;
        }
        (copied > 0).then(|| M::from_wire(&self.header, &self.cells))
    }
}
