//! Names and qualities of service: one function per service, since the first creator fixes them.

use crate::RobotId;
use crate::limits::{MAP_PAGE_CELLS, PAST_PAGE_RECORDS, TRUTH_PAGE_CELLS};

/// How a publish-subscribe service is opened; the same numbers whoever comes first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Service name.
    pub name: String,
    /// Most publishers at once.
    pub max_publishers: usize,
    /// Most subscribers at once.
    pub max_subscribers: usize,
    /// Samples a late subscriber gets.
    pub history: usize,
    /// Samples a subscriber's queue holds before the oldest gives way.
    pub buffer: usize,
    /// Samples a subscriber may hold at once.
    pub borrowed: usize,
    /// Whether an event service of the same name wakes the readers.
    pub event: bool,
}

/// Most nodes (processes, live or not yet cleaned up) on any service.
pub const NODES_MAX: usize = 24;

fn topic(name: impl Into<String>) -> Topic {
    Topic {
        name: name.into(),
        max_publishers: 1,
        max_subscribers: 8,
        history: 1,
        buffer: 1,
        borrowed: 1,
        event: false,
    }
}

/// `hop/brief`: written by hopper-sim.
#[must_use]
pub fn brief() -> Topic {
    Topic { max_subscribers: 16, ..topic("hop/brief") }
}

/// `hop/rN/state`: written by hopper-sim; wakes perception.
#[must_use]
pub fn state(robot: RobotId) -> Topic {
    Topic { max_subscribers: 16, buffer: 64, event: true, ..topic(format!("hop/r{robot}/state")) }
}

/// `hop/rN/map`: patches, written by perception; wakes planners. Who comes late asks for a [`snapshot`], and
/// so does every reader after a landing of more patches than the buffer holds: one that reveals more than
/// 16,384 cells, as no sensor of the built-in scenarios can.
#[must_use]
pub fn map(robot: RobotId) -> Topic {
    Topic { history: 0, buffer: 16, event: true, ..topic(format!("hop/r{robot}/map")) }
}

/// `hop/rN/command`: written by planners; hopper-sim the only reader that acts.
#[must_use]
pub fn command(robot: RobotId) -> Topic {
    Topic { max_publishers: 8, history: 0, buffer: 16, event: true, ..topic(format!("hop/r{robot}/command")) }
}

/// `hop/rN/control`: written by monitors that were allowed to; read by hopper-sim and planners.
#[must_use]
pub fn control(robot: RobotId) -> Topic {
    Topic {
        max_publishers: 4,
        max_subscribers: 16,
        history: 0,
        buffer: 16,
        ..topic(format!("hop/r{robot}/control"))
    }
}

/// `hop/rN/tempo`: written by hopper-sim when it changes.
#[must_use]
pub fn tempo(robot: RobotId) -> Topic {
    topic(format!("hop/r{robot}/tempo"))
}

/// `hop/rN/policy`: written by planners while someone listens: hopper-sim for its fallback, a page, a recording.
#[must_use]
pub fn policy(robot: RobotId) -> Topic {
    Topic { max_publishers: 8, max_subscribers: 3, history: 0, ..topic(format!("hop/r{robot}/policy")) }
}

/// `hop/heartbeat`: written by everyone.
#[must_use]
pub fn heartbeat() -> Topic {
    Topic { max_publishers: 16, max_subscribers: 16, buffer: 16, ..topic("hop/heartbeat") }
}

/// How a request-response service is opened. The server answers in pages, so that its memory depends on the
/// size of a page and not on how much there is to tell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// Service name.
    pub name: String,
    /// Most clients at once.
    pub max_clients: usize,
    /// Most cells, or records, of an answer.
    pub page: usize,
}

/// `hop/past`: served by hopper-sim.
#[must_use]
pub fn past() -> Exchange {
    Exchange { name: "hop/past".into(), max_clients: 16, page: PAST_PAGE_RECORDS }
}

/// `truth/terrain`: served by hopper-sim. Perception asks, and whoever echoes it by hand; no planner may.
#[must_use]
pub fn truth() -> Exchange {
    Exchange { name: "truth/terrain".into(), max_clients: 8, page: TRUTH_PAGE_CELLS }
}

/// `hop/rN/snapshot`: the map for whoever has missed a patch; served by perception.
#[must_use]
pub fn snapshot(robot: RobotId) -> Exchange {
    Exchange { name: format!("hop/r{robot}/snapshot"), max_clients: 8, page: MAP_PAGE_CELLS }
}
