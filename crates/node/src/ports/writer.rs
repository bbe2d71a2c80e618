//! Writing end of a publish-subscribe service.

use std::rc::Rc;

use contract::message::Capacity;
use contract::{Message, RobotId};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::{LoanError, SendError};
use iceoryx2::prelude::AllocationStrategy;

use super::service::{
    MiddlewarePublisher, PublishSubscribe, connect, count_readers, notify, open_publish_subscribe,
};
use super::zero_copy::ZeroCopy;
use crate::error::NodeError;
use crate::memory_budget;
use crate::middleware::Ipc;
use crate::session::Session;
use crate::waiting::PATIENCE;

/// How often handing over is tried while a reader comes or goes.
const HAND_OVER_TRIES: usize = 3;

/// Writes a service. If it is one of [`Capacity::Grid`], it takes shared memory when the first message is published,
/// for messages of that many cells, and is remade for messages of another size once the old memory is released: at no
/// time does shared memory hold both.
#[derive(Debug)]
pub struct Writer<M: Message> {
    publisher: Option<MiddlewarePublisher<M>>,
    service: PublishSubscribe<M>,
    notifier: Option<Notifier<Ipc>>,
    name: String,
    robot: RobotId,
    session: Rc<Session>,
}

impl<M: Message> Writer<M> {
    pub(crate) fn new(session: &Rc<Session>, robot: RobotId) -> Result<Self, NodeError> {
        let name = M::SERVICE.name_of(robot);
        let service = match M::SERVICE.capacity {
            Capacity::Cells(cells) => {
                memory_budget::check_writer::<M>(robot, cells)?;
                open_publish_subscribe::<M>(session, robot, PATIENCE)?
            }
            Capacity::Grid => open_publish_subscribe::<M>(session, robot, PATIENCE)?,
        };
        let mut writer =
            Self { publisher: None, service, notifier: None, name, robot, session: Rc::clone(session) };
        if let Capacity::Cells(cells) = M::SERVICE.capacity {
            writer.publisher = Some(writer.make_publisher(cells)?);
        }
        if M::SERVICE.event {
            writer.notifier = Some(session.notifier(&writer.name)?);
        }
        Ok(writer)
    }

    /// A publisher of messages of up to `cells` cells, with the shared memory for them.
    fn make_publisher(&self, cells: usize) -> Result<MiddlewarePublisher<M>, NodeError> {
        self.session.port(PATIENCE, &self.name, "publishing", || {
            self.service
                .publisher_builder()
                .max_loaned_samples(1)
                .initial_max_slice_len(cells)
                .allocation_strategy(AllocationStrategy::Static)
                .create()
        })
    }

    /// Publishes bytes that need not be a valid message, for tests of what readers refuse.
    ///
    /// # Errors
    /// As [`process::Writer::publish`].
    pub fn publish_wire(&mut self, header: M::Header, cells: &[M::Cell]) -> Result<(), NodeError> {
        self.send(header, cells.len(), |index| cells[index])
    }

    fn send(
        &mut self,
        header: M::Header,
        cells: usize,
        cell: impl Fn(usize) -> M::Cell,
    ) -> Result<(), NodeError> {
        if M::SERVICE.capacity == Capacity::Grid {
            self.fit(cells)?;
        }
        let Some(publisher) = &self.publisher else { return Ok(()) };
        let most = publisher.initial_max_slice_len();
        if cells > most {
            return Err(NodeError::Oversize { service: self.name.clone(), need: most, got: cells });
        }
        hand_over(&self.name, || {
            let mut sample = publisher.loan_slice_uninit(cells)?;
            *sample.user_header_mut() = ZeroCopy(header);
            sample.write_from_fn(|index| ZeroCopy(cell(index))).send()
        })?;
        self.notifier.as_ref().inspect(|notifier| notify(notifier));
        Ok(())
    }

    /// Makes the publisher for messages of exactly `cells` cells.
    fn fit(&mut self, cells: usize) -> Result<(), NodeError> {
        if self.publisher.as_ref().is_some_and(|publisher| publisher.initial_max_slice_len() == cells) {
            return Ok(());
        }
        self.publisher = None;
        memory_budget::check_writer::<M>(self.robot, cells)?;
        self.publisher = Some(self.make_publisher(cells)?);
        Ok(())
    }
}

impl<M: Message> process::Writer<M> for Writer<M> {
    type Error = NodeError;

    fn publish(&mut self, message: M) -> Result<(), NodeError> {
        self.send(message.header(), message.cells(), |index| message.cell(index))
    }

    fn idle(&mut self) {
        if let Some(publisher) = &self.publisher {
            connect(&self.name, publisher);
        }
    }

    fn readers(&self) -> usize {
        count_readers::<M>(&self.service)
    }
}

/// Hands a sample over. A reader that cannot be reached because it comes or goes gets the next message; only a message
/// without a slot is an error.
fn hand_over(service: &str, mut send: impl FnMut() -> Result<usize, SendError>) -> Result<(), NodeError> {
    for attempt in 1..=HAND_OVER_TRIES {
        match send() {
            Ok(_) => return Ok(()),
            Err(SendError::LoanError(error)) => {
                return Err(NodeError::Send { service: service.into(), cause: loan_text(error) });
            }
            Err(error) => tracing::debug!(service, attempt, "handing over: {error}"),
        }
    }
    tracing::warn!(service, "a message may not have reached every reader");
    Ok(())
}

fn loan_text(error: LoanError) -> String {
    match error {
        LoanError::OutOfMemory => "no free slot: readers that died hold them all".into(),
        other => other.to_string(),
    }
}
