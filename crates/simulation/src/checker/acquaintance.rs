//! What processes have heard of each other.

use std::collections::{BTreeMap, BTreeSet};

use contract::{Heartbeat, Incarnation, MonotonicNs};

use crate::life::Life;

/// What processes have heard of each other, whatever the mission.
#[derive(Debug, Default)]
pub(super) struct Acquaintance {
    /// When each process last heard that each other lives, and the count of that beat.
    heard: BTreeMap<(Incarnation, Incarnation), (u64, MonotonicNs)>,
    /// Planners that were ordered to take over.
    pub handed_over: BTreeSet<Incarnation>,
    /// Lives of other builds.
    pub foreign: BTreeSet<Incarnation>,
    /// Which life has received a heartbeat of which life of another build.
    recognised: BTreeSet<(Incarnation, Incarnation)>,
}

impl Acquaintance {
    /// A process has heard that another lives.
    pub fn heard(&mut self, listener: &Life, beat: &Heartbeat, now: MonotonicNs) {
        if beat.version != listener.version {
            // It proves nothing to a process of this build but that the other is none.
            self.recognised.insert((listener.incarnation, beat.incarnation));
            return;
        }
        let last = self.heard.entry((listener.incarnation, beat.incarnation)).or_insert((0, now));
        if beat.counter > last.0 {
            *last = (beat.counter, now);
        }
    }

    /// When `listener` last heard that `other` lives.
    pub fn last_heard(&self, listener: Incarnation, other: Incarnation) -> Option<MonotonicNs> {
        self.heard.get(&(listener, other)).map(|(_, at)| *at)
    }

    /// Whether `listener` knows `other` for a process of another build.
    pub fn is_recognised(&self, listener: Incarnation, other: Incarnation) -> bool {
        self.recognised.contains(&(listener, other))
    }
}
