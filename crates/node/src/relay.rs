//! A relay of three processes straight on the middleware, which does no work: the yardstick of our latency.
//!
//! The source sends a state, the second process answers it with a map, the third answers the map with a
//! command, and the source takes the time from before the first send to after the last receive. Each process
//! sleeps until its event comes, copies what it receives, and fills what it sends: what any stack over this
//! middleware must do. Types and qualities of service are those of the mission, and so is the size of a map's
//! patch, if the caller gives it the cells that the mission's patches have.

use std::rc::Rc;
use std::time::Duration;

use bytemuck::Zeroable;
use contract::service::{self, Topic};
use contract::wire::{CommandV1, MapPatchV1, SeenCellV1, StateV3, Wire};
use contract::{MapPatch, MonotonicNs, RobotId};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;

use crate::base::{Base, Ipc};
use crate::parcel::Parcel;
use crate::port::{count_readers, count_writers, open_single, open_slices};
use crate::{Instance, NodeError, clock};

/// A process that answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Answers states with maps.
    Map,
    /// Answers maps with commands.
    Command,
}

impl Stage {
    /// The name in arguments.
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

/// The relay.
#[derive(Clone, Debug)]
pub struct Relay {
    /// The instance it runs in.
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

/// After so long without news an answering process takes the source for dead.
const SILENCE: Duration = Duration::from_secs(30);

/// Slots a sender loans at once, listeners woken, and a copy of every payload: one link of the relay.
struct Single<W: Wire> {
    publisher: Option<Publisher<Ipc, Parcel<W>, ()>>,
    subscriber: Option<Subscriber<Ipc, Parcel<W>, ()>>,
}

struct Maps {
    publisher: Option<Publisher<Ipc, [Parcel<SeenCellV1>], Parcel<MapPatchV1>>>,
    subscriber: Option<Subscriber<Ipc, [Parcel<SeenCellV1>], Parcel<MapPatchV1>>>,
    cells: Vec<SeenCellV1>,
}

fn state_topic() -> Topic {
    service::state(RobotId(0))
}

fn map_topic() -> Topic {
    service::map(RobotId(0))
}

fn command_topic() -> Topic {
    service::command(RobotId(0))
}

impl Relay {
    /// Runs `rounds` rounds, one each `period` (as fast as they go if it is zero), after a tenth as many that
    /// do not count. Returns the rounds' durations in nanoseconds, in order.
    ///
    /// # Errors
    /// If the other two do not start within 10 s, or a message is lost.
    pub fn source(&self, rounds: u64, period: Duration) -> Result<Vec<u64>, NodeError> {
        let base = Rc::new(Base::new(&self.instance, "relay")?);
        let bell = base.notifier(&state_topic().name)?;
        let news = base.listener(&command_topic().name)?;
        let states = Single::<StateV3>::new(&base, &state_topic(), true)?;
        let commands = Single::<CommandV1>::new(&base, &command_topic(), false)?;
        wait_for_others(&base)?;
        let warm_up = rounds / 10;
        let mut durations = Vec::with_capacity(rounds as usize);
        let mut due = clock::now();
        for round in 0..warm_up + rounds {
            while clock::now() < due {
                let ns = due.since_ns(clock::now());
                std::thread::sleep(Duration::from_nanos(ns));
            }
            let started = clock::now();
            states.send(&StateV3 { decision: round, ..StateV3::zeroed() }, &bell)?;
            while commands.receive()?.is_none_or(|command| command.decision != round) {
                sleep(&news)?;
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
        states.send(&StateV3 { decision: END, ..StateV3::zeroed() }, &bell)?;
        // The end must be heard before its sender goes, history and all.
        while commands.receive()?.is_none_or(|command| command.decision != END) {
            sleep(&news)?;
        }
        Ok(durations)
    }

    /// Answers until the source is done.
    ///
    /// # Errors
    /// If the middleware cannot be had.
    pub fn answer(&self, stage: Stage) -> Result<(), NodeError> {
        let base = Rc::new(Base::new(&self.instance, "relay")?);
        match stage {
            Stage::Map => self.answer_with_maps(&base),
            Stage::Command => self.answer_with_commands(&base),
        }
    }

    fn answer_with_maps(&self, base: &Base) -> Result<(), NodeError> {
        let news = base.listener(&state_topic().name)?;
        let bell = base.notifier(&map_topic().name)?;
        let states = Single::<StateV3>::new(base, &state_topic(), false)?;
        let maps = Maps::new(base, Some(self.cells))?;
        let cell = SeenCellV1 { height_m: 1.0, gradient: [0.5; 2], index: 0, soil: 1, passable: 1 };
        let mut heard = clock::now();
        loop {
            while let Some(state) = states.receive()? {
                heard = clock::now();
                let header = MapPatchV1 { through: state.decision, ..MapPatchV1::zeroed() };
                maps.send(&header, self.cells, cell, &bell)?;
                if state.decision == END {
                    return Ok(());
                }
            }
            sleep_unless_silent(&news, heard)?;
        }
    }

    fn answer_with_commands(&self, base: &Base) -> Result<(), NodeError> {
        let news = base.listener(&map_topic().name)?;
        let bell = base.notifier(&command_topic().name)?;
        let mut maps = Maps::new(base, None)?;
        let commands = Single::<CommandV1>::new(base, &command_topic(), true)?;
        let mut heard = clock::now();
        loop {
            while let Some(header) = maps.receive()? {
                heard = clock::now();
                commands.send(&CommandV1 { decision: header.through, ..CommandV1::zeroed() }, &bell)?;
                if header.through == END {
                    return Ok(());
                }
            }
            sleep_unless_silent(&news, heard)?;
        }
    }
}

impl<W: Wire> Single<W> {
    fn new(base: &Base, topic: &Topic, writes: bool) -> Result<Self, NodeError> {
        let factory = open_single::<W>(base, topic)?;
        let (mut publisher, mut subscriber) = (None, None);
        if writes {
            publisher = Some(base.port(&topic.name, "publishing", || factory.publisher_builder().create())?);
        } else {
            subscriber =
                Some(base.port(&topic.name, "subscribing", || factory.subscriber_builder().create())?);
        }
        Ok(Self { publisher, subscriber })
    }

    fn send(&self, wire: &W, bell: &Notifier<Ipc>) -> Result<(), NodeError> {
        let publisher = self.publisher.as_ref().expect("made to write");
        let sample = publisher.loan_uninit().map_err(|error| lost(&error.to_string()))?;
        sample.write_payload(Parcel(*wire)).send().map_err(|error| lost(&error.to_string()))?;
        notify(bell)
    }

    fn receive(&self) -> Result<Option<W>, NodeError> {
        let subscriber = self.subscriber.as_ref().expect("made to read");
        let sample = subscriber.receive().map_err(|error| lost(&error.to_string()))?;
        Ok(sample.map(|sample| sample.payload().0))
    }
}

impl Maps {
    fn new(base: &Base, writes: Option<usize>) -> Result<Self, NodeError> {
        let topic = map_topic();
        let factory = open_slices::<MapPatch>(base, &topic)?;
        let (mut publisher, mut subscriber) = (None, None);
        if let Some(cells) = writes {
            publisher = Some(base.port(&topic.name, "publishing", || {
                factory.publisher_builder().initial_max_slice_len(cells).create()
            })?);
        } else {
            subscriber =
                Some(base.port(&topic.name, "subscribing", || factory.subscriber_builder().create())?);
        }
        Ok(Self { publisher, subscriber, cells: Vec::new() })
    }

    fn send(
        &self,
        header: &MapPatchV1,
        cells: usize,
        cell: SeenCellV1,
        bell: &Notifier<Ipc>,
    ) -> Result<(), NodeError> {
        let publisher = self.publisher.as_ref().expect("made to write");
        let mut sample = publisher.loan_slice_uninit(cells).map_err(|error| lost(&error.to_string()))?;
        *sample.user_header_mut() = Parcel(*header);
        let sample = sample.write_from_fn(|_| Parcel(cell));
        sample.send().map_err(|error| lost(&error.to_string()))?;
        notify(bell)
    }

    fn receive(&mut self) -> Result<Option<MapPatchV1>, NodeError> {
        let subscriber = self.subscriber.as_ref().expect("made to read");
        let Some(sample) = subscriber.receive().map_err(|error| lost(&error.to_string()))? else {
            return Ok(None);
        };
        self.cells.clear();
        self.cells.extend(sample.payload().iter().map(|cell| cell.0));
        Ok(Some(sample.user_header().0))
    }
}

fn wait_for_others(base: &Base) -> Result<(), NodeError> {
    let states = open_single::<StateV3>(base, &state_topic())?;
    let maps = open_slices::<MapPatch>(base, &map_topic())?;
    let commands = open_single::<CommandV1>(base, &command_topic())?;
    let started = clock::now();
    while count_readers(&states) == 0 || count_readers(&maps) == 0 || count_writers(&commands) == 0 {
        if clock::now().since_ns(started) > START.as_nanos() as u64 {
            return Err(lost("the other two processes"));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}

fn sleep(news: &Listener<Ipc>) -> Result<(), NodeError> {
    news.timed_wait(|_| {}, PATIENCE).map(drop).map_err(|error| lost(&error.to_string()))
}

fn sleep_unless_silent(news: &Listener<Ipc>, heard: MonotonicNs) -> Result<(), NodeError> {
    if clock::now().since_ns(heard) > SILENCE.as_nanos() as u64 {
        return Err(lost("the source"));
    }
    sleep(news)
}

fn notify(bell: &Notifier<Ipc>) -> Result<(), NodeError> {
    bell.notify().map(drop).map_err(|error| lost(&error.to_string()))
}

fn lost(cause: &str) -> NodeError {
    NodeError::Middleware { what: "the relay", cause: cause.into() }
}
