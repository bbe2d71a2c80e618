//! A relay of three processes straight on the middleware, which does no work: the yardstick of our latency.
//!
//! The source sends a state, the second process answers it with a map, the third answers the map with a command, and
//! the source takes the time from before the first send to after the last receive. Each process sleeps until its event
//! comes, copies what it receives, and fills what it sends: what any stack over this middleware must do. Types and
//! quality of service are those of the mission, and so is the size of a map's patch, if the caller passes the cells
//! that the mission's patches have.

use std::time::Duration;

use bytemuck::Zeroable;
use contract::wire::{CommandV3, MapPatchV2, SeenCellV4, StateV4};
use contract::{Command, MapPatch, Message, MonotonicNs, RobotId, State};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;

use crate::clock;
use crate::error::NodeError;
use crate::membership::instance::Instance;
use crate::middleware::Ipc;
use crate::ports::ZeroCopy;
use crate::ports::service::{
    MiddlewarePublisher, MiddlewareSubscriber, count_readers, count_writers, open_publish_subscribe,
};
use crate::session::Session;
use crate::waiting::{self, Waiting};

/// One of the two processes that answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Answers states with maps.
    Map,
    /// Answers maps with commands.
    Command,
}

impl Stage {
    /// Its name in command-line arguments.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Stage::Map => "map",
            Stage::Command => "command",
        }
    }
}

impl std::str::FromStr for Stage {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Stage::Map, Stage::Command]
            .into_iter()
            .find(|stage| stage.as_str() == text)
            .ok_or_else(|| format!("a stage is map or command, got {text:?}"))
    }
}

/// Where the relay runs and what it carries.
#[derive(Clone, Debug)]
pub struct Relay {
    /// An instance of its own.
    pub instance: Instance,
    /// Cells of each patch of the map.
    pub cells: usize,
}

/// The round number by which everybody knows that it is over.
const END: u64 = u64::MAX;

/// How long a process sleeps at most.
const PATIENCE: Duration = Duration::from_millis(200);

/// How long the source waits for the others to start.
const START: Duration = Duration::from_secs(10);

/// After this long without a message an answering process takes the source for dead.
const SILENCE: Duration = Duration::from_secs(30);

const ROBOT: RobotId = RobotId(0);

struct Sender<M: Message> {
    publisher: MiddlewarePublisher<M>,
    notifier: Notifier<Ipc>,
}

struct Receiver<M: Message> {
    subscriber: MiddlewareSubscriber<M>,
    /// The last message received.
    cells: Vec<M::Cell>,
}

impl Relay {
    /// Runs `rounds` rounds, one each `period` (as fast as they go if it is zero), after a tenth as many that do not
    /// count. Returns the rounds' durations in nanoseconds, in order.
    ///
    /// # Errors
    /// If the other two do not start within 10 s, or a message is lost.
    pub fn source(&self, rounds: u64, period: Duration) -> Result<Vec<u64>, NodeError> {
        let session = Session::join(&self.instance, "relay", Waiting::new(waiting::PATIENCE, None))?;
        let listener = listener::<Command>(&session)?;
        let states = Sender::<State>::new(&session, 1)?;
        let mut commands = Receiver::<Command>::new(&session)?;
        wait_for_others(&session)?;
        let warm_up = rounds / 10;
        let mut durations = Vec::with_capacity(rounds as usize);
        let mut due = clock::now();
        for round in 0..warm_up + rounds {
            while clock::now() < due {
                let ns = due.since_ns(clock::now());
                std::thread::sleep(Duration::from_nanos(ns));
            }
            let started = clock::now();
            states.send((), 1, StateV4 { decision: round, ..StateV4::zeroed() })?;
            while commands.receive_command()? != Some(round) {
                sleep(&listener)?;
                if clock::now().since_ns(started) > START.as_nanos() as u64 {
                    return Err(lost("a round of the relay"));
                }
            }
            let ended = clock::now();
            if round >= warm_up {
                durations.push(ended.since_ns(started));
            }
            due = started.plus_ns(period.as_nanos() as u64);
        }
        states.send((), 1, StateV4 { decision: END, ..StateV4::zeroed() })?;
        // The end must be received before its sender goes, history and all.
        while commands.receive_command()? != Some(END) {
            sleep(&listener)?;
        }
        Ok(durations)
    }

    /// Answers until the source is done.
    ///
    /// # Errors
    /// If the middleware fails.
    pub fn answer(&self, stage: Stage) -> Result<(), NodeError> {
        let session = Session::join(&self.instance, "relay", Waiting::new(waiting::PATIENCE, None))?;
        match stage {
            Stage::Map => self.answer_with_maps(&session),
            Stage::Command => answer_with_commands(&session),
        }
    }

    fn answer_with_maps(&self, session: &Session) -> Result<(), NodeError> {
        let listener = listener::<State>(session)?;
        let mut states = Receiver::<State>::new(session)?;
        let maps = Sender::<MapPatch>::new(session, self.cells)?;
        let cell =
            SeenCellV4 { height_m: 1.0, gradient: [0.5; 2], index: 0, visits: 0, soil: 1, reported: 0 };
        let mut heard = clock::now();
        loop {
            while states.receive()?.is_some() {
                heard = clock::now();
                let through = states.cells[0].decision;
                maps.send(MapPatchV2 { through, ..MapPatchV2::zeroed() }, self.cells, cell)?;
                if through == END {
                    return Ok(());
                }
            }
            sleep_unless_silent(&listener, heard)?;
        }
    }
}

fn answer_with_commands(session: &Session) -> Result<(), NodeError> {
    let listener = listener::<MapPatch>(session)?;
    let mut maps = Receiver::<MapPatch>::new(session)?;
    let commands = Sender::<Command>::new(session, 1)?;
    let mut heard = clock::now();
    loop {
        while let Some(header) = maps.receive()? {
            heard = clock::now();
            commands.send((), 1, CommandV3 { decision: header.through, ..CommandV3::zeroed() })?;
            if header.through == END {
                return Ok(());
            }
        }
        sleep_unless_silent(&listener, heard)?;
    }
}

impl<M: Message> Sender<M> {
    fn new(session: &Session, cells: usize) -> Result<Self, NodeError> {
        let service = open_publish_subscribe::<M>(session, ROBOT, waiting::PATIENCE)?;
        let name = M::SERVICE.name_of(ROBOT);
        let notifier = session.notifier(&name)?;
        let publisher = session.port(waiting::PATIENCE, &name, "publishing", || {
            service.publisher_builder().initial_max_slice_len(cells).create()
        })?;
        Ok(Self { publisher, notifier })
    }

    /// Sends a message of that many equal cells.
    fn send(&self, header: M::Header, cells: usize, cell: M::Cell) -> Result<(), NodeError> {
        let mut sample = self.publisher.loan_slice_uninit(cells).map_err(|error| lost(&error.to_string()))?;
        *sample.user_header_mut() = ZeroCopy(header);
        let sample = sample.write_from_fn(|_| ZeroCopy(cell));
        sample.send().map_err(|error| lost(&error.to_string()))?;
        self.notifier.notify().map(drop).map_err(|error| lost(&error.to_string()))
    }
}

impl<M: Message> Receiver<M> {
    fn new(session: &Session) -> Result<Self, NodeError> {
        let service = open_publish_subscribe::<M>(session, ROBOT, waiting::PATIENCE)?;
        let name = M::SERVICE.name_of(ROBOT);
        let subscriber = session
            .port(waiting::PATIENCE, &name, "subscribing", || service.subscriber_builder().create())?;
        Ok(Self { subscriber, cells: Vec::new() })
    }

    /// The header of the next message, whose cells are copied.
    fn receive(&mut self) -> Result<Option<M::Header>, NodeError> {
        let Some(sample) = self.subscriber.receive().map_err(|error| lost(&error.to_string()))? else {
            return Ok(None);
        };
        self.cells.clear();
        self.cells.extend(sample.payload().iter().map(|cell| cell.0));
        Ok(Some(sample.user_header().0))
    }
}

impl Receiver<Command> {
    /// The decision of the next command.
    fn receive_command(&mut self) -> Result<Option<u64>, NodeError> {
        Ok(self.receive()?.map(|()| self.cells[0].decision))
    }
}

fn listener<M: Message>(session: &Session) -> Result<Listener<Ipc>, NodeError> {
    session.listener(&M::SERVICE.name_of(ROBOT))
}

fn wait_for_others(session: &Session) -> Result<(), NodeError> {
    let states = open_publish_subscribe::<State>(session, ROBOT, waiting::PATIENCE)?;
    let maps = open_publish_subscribe::<MapPatch>(session, ROBOT, waiting::PATIENCE)?;
    let commands = open_publish_subscribe::<Command>(session, ROBOT, waiting::PATIENCE)?;
    let started = clock::now();
    while count_readers::<State>(&states) == 0
        || count_readers::<MapPatch>(&maps) == 0
        || count_writers::<Command>(&commands) == 0
    {
        if clock::now().since_ns(started) > START.as_nanos() as u64 {
            return Err(lost("the other two processes"));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}

fn sleep(listener: &Listener<Ipc>) -> Result<(), NodeError> {
    listener.timed_wait(|_| {}, PATIENCE).map(drop).map_err(|error| lost(&error.to_string()))
}

fn sleep_unless_silent(listener: &Listener<Ipc>, heard: MonotonicNs) -> Result<(), NodeError> {
    if clock::now().since_ns(heard) > SILENCE.as_nanos() as u64 {
        return Err(lost("the source"));
    }
    sleep(listener)
}

fn lost(cause: &str) -> NodeError {
    NodeError::Middleware { what: "the relay", cause: cause.into() }
}
