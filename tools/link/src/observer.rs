//! The downlink as an observer of the mission.

use std::cell::RefCell;
use std::rc::Rc;

use contract::{Decision, RunId};
use link::{Downlink, DownlinkPorts};
use monitor::process::Observer;
use node::{Failure, Node};

use crate::transport::Transport;

/// Packets that are sent at one look at most: receivers of datagrams buffer some hundred kilobytes.
const AT_ONCE: usize = 16;

/// Pause between two looks while packets wait, nanoseconds.
const BUSY_NS: u64 = 1_000_000;

/// The downlink, and where its packets go. It outlives the mission.
pub struct Sender {
    pub downlink: Downlink,
    pub transport: Transport,
}

impl Sender {
    /// Sends what may be sent now; whether more waits for the next look.
    pub fn send(&mut self) -> bool {
        if !self.transport.is_open() {
            return false;
        }
        for _ in 0..AT_ONCE {
            let Some(packet) = self.downlink.take() else { return false };
            self.transport.send(&packet);
        }
        true
    }
}

/// Reads the mission.
pub struct LinkObserver {
    ports: DownlinkPorts<Node>,
    sender: Rc<RefCell<Sender>>,
    is_busy: bool,
    /// Whether the log has said that all has been sent.
    is_complete: bool,
}

impl LinkObserver {
    /// Opens the ports.
    ///
    /// # Errors
    /// If a port cannot be had.
    pub fn open(node: &mut Node, sender: Rc<RefCell<Sender>>) -> Result<Self, Failure> {
        Ok(Self { ports: DownlinkPorts::open(node)?, sender, is_busy: false, is_complete: false })
    }
}

impl Observer<Node> for LinkObserver {
    fn period_ns(&self) -> u64 {
        if self.is_busy { BUSY_NS } else { self.ports.period_ns() }
    }

    fn turn(&mut self, node: &mut Node) -> Result<(), Failure> {
        let mut sender = self.sender.borrow_mut();
        self.ports.turn(node, &mut sender.downlink)?;
        self.is_busy = sender.send();
        let is_complete = sender.downlink.is_complete() && sender.transport.is_flushed();
        if is_complete && !self.is_complete {
            tracing::info!("all of the mission has been sent");
        }
        // What is told again from time to time does not make it incomplete.
        self.is_complete |= is_complete;
        Ok(())
    }

    fn is_whole_until(&self, run: RunId, decision: Decision) -> bool {
        self.sender.borrow().downlink.is_whole_until(run, decision)
    }

    fn finish(&mut self, node: &mut Node) -> Result<(), Failure> {
        self.turn(node)
    }
}
