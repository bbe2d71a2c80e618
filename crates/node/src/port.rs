//! Typed ends of the publish-subscribe services.
//!
//! A writer loans a slot, fills it and hands it over, then wakes the topic's listeners. A reader copies a
//! sample first and validates the copy: its writer could still write to the slot.

use std::marker::PhantomData;
use std::rc::Rc;
use std::time::Duration;

use bytemuck::Zeroable;
use contract::service::{NODES_MAX, Topic};
use contract::wire::Wire;
use contract::{Brief, Command, Control, Heartbeat, MapPatch, Policy, Refusal, State, Tempo};
use iceoryx2::port::LoanError;
use iceoryx2::port::SendError;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{AllocationStrategy, MessagingPattern};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};

use crate::base::{Base, GLIMPSE, Ipc, PATIENCE, need, service_name};
use crate::parcel::Parcel;
use crate::room;
use crate::{NodeError, Plain, Sheet};

/// Writes `hop/brief`.
pub type BriefWriter = Writer<Brief>;
/// Reads `hop/brief`.
pub type BriefReader = Reader<Brief>;
/// Writes `hop/rN/state`.
pub type StateWriter = Writer<State>;
/// Reads `hop/rN/state`.
pub type StateReader = Reader<State>;
/// Writes `hop/rN/command`.
pub type CommandWriter = Writer<Command>;
/// Reads `hop/rN/command`.
pub type CommandReader = Reader<Command>;
/// Writes `hop/rN/control`.
pub type ControlWriter = Writer<Control>;
/// Reads `hop/rN/control`.
pub type ControlReader = Reader<Control>;
/// Writes `hop/rN/tempo`.
pub type TempoWriter = Writer<Tempo>;
/// Reads `hop/rN/tempo`.
pub type TempoReader = Reader<Tempo>;
/// Writes `hop/heartbeat`.
pub type HeartbeatWriter = Writer<Heartbeat>;
/// Reads `hop/heartbeat`.
pub type HeartbeatReader = Reader<Heartbeat>;
/// Writes `hop/rN/map`.
pub type MapWriter = SheetWriter<MapPatch>;
/// Reads `hop/rN/map`.
pub type MapReader = SheetReader<MapPatch>;
/// Writes `hop/rN/policy`.
pub type PolicyWriter = SheetWriter<Policy>;
/// Reads `hop/rN/policy`.
pub type PolicyReader = SheetReader<Policy>;

/// How often handing over is tried while a reader comes or goes.
const TRIES: usize = 3;

pub(crate) type Single<W> = PortFactory<Ipc, Parcel<W>, ()>;
type SlicePublisher<S> = Publisher<Ipc, [Parcel<<S as Sheet>::Cell>], Parcel<<S as Sheet>::Header>>;
type SliceSubscriber<S> = Subscriber<Ipc, [Parcel<<S as Sheet>::Cell>], Parcel<<S as Sheet>::Header>>;
pub(crate) type Slices<S> = PortFactory<Ipc, [Parcel<<S as Sheet>::Cell>], Parcel<<S as Sheet>::Header>>;

/// The only, or one, writer of a topic whose messages have one size.
#[derive(Debug)]
pub struct Writer<M: Plain> {
    publisher: Publisher<Ipc, Parcel<M::Wire>, ()>,
    factory: Single<M::Wire>,
    bell: Option<Notifier<Ipc>>,
    topic: String,
    _base: Rc<Base>,
}

/// A reader of a topic whose messages have one size.
#[derive(Debug)]
pub struct Reader<M: Plain> {
    subscriber: Subscriber<Ipc, Parcel<M::Wire>, ()>,
    factory: Single<M::Wire>,
    topic: String,
    /// Messages that the queues of all writers hold.
    most: usize,
    _base: Rc<Base>,
}

/// The only, or one, writer of a topic whose messages are a header and cells.
#[derive(Debug)]
pub struct SheetWriter<S: Sheet> {
    publisher: SlicePublisher<S>,
    factory: Slices<S>,
    bell: Option<Notifier<Ipc>>,
    topic: String,
    _base: Rc<Base>,
}

/// A reader of a topic whose messages are a header and cells. It copies into one buffer again and again.
#[derive(Debug)]
pub struct SheetReader<S: Sheet> {
    subscriber: SliceSubscriber<S>,
    factory: Slices<S>,
    header: S::Header,
    cells: Vec<S::Cell>,
    topic: String,
    /// Messages that the queues of all writers hold.
    most: usize,
    _base: Rc<Base>,
    _sheet: PhantomData<S>,
}

impl<M: Plain> Writer<M> {
    pub(crate) fn new(base: &Rc<Base>, topic: &Topic) -> Result<Self, NodeError> {
        room::check_topic(topic, size_of::<M::Wire>())?;
        let factory = open_single::<M::Wire>(base, topic)?;
        let publisher = base
            .port(&topic.name, "publishing", || factory.publisher_builder().max_loaned_samples(1).create())?;
        let bell = topic.event.then(|| base.notifier(&topic.name)).transpose()?;
        Ok(Self { publisher, factory, bell, topic: topic.name.clone(), _base: Rc::clone(base) })
    }

    /// Publishes a message and wakes who listens.
    ///
    /// # Errors
    /// If there is no room for it. A reader that comes, goes or dies meanwhile is no error.
    pub fn publish(&self, message: &M) -> Result<(), NodeError> {
        self.publish_wire(message.to_wire())
    }

    /// Publishes bytes that need not be a valid message, for tests of who refuses what.
    ///
    /// # Errors
    /// As [`Writer::publish`].
    pub fn publish_wire(&self, wire: M::Wire) -> Result<(), NodeError> {
        hand_over(&self.topic, || {
            let sample = self.publisher.loan_uninit()?;
            sample.write_payload(Parcel(wire)).send()
        })?;
        ring(self.bell.as_ref());
        Ok(())
    }

    /// Serves readers that came since; call it once per work loop.
    ///
    /// # Errors
    /// None at present.
    pub fn idle(&self) -> Result<(), NodeError> {
        settle(&self.topic, &self.publisher);
        Ok(())
    }

    /// Whether somebody reads.
    #[must_use]
    pub fn has_readers(&self) -> bool {
        count_readers(&self.factory) > 0
    }
}

impl<M: Plain> Reader<M> {
    pub(crate) fn new(base: &Rc<Base>, topic: &Topic) -> Result<Self, NodeError> {
        let factory = open_single::<M::Wire>(base, topic)?;
        let subscriber = base.port(&topic.name, "subscribing", || factory.subscriber_builder().create())?;
        settle(&topic.name, &subscriber);
        let most = topic.max_publishers * topic.buffer;
        Ok(Self { subscriber, factory, topic: topic.name.clone(), most, _base: Rc::clone(base) })
    }

    /// The next message, oldest first; `None` when there is none.
    pub fn receive(&mut self) -> Option<Result<M, Refusal>> {
        self.receive_wire().map(|wire| M::from_wire(&wire))
    }

    /// The newest message; older ones are passed over unread.
    pub fn newest(&mut self) -> Option<Result<M, Refusal>> {
        let mut newest = None;
        for _ in 0..self.most {
            let Some(wire) = self.receive_wire() else { break };
            newest = Some(wire);
        }
        newest.map(|wire| M::from_wire(&wire))
    }

    /// All messages that are there, oldest first per writer: no more than queues hold, however fast a writer
    /// fills them again.
    pub fn drain(&mut self) -> impl Iterator<Item = Result<M, Refusal>> + '_ {
        let most = self.most;
        std::iter::from_fn(|| self.receive()).take(most)
    }

    /// Writers and readers at present, those not yet freed after death included.
    #[must_use]
    pub fn census(&self) -> (usize, usize) {
        (count_writers(&self.factory), count_readers(&self.factory))
    }

    /// A private copy of the next sample.
    fn receive_wire(&mut self) -> Option<M::Wire> {
        match self.subscriber.receive() {
            Ok(sample) => sample.map(|sample| sample.payload().0),
            Err(error) => {
                tracing::debug!(topic = self.topic, "receiving: {error}");
                None
            }
        }
    }
}

impl<S: Sheet> SheetWriter<S> {
    pub(crate) fn new(base: &Rc<Base>, topic: &Topic, cells: usize) -> Result<Self, NodeError> {
        room::check_topic(topic, size_of::<S::Header>() + cells * size_of::<S::Cell>())?;
        let factory = open_slices::<S>(base, topic)?;
        let publisher = base.port(&topic.name, "publishing", || {
            factory
                .publisher_builder()
                .max_loaned_samples(1)
                .initial_max_slice_len(cells)
                .allocation_strategy(AllocationStrategy::Static)
                .create()
        })?;
        let bell = topic.event.then(|| base.notifier(&topic.name)).transpose()?;
        Ok(Self { publisher, factory, bell, topic: topic.name.clone(), _base: Rc::clone(base) })
    }

    /// Publishes a message and wakes who listens.
    ///
    /// # Errors
    /// [`NodeError::Oversize`] if it has more cells than the writer was made for; otherwise if there is no
    /// room for it.
    pub fn publish(&self, message: &S) -> Result<(), NodeError> {
        self.publish_wire(&message.header(), message.cells(), |index| message.cell(index))
    }

    /// Publishes bytes that need not be a valid message, for tests of who refuses what.
    ///
    /// # Errors
    /// As [`SheetWriter::publish`].
    pub fn publish_wire(
        &self,
        header: &S::Header,
        cells: usize,
        cell: impl Fn(usize) -> S::Cell,
    ) -> Result<(), NodeError> {
        let most = self.publisher.initial_max_slice_len();
        if cells > most {
            return Err(NodeError::Oversize { service: self.topic.clone(), need: most, got: cells });
        }
        hand_over(&self.topic, || {
            let mut sample = self.publisher.loan_slice_uninit(cells)?;
            *sample.user_header_mut() = Parcel(*header);
            sample.write_from_fn(|index| Parcel(cell(index))).send()
        })?;
        ring(self.bell.as_ref());
        Ok(())
    }

    /// Serves readers that came since; call it once per work loop.
    ///
    /// # Errors
    /// None at present.
    pub fn idle(&self) -> Result<(), NodeError> {
        settle(&self.topic, &self.publisher);
        Ok(())
    }

    /// Whether somebody reads.
    #[must_use]
    pub fn has_readers(&self) -> bool {
        count_readers(&self.factory) > 0
    }
}

impl<S: Sheet> SheetReader<S> {
    pub(crate) fn new(base: &Rc<Base>, topic: &Topic) -> Result<Self, NodeError> {
        Self::within(PATIENCE, base, topic)
    }

    /// As [`SheetReader::new`], for whoever can do without and must not wait.
    pub(crate) fn glimpse(base: &Rc<Base>, topic: &Topic) -> Result<Self, NodeError> {
        Self::within(GLIMPSE, base, topic)
    }

    fn within(patience: Duration, base: &Rc<Base>, topic: &Topic) -> Result<Self, NodeError> {
        let factory = open_slices_within::<S>(patience, base, topic)?;
        let subscriber =
            base.port_within(patience, &topic.name, "subscribing", || factory.subscriber_builder().create())?;
        settle(&topic.name, &subscriber);
        Ok(Self {
            subscriber,
            factory,
            header: S::Header::zeroed(),
            cells: Vec::new(),
            topic: topic.name.clone(),
            most: topic.max_publishers * topic.buffer,
            _base: Rc::clone(base),
            _sheet: PhantomData,
        })
    }

    /// The next message, oldest first; `None` when there is none.
    pub fn receive(&mut self) -> Option<Result<S, Refusal>> {
        self.receive_wire().then(|| S::from_wire(&self.header, &self.cells))
    }

    /// The newest message; older ones are passed over unread.
    pub fn newest(&mut self) -> Option<Result<S, Refusal>> {
        let mut any = false;
        for _ in 0..self.most {
            if !self.receive_wire() {
                break;
            }
            any = true;
        }
        any.then(|| S::from_wire(&self.header, &self.cells))
    }

    /// All messages that are there, oldest first per writer: no more than queues hold, however fast a writer
    /// fills them again.
    pub fn drain(&mut self) -> impl Iterator<Item = Result<S, Refusal>> + '_ {
        let most = self.most;
        std::iter::from_fn(|| self.receive()).take(most)
    }

    /// Writers and readers at present, those not yet freed after death included.
    #[must_use]
    pub fn census(&self) -> (usize, usize) {
        (count_writers(&self.factory), count_readers(&self.factory))
    }

    /// Copies the next sample, once, into our own buffer.
    fn receive_wire(&mut self) -> bool {
        match self.subscriber.receive() {
            Ok(Some(sample)) => {
                self.header = sample.user_header().0;
                self.cells.clear();
                self.cells.extend(sample.payload().iter().map(|cell| cell.0));
                true
            }
            Ok(None) => false,
            Err(error) => {
                tracing::debug!(topic = self.topic, "receiving: {error}");
                false
            }
        }
    }
}

/// A topic as its messages of one size ask for it, under its name.
pub(crate) fn plain_text<M: Plain>(topic: &Topic) -> String {
    format!("{}: {}", topic.name, need(&single_types::<M::Wire>(), topic))
}

/// A topic as its messages of a header and cells ask for it, under its name.
pub(crate) fn sheet_text<S: Sheet>(topic: &Topic) -> String {
    format!("{}: {}", topic.name, need(&slice_types::<S>(), topic))
}

fn single_types<W: Wire>() -> String {
    format!("{} ({} bytes)", W::NAME, size_of::<W>())
}

fn slice_types<S: Sheet>() -> String {
    format!(
        "{} ({} bytes) with cells of {} ({} bytes)",
        S::Header::NAME,
        size_of::<S::Header>(),
        S::Cell::NAME,
        size_of::<S::Cell>()
    )
}

pub(crate) fn open_single<W: Wire>(base: &Base, topic: &Topic) -> Result<Single<W>, NodeError> {
    let need = need(&single_types::<W>(), topic);
    base.open(&topic.name, MessagingPattern::PublishSubscribe, &need, || {
        base.node()
            .service_builder(&service_name(&topic.name))
            .publish_subscribe::<Parcel<W>>()
            .max_publishers(topic.max_publishers)
            .max_subscribers(topic.max_subscribers)
            .max_nodes(NODES_MAX)
            .history_size(topic.history)
            .subscriber_max_buffer_size(topic.buffer)
            .subscriber_max_borrowed_samples(topic.borrowed)
            .enable_safe_overflow(true)
            .open_or_create()
    })
}

pub(crate) fn open_slices<S: Sheet>(base: &Base, topic: &Topic) -> Result<Slices<S>, NodeError> {
    open_slices_within::<S>(PATIENCE, base, topic)
}

fn open_slices_within<S: Sheet>(
    patience: Duration,
    base: &Base,
    topic: &Topic,
) -> Result<Slices<S>, NodeError> {
    let need = need(&slice_types::<S>(), topic);
    base.open_within(patience, &topic.name, MessagingPattern::PublishSubscribe, &need, || {
        base.node()
            .service_builder(&service_name(&topic.name))
            .publish_subscribe::<[Parcel<S::Cell>]>()
            .user_header::<Parcel<S::Header>>()
            .max_publishers(topic.max_publishers)
            .max_subscribers(topic.max_subscribers)
            .max_nodes(NODES_MAX)
            .history_size(topic.history)
            .subscriber_max_buffer_size(topic.buffer)
            .subscriber_max_borrowed_samples(topic.borrowed)
            .enable_safe_overflow(true)
            .open_or_create()
    })
}

/// The types of a message in words.
pub(crate) fn type_text(header: &TypeDetail, payload: &TypeDetail) -> String {
    let one = |detail: &TypeDetail| format!("{} ({} bytes)", detail.type_name(), detail.size());
    match payload.variant() {
        TypeVariant::FixedSize => one(payload),
        TypeVariant::Dynamic if header.size() == 0 => format!("cells of {}", one(payload)),
        TypeVariant::Dynamic => format!("{} with cells of {}", one(header), one(payload)),
    }
}

/// Hands a sample over. Who cannot be reached because it comes or goes will be served by what is sent next;
/// only a message without a slot is an error.
fn hand_over(topic: &str, mut send: impl FnMut() -> Result<usize, SendError>) -> Result<(), NodeError> {
    for attempt in 1..=TRIES {
        match send() {
            Ok(_) => return Ok(()),
            Err(SendError::LoanError(error)) => {
                return Err(NodeError::Send { service: topic.into(), cause: loan_text(error) });
            }
            Err(error) => tracing::debug!(topic, attempt, "handing over: {error}"),
        }
    }
    tracing::warn!(topic, "a message may not have reached every reader");
    Ok(())
}

fn loan_text(error: LoanError) -> String {
    match error {
        LoanError::OutOfMemory => "no free slot: readers that died hold them all".into(),
        other => other.to_string(),
    }
}

/// Wakes the listeners. Events are hints: everybody also looks at every tick.
pub(crate) fn ring(bell: Option<&Notifier<Ipc>>) {
    if let Some(Err(error)) = bell.map(Notifier::notify) {
        tracing::debug!("waking: {error}");
    }
}

/// Connects with who came since, and hands late comers the history.
pub(crate) fn settle(topic: &str, port: &impl UpdateConnections) {
    if let Err(error) = port.update_connections() {
        tracing::debug!(topic, "connecting: {error}");
    }
}

pub(crate) fn count_readers<P, H>(factory: &PortFactory<Ipc, P, H>) -> usize
where
    P: std::fmt::Debug + iceoryx2::prelude::IceoryxSend + ?Sized,
    H: std::fmt::Debug + iceoryx2::prelude::ZeroCopySend,
{
    use iceoryx2::prelude::PortFactory as _;
    factory.dynamic_config().number_of_subscribers()
}

pub(crate) fn count_writers<P, H>(factory: &PortFactory<Ipc, P, H>) -> usize
where
    P: std::fmt::Debug + iceoryx2::prelude::IceoryxSend + ?Sized,
    H: std::fmt::Debug + iceoryx2::prelude::ZeroCopySend,
{
    use iceoryx2::prelude::PortFactory as _;
    factory.dynamic_config().number_of_publishers()
}
