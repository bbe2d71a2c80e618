//! The work loop that every process shares, against ports that somebody else provides.
//!
//! A process is a struct generic over [`Ports`]: it opens its readers, writers, clients and servers there, reads the
//! clock there, and does one turn of its loop in [`Process::turn`]. Three hosts provide ports: `node` (shared memory
//! and the real clock), and `simulation` with lockstep (direct calls) and the fault simulation (virtual time, messages
//! that get lost, processes that die). So what ships is what is simulated.
//!
//! Turns are `async` for the simulation's sake alone: where a process may be killed or stopped, or time passes, it
//! awaits its host. Real ports never suspend, so [`block_on`] is all that a shell needs, and the compiler leaves
//! nothing of it. No executor, no wakers, no threads.

#![warn(clippy::disallowed_methods)]

mod exit;
mod membership;
mod patience;
mod peers;
mod ports;

pub use exit::{Exit, Failure};
pub use membership::{Membership, Terms};
pub use patience::Patience;
pub use peers::Builds;
pub use ports::{Client, Ports, Reader, Server, Writer};

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use contract::Refusal;

/// How long a work loop sleeps at most, nanoseconds: a lost wake-up costs no more.
pub const TICK_NS: u64 = 10_000_000;

/// What follows a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Sleep until a message wakes the process, but no longer than so many nanoseconds; then another turn.
    Sleep(u64),
    /// The loop ends; heartbeats and locks are given up.
    Leave(Exit),
}

/// A process that has joined its instance.
pub trait Process<P: Ports> {
    /// One turn of the work loop: reads what came, lets the engine decide, publishes, beats.
    ///
    /// # Errors
    /// If a port fails, or patience has run out: the process ends with that exit code.
    fn turn(&mut self, ports: &mut P) -> impl Future<Output = Result<Turn, Failure>>;
}

/// Turns until the process leaves, or is to stop.
///
/// # Errors
/// The first error of a turn.
pub async fn run<P: Ports>(process: &mut impl Process<P>, ports: &mut P) -> Result<Exit, Failure> {
    let mut sleep_ns = 0;
    loop {
        ports.wait(sleep_ns).await;
        if ports.stop_requested() {
            return Ok(Exit::Interrupted);
        }
        match process.turn(ports).await? {
            Turn::Sleep(ns) => sleep_ns = ns,
            Turn::Leave(exit) => return Ok(exit),
        }
    }
}

/// Runs a future of ports that never suspend.
///
/// # Panics
/// If it suspends.
// A turn's future takes kilobytes: inlined, it is made where it is run, and not moved there.
#[inline(always)]
pub fn block_on<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => value,
        Poll::Pending => panic!("these ports never suspend"),
    }
}

/// The message, or nothing with a log line on why it was refused.
#[inline]
pub fn accept<T>(message: Option<Result<T, Refusal>>) -> Option<T> {
    match message? {
        Ok(message) => Some(message),
        Err(refusal) => {
            log_refusal(&refusal);
            None
        }
    }
}

/// Kinds of refusals that are counted apart; the others are counted together.
const KINDS_MAX: usize = 256;

/// Logs why a message was refused: the first, second, fourth, eighth, … for each reason and malformed field, since a
/// peer that is asked again and again may answer in the same way without end.
pub fn log_refusal(refusal: &Refusal) {
    let reason = refusal.reason();
    let kind = if let Refusal::Malformed { field, .. } = refusal { field } else { reason };
    match worth_a_line(kind) {
        Some(1) => tracing::warn!(reason, "refused a message: {refusal}"),
        Some(count) => tracing::warn!(reason, "refused a message, {count} by now: {refusal}"),
        None => {}
    }
}

/// Counts a refusal of this thread; its number within its kind, if the log gets a line for it.
fn worth_a_line(kind: &str) -> Option<u64> {
    thread_local! {
        static COUNTS: RefCell<BTreeMap<String, u64>> = const { RefCell::new(BTreeMap::new()) };
    }
    COUNTS.with_borrow_mut(|counts| {
        let known = counts.len() < KINDS_MAX || counts.contains_key(kind);
        let count = counts.entry(if known { kind.into() } else { String::new() }).or_default();
        *count += 1;
        count.is_power_of_two().then_some(*count)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P-PAST-LOST.
    #[test]
    fn refusals_without_end_make_ever_fewer_lines() {
        let lines: Vec<u64> = (0..100_000).filter_map(|_| worth_a_line("stale_term")).collect();
        assert_eq!((lines.len(), &lines[..4]), (17, &[1, 2, 4, 8][..]));
        assert_eq!(worth_a_line("wrong_run"), Some(1), "another kind");
        for kind in 0..100_000 {
            worth_a_line(&kind.to_string());
        }
        assert_eq!(worth_a_line("wrong_run"), Some(2), "one that was counted apart stays so");
    }
}
