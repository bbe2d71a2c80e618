//! What the world remembers of messages about routes, to tell rare events apart.

use std::collections::{BTreeMap, BTreeSet};

use contract::{Announcement, Incarnation, RouteId, RunId};

use crate::life::Life;

/// What is remembered of messages about routes.
#[derive(Debug, Default)]
pub(crate) struct RouteMemory {
    /// Routes whose points a life of hopper-sim has received.
    pub received: BTreeSet<(Incarnation, RunId, RouteId)>,
    /// Which life in a slot was the first to ask for a route.
    pub askers: BTreeMap<(usize, RunId, RouteId), Incarnation>,
    /// Which life of hopper-sim has sent a planner the first page of the prior that it took last.
    pub priors: BTreeMap<Incarnation, (RunId, Incarnation)>,
}

impl RouteMemory {
    /// hopper-sim receives the points of a route.
    pub fn heard(&mut self, life: &Life, announcement: &Announcement) {
        self.received.insert((life.incarnation, announcement.run, announcement.route.id()));
    }
}
