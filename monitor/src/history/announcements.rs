//! The routes that robots announced, in the order in which their points became known.

use std::collections::VecDeque;

use contract::{
    Decision, MonotonicNs, Record, RobotId, Route, RouteId, RoutePage, RouteRequest, RunId, Team,
};
use follow::MissingRoutes;

/// Number of routes that are kept, the last ones.
const ROUTES_KEPT: usize = 1024;

/// A route, and the decision that announced it.
#[derive(Clone, Debug, PartialEq)]
pub struct Announced {
    /// The decision by which it was announced.
    pub decision: Decision,
    /// The robot that follows the route.
    pub robot: RobotId,
    /// Its points.
    pub route: Route,
}

/// The routes of a run.
#[derive(Debug, Default)]
pub struct Announcements {
    /// Announced, their points still unknown.
    missing: MissingRoutes<(Decision, RobotId)>,
    known: VecDeque<Announced>,
    /// Number of routes that are no longer kept.
    dropped: u64,
}

impl Announcements {
    /// Number of routes known so far.
    pub(super) fn count(&self) -> u64 {
        self.dropped + self.known.len() as u64
    }

    /// The route of that number of the run; the first one kept if it is older.
    pub(super) fn from(&self, number: u64) -> impl Iterator<Item = &Announced> {
        self.known.iter().skip(number.saturating_sub(self.dropped) as usize)
    }

    /// The route that `robot` followed when decision `at` was due, if its points are known.
    #[must_use]
    pub fn of(&self, robot: RobotId, at: Decision) -> Option<&Announced> {
        let own = self.known.iter().filter(|known| known.robot == robot && known.decision < at);
        own.max_by_key(|known| known.decision)
    }

    /// Whether the points of a route are unknown.
    pub(super) fn lacks_points(&self) -> bool {
        !self.missing.is_empty()
    }

    /// Notes what routes the robots follow.
    pub(super) fn team(&mut self, team: &Team) {
        team.announced().for_each(|(by, route)| self.need(by, route));
    }

    /// Notes what an executed decision announced.
    pub(super) fn record(&mut self, record: &Record) {
        record.announced().into_iter().for_each(|(by, route)| self.need(by, route));
    }

    fn need(&mut self, by: (Decision, RobotId), route: RouteId) {
        if !self.known.iter().rev().any(|known| known.decision == by.0) {
            self.missing.need(by, route);
        }
    }

    /// Adds the points of a route.
    pub(super) fn page(&mut self, page: &RoutePage) {
        for (decision, robot) in self.missing.found(page.route.id()) {
            if self.known.len() == ROUTES_KEPT {
                self.known.pop_front();
                self.dropped += 1;
            }
            self.known.push_back(Announced { decision, robot, route: page.route.clone() });
        }
    }

    /// What to ask for at `now`: the first route whose points are unknown, and again if it does not come.
    pub(super) fn ask(&mut self, run: RunId, now: MonotonicNs) -> Option<RouteRequest> {
        self.missing.ask(run, now)
    }
}
