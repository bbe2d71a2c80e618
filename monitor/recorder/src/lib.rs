//! Records a mission from inside the monitor, with ports of its own and a file.
//!
//! The bytes are made by [`recording::Recorder`]; here messages are read and bytes are appended. It has ports of its own
//! so that it reads everything, whatever else of the monitor passes over. It looks the more often the fuller its queues
//! were, so that quick missions are whole and slow ones cost little.

#![warn(clippy::disallowed_methods)]

mod ports;
mod robot_ports;
#[cfg(feature = "shell")]
mod shell;

#[cfg(feature = "shell")]
pub use shell::open;

use std::io::Write;

use contract::{Decision, MonotonicNs, RunId};
use process::{Exit, Failure, Ports};
use recording::{Context, MachineLoad, RecordedMessage as Message, RecordingError, Requests};

pub use ports::{Received, RecorderPorts};

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
    failed: bool,
}

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
        Ok(Self { engine, ports, sink, failed: false })
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

    fn record(&mut self, received: Received, now: MonotonicNs) -> Result<Requests, RecordingError> {
        let load = self.sink.load(now, HOST_PERIOD_NS);
        let wanted = self.engine.with(|transcript| {
            if let Some(load) = load {
                transcript.on(Message::Host(load), now);
            }
            received.tell(transcript, now)
        })?;
        Ok(wanted.or(self.engine.tick(now)?))
    }
}

impl<P: Ports + 'static, S: Sink> monitor::process::Observer<P> for Recorder<P, S> {
    fn period_ns(&self) -> u64 {
        self.ports.period_ns()
    }

    fn turn(&mut self, ports: &mut P) -> Result<(), Failure> {
        if self.failed {
            return Ok(());
        }
        let now = ports.now();
        let received = self.ports.receive(ports);
        match self.record(received, now) {
            Ok(wanted) => {
                self.append();
                self.ports.ask(ports, wanted).map_err(Into::into)
            }
            Err(error) => {
                self.fail(&error);
                Ok(())
            }
        }
    }

    fn is_whole_until(&self, run: RunId, decision: Decision) -> bool {
        let waits_for_prior = self.engine.lacks_prior() && self.ports.can_have_prior();
        let waits_for_routes = self.engine.lacks_routes() && self.ports.can_have_routes();
        let waits_for_details = self.engine.lacks_details() && self.ports.can_have_details();
        let waits = waits_for_prior || waits_for_routes || waits_for_details;
        self.failed || !waits && self.engine.is_whole_until(run, decision)
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
