//! What a process needs of its host.

use std::future::Future;

use contract::{Incarnation, Message, MonotonicNs, Name, Refusal, Request, RobotId};

use crate::Failure;

/// Everything outside a process: messages, the clock, its own identity, and the points at which it may be
/// interrupted. One concrete host at a time, monomorphised.
pub trait Ports: Sized {
    /// Why a port could not be had or used.
    type Error: Into<Failure> + std::fmt::Display;
    /// Subscriber of a message's topic.
    type Reader<M: Message>: Reader<M>;
    /// Publisher of a message's topic.
    type Writer<M: Message>: Writer<M, Error = Self::Error>;
    /// Asks a service, one request at a time.
    type Client<Q: Request>: Client<Q, Error = Self::Error>;
    /// Takes requests and sends their answers.
    type Server<Q: Request>: Server<Q, Error = Self::Error>;

    /// A reader of `M`'s service; if `wakes`, an arrival ends [`Ports::wait`].
    ///
    /// # Errors
    /// If the service cannot be had, or all its places are taken; so for all ports.
    ///
    /// # Panics
    /// If `wakes` is asked of a service without events.
    fn reader<M: Message>(&mut self, robot: RobotId, wakes: bool) -> Result<Self::Reader<M>, Self::Error>;

    /// As [`Ports::reader`] without waking, for a process that can do without: it fails within a fraction of a
    /// second when all places are taken.
    ///
    /// # Errors
    /// See [`Ports::reader`].
    fn try_reader<M: Message>(&mut self, robot: RobotId) -> Result<Self::Reader<M>, Self::Error>;

    /// A writer of `M`'s service.
    ///
    /// # Errors
    /// See [`Ports::reader`].
    fn writer<M: Message>(&mut self, robot: RobotId) -> Result<Self::Writer<M>, Self::Error>;

    /// A client of `Q`'s service; an answer ends [`Ports::wait`].
    ///
    /// # Errors
    /// See [`Ports::reader`].
    fn client<Q: Request>(&mut self, robot: RobotId) -> Result<Self::Client<Q>, Self::Error>;

    /// The server of `Q`'s service; a request ends [`Ports::wait`].
    ///
    /// # Errors
    /// See [`Ports::reader`].
    fn server<Q: Request>(&mut self, robot: RobotId) -> Result<Self::Server<Q>, Self::Error>;

    /// Now on the host's monotonic clock.
    fn now(&mut self) -> MonotonicNs;

    /// This life of the process.
    fn incarnation(&self) -> Incarnation;

    /// The operating system's number of this process; 0 where there is none.
    fn pid(&self) -> u32;

    /// The version of this build, which its heartbeats carry.
    fn version(&self) -> Name;

    /// Whether the operating system knows a process of this number. One of another container it does not know.
    fn process_exists(&self, pid: u32) -> bool;

    /// Whether the process shall end: a signal came, or its parent is gone.
    fn stop_requested(&self) -> bool;

    /// The name of the instance, if it has one.
    fn instance_name(&self) -> Option<&str> {
        None
    }

    /// Why nobody may be heard in this instance, to be appended to a message that names who is waited for; empty if
    /// nothing is known.
    fn absence_hint(&self) -> String {
        String::new()
    }

    /// Sleeps until a message wakes the process, there is a reason to stop, or `timeout_ns` have passed. A wake-up is
    /// a hint: look at every reader afterwards.
    fn wait(&mut self, timeout_ns: u64) -> impl Future<Output = ()>;

    /// Passes a named point, at which a test may kill or stop the process.
    fn pass(&mut self, point: &'static str) -> impl Future<Output = ()>;

    /// A computation of noticeable length has just been done. A virtual clock moves on by what it takes.
    fn computed(&mut self) -> impl Future<Output = ()>;
}

/// One end of a service that is read.
pub trait Reader<M> {
    /// The next message, oldest first per writer; `None` when there is none.
    fn receive(&mut self) -> Option<Result<M, Refusal>>;

    /// Messages that can be there at once. A loop that receives no more than that ends, however fast writers write.
    fn depth(&self) -> usize;

    /// The newest message; older ones are passed over.
    fn newest(&mut self) -> Option<Result<M, Refusal>> {
        let mut newest = None;
        for _ in 0..self.depth() {
            let Some(message) = self.receive() else { break };
            newest = Some(message);
        }
        newest
    }

    /// All messages that are there.
    fn drain(&mut self) -> Vec<Result<M, Refusal>> {
        let mut messages = Vec::new();
        while messages.len() < self.depth()
            && let Some(message) = self.receive()
        {
            messages.push(message);
        }
        messages
    }
}

/// One end of a service that is written.
pub trait Writer<M> {
    /// Why publishing failed.
    type Error;

    /// Publishes a message and wakes the readers that asked for it.
    ///
    /// # Errors
    /// If there is no room for it. A reader that comes, goes or dies meanwhile is no error.
    fn publish(&mut self, message: M) -> Result<(), Self::Error>;

    /// Connects readers that came since and hands them the history; call it once a turn.
    fn idle(&mut self) {}

    /// How many read at present, those included that died and are not yet cleaned up.
    fn readers(&self) -> usize;
}

/// The end of a service that asks. One request is under way at a time; a new one gives up the one before.
pub trait Client<Q: Request> {
    /// Why asking failed.
    type Error;

    /// Asks.
    ///
    /// # Errors
    /// If there is no room for the request. A server that is not there is no error: ask again later.
    fn request(&mut self, request: Q) -> Result<(), Self::Error>;

    /// The answer to the last request, once it is there.
    fn receive(&mut self) -> Option<Result<Q::Response, Refusal>>;

    /// Whether a request waits for its answer.
    fn is_waiting(&self) -> bool;
}

/// The end of a service that answers.
pub trait Server<Q: Request> {
    /// Why answering failed.
    type Error;

    /// Answers the requests that are there, at most one a client; `None` leaves a request unanswered, and its client
    /// will ask again. Gives the refusals of malformed requests.
    ///
    /// # Errors
    /// If an answer has more cells than a page holds.
    fn serve(&mut self, answer: impl FnMut(&Q) -> Option<Q::Response>) -> Result<Vec<Refusal>, Self::Error>;
}
