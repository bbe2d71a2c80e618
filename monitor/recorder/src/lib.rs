//! Records a mission from inside the monitor, with ports of its own and a file.
//!
//! The bytes are made by [`recording::Recorder`]; here messages are read and bytes are appended. It has ports of its own
//! so that it reads everything, whatever else of the monitor passes over. It looks the more often the fuller its queues
//! were, so that quick missions are whole and slow ones cost little.

#![warn(clippy::disallowed_methods)]

#[cfg(feature = "shell")]
mod shell;

#[cfg(feature = "shell")]
pub use shell::open;

use std::io::Write;

use contract::message::Visitor;
use contract::{
    Brief, Command, Control, Decision, Heartbeat, MapPatch, MapRequest, MonotonicNs, Pacing, PastRequest,
    Policy, RobotId, RunId, State,
};
use process::{Client, Exit, Failure, Ports, Reader, accept};
use recording::{Context, JsonMessage, MachineLoad, RecordedMessage as Message, RecordingError, Requests};

/// Longest and shortest pause between two looks, nanoseconds.
const PERIODS_NS: [u64; 2] = [20_000_000, 1_000_000];

/// Messages of one look at which the shortest queues, those of patches and commands, are a quarter full.
const MANY: usize = 4;

/// Pause between two looks at the machine's load, nanoseconds.
const HOST_PERIOD_NS: u64 = 500_000_000;

/// Where the bytes go.
pub trait Sink: Write {
    /// What messages to the user call it.
    fn name(&self) -> String;

    /// How busy the machine was since the last call, if that is at least `least_ns` ago.
    fn load(&mut self, now: MonotonicNs, least_ns: u64) -> Option<MachineLoad>;
}

/// Records until the mission ends.
pub struct Recorder<P: Ports, S: Sink> {
    engine: recording::Recorder,
    ports: RecorderPorts<P>,
    sink: S,
    period_ns: u64,
    failed: bool,
}

/// Readers of every public message, and clients for what was missed.
pub struct RecorderPorts<P: Ports> {
    briefs: P::Reader<Brief>,
    states: P::Reader<State>,
    maps: P::Reader<MapPatch>,
    commands: P::Reader<Command>,
    beats: P::Reader<Heartbeat>,
    controls: P::Reader<Control>,
    pacings: P::Reader<Pacing>,
    policies: Option<P::Reader<Policy>>,
    past: P::Client<PastRequest>,
    snapshots: P::Client<MapRequest>,
    /// One reader for each message without a schema of ours.
    others: Vec<Drain>,
}

/// Gives the messages of one service that came since the last call.
type Drain = Box<dyn FnMut() -> Vec<JsonMessage>>;

impl<P: Ports + 'static, S: Sink> Recorder<P, S> {
    /// Writes the head of the recording: what is known before the first message is in `context`.
    ///
    /// # Errors
    /// If the head cannot be written.
    pub fn begin(
        context: &Context,
        ports: RecorderPorts<P>,
        mut sink: S,
        now: MonotonicNs,
    ) -> Result<Self, Failure> {
        let engine = recording::Recorder::new(context, now).map_err(Failure::run)?;
        sink.write_all(&engine.bytes()).map_err(|error| {
            Failure::new(Exit::Failed, format!("{} cannot be written: {error}", sink.name()))
        })?;
        Ok(Self { engine, ports, sink, period_ns: PERIODS_NS[0], failed: false })
    }

    /// Where the bytes went.
    #[must_use]
    pub fn sink(&self) -> &S {
        &self.sink
    }

    fn append(&mut self) {
        let bytes = self.engine.bytes();
        if let Err(error) = self.sink.write_all(&bytes)
            && !self.failed
        {
            self.fail(&error);
        }
    }

    fn fail(&mut self, error: &dyn std::fmt::Display) {
        self.failed = true;
        tracing::error!(
            "the recording ends here: {}: {error}; `hopper bag recover` recovers what is written",
            self.sink.name()
        );
    }

    fn record(
        &mut self,
        messages: Vec<Message>,
        others: &[JsonMessage],
        now: MonotonicNs,
    ) -> Result<Requests, RecordingError> {
        let mut wanted = Requests::default();
        for message in messages {
            wanted = wanted.or(self.engine.on(message, now)?);
        }
        for message in others {
            self.engine.on_json(message, now)?;
        }
        Ok(wanted.or(self.engine.tick(now)?))
    }
}

impl<P: Ports + 'static, S: Sink> monitor::process::Recorder<P> for Recorder<P, S> {
    fn period_ns(&self) -> u64 {
        self.period_ns
    }

    fn turn(&mut self, ports: &mut P) -> Result<(), Failure> {
        if self.failed {
            return Ok(());
        }
        let now = ports.now();
        let (mut messages, most) = self.ports.receive();
        messages.extend(self.sink.load(now, HOST_PERIOD_NS).map(Message::Host));
        let others = self.ports.receive_others();
        self.period_ns = if most >= MANY { PERIODS_NS[1] } else { PERIODS_NS[0].min(self.period_ns * 2) };
        match self.record(messages, &others, now) {
            Ok(wanted) => {
                self.append();
                self.ports.ask(wanted).map_err(Into::into)
            }
            Err(error) => {
                self.fail(&error);
                Ok(())
            }
        }
    }

    fn is_whole_until(&self, run: RunId, decision: Decision) -> bool {
        self.failed || self.engine.is_whole_until(run, decision)
    }

    fn finish(&mut self, ports: &mut P) -> Result<(), Failure> {
        // What could not be asked for any more does not keep the file from its end.
        let turned = self.turn(ports);
        let now = ports.now();
        let last = self.sink.load(now, 0).map(Message::Host);
        if !self.failed
            && let Err(error) = last
                .map_or(Ok(Requests::default()), |host| self.engine.on(host, now))
                .and_then(|_| self.engine.finish(now))
        {
            self.fail(&error);
        }
        self.append();
        for (topic, missing) in self.engine.missing() {
            tracing::warn!("{missing} messages of {topic} did not reach the recording");
        }
        if self.failed {
            let message = format!("{} ends early: see above", self.sink.name());
            return Err(Failure::new(Exit::Failed, message));
        }
        turned
    }
}

/// Opens a reader for each message that is recorded as JSON.
struct Others<'p, P: Ports> {
    ports: &'p mut P,
    readers: Vec<Drain>,
    error: Option<P::Error>,
}

impl<P: Ports + 'static> Visitor for Others<'_, P> {
    fn message<M: contract::Message>(&mut self) {
        if JsonMessage::topic::<M>().is_none() || self.error.is_some() {
            return;
        }
        match self.ports.reader::<M>(RobotId(0), false) {
            Ok(mut reader) => self.readers.push(Box::new(move || {
                let messages = reader.drain().into_iter().filter_map(|message| accept(Some(message)));
                messages.filter_map(|message| JsonMessage::of(&message)).collect()
            })),
            Err(error) => self.error = Some(error),
        }
    }

    fn request<Q: contract::Request>(&mut self) {}
}

impl<P: Ports + 'static> RecorderPorts<P> {
    /// Opens every port; that of policies only if they are wanted, since planners make them for readers alone.
    ///
    /// # Errors
    /// If a port cannot be had.
    pub fn open(ports: &mut P, with_policies: bool) -> Result<Self, P::Error> {
        let robot = RobotId(0);
        let mut others = Others { ports, readers: Vec::new(), error: None };
        contract::wire::visit(&mut others);
        let Others { ports, readers: others, error } = others;
        if let Some(error) = error {
            return Err(error);
        }
        Ok(Self {
            briefs: ports.reader(robot, false)?,
            states: ports.reader(robot, false)?,
            maps: ports.reader(robot, false)?,
            commands: ports.reader(robot, false)?,
            beats: ports.reader(robot, false)?,
            controls: ports.reader(robot, false)?,
            pacings: ports.reader(robot, false)?,
            policies: with_policies.then(|| ports.reader(robot, false)).transpose()?,
            past: ports.client(robot)?,
            snapshots: ports.client(robot)?,
            others,
        })
    }

    fn ask(&mut self, wanted: Requests) -> Result<(), P::Error> {
        if let Some(request) = wanted.past {
            self.past.request(request)?;
        }
        if let Some(request) = wanted.map {
            self.snapshots.request(request)?;
        }
        Ok(())
    }

    fn receive_others(&mut self) -> Vec<JsonMessage> {
        self.others.iter_mut().flat_map(|drain| drain()).collect()
    }

    /// Everything that came, in the order of publication, and how many of one service came at most.
    fn receive(&mut self) -> (Vec<Message>, usize) {
        // The page before the patches: with it come all patches published before it was made.
        let page = accept(self.snapshots.receive()).map(Message::Page);
        // States before patches, so that no patch comes without the state it belongs to.
        let mut ordered = known(self.states.drain(), Message::State);
        let states = ordered.len();
        ordered.extend(known(self.maps.drain(), Message::Patch));
        let maps = ordered.len() - states;
        ordered.extend(known(self.commands.drain(), Message::Command));
        let commands = ordered.len() - states - maps;
        // Stable: what was published at one moment stays in the order of its services.
        ordered.sort_by_key(Message::published);
        let mut messages = known(self.beats.drain(), Message::Heartbeat);
        messages.extend(known(self.briefs.drain(), Message::Brief));
        messages.extend(known(self.pacings.drain(), Message::Pacing));
        messages.extend(known(self.controls.drain(), Message::Control));
        messages.append(&mut ordered);
        messages.extend(page);
        messages.extend(accept(self.past.receive()).map(Message::Past));
        messages.extend(accept(self.policies.as_mut().and_then(Reader::newest)).map(Message::Policy));
        (messages, maps.max(commands).max(states / 4))
    }
}

/// The well-formed messages; others are logged and dropped.
fn known<M>(messages: Vec<Result<M, contract::Refusal>>, message: impl Fn(M) -> Message) -> Vec<Message> {
    messages.into_iter().filter_map(|received| accept(Some(received)).map(&message)).collect()
}
