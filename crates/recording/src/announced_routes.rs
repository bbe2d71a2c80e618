//! The routes that robots announced, and which of them are still to be asked for.

use std::collections::{BTreeMap, BTreeSet};

use contract::{
    Announcement, Decision, MonotonicNs, Record, RobotId, Route, RouteId, RoutePage, RouteRequest, RunId,
    Team,
};
use follow::MissingRoutes;

/// The announced routes of one run.
#[derive(Debug, Default)]
pub(crate) struct AnnouncedRoutes {
    /// The routes whose points are written.
    written: BTreeSet<(RobotId, RouteId)>,
    /// By the decision that announced them; their points have not come.
    missing: MissingRoutes<(Decision, RobotId)>,
    /// The last route of each robot.
    last: BTreeMap<RobotId, (Decision, RouteId)>,
}

impl AnnouncedRoutes {
    /// Notes the routes that the robots follow.
    pub fn team(&mut self, team: &Team) {
        team.announced().for_each(|(by, route)| self.need(by, route));
    }

    /// Notes the route that an executed decision announced.
    pub fn record(&mut self, record: &Record) {
        record.announced().into_iter().for_each(|(by, route)| self.need(by, route));
    }

    fn need(&mut self, (decision, robot): (Decision, RobotId), id: RouteId) {
        let last = self.last.entry(robot).or_insert((decision, id));
        *last = (*last).max((decision, id));
        if !self.written.contains(&(robot, id)) {
            self.missing.need((decision, robot), id);
        }
    }

    /// Notes that the points of a route are written.
    pub fn wrote(&mut self, robot: RobotId, route: &Route) {
        let id = route.id();
        self.written.insert((robot, id));
        self.missing.found_by(id, |(_, waiting)| *waiting == robot);
    }

    /// What the robots that wait for the route of `page` announced.
    pub fn page(&mut self, page: &RoutePage) -> Vec<Announcement> {
        let waiting = self.missing.found(page.route.id()).into_iter().map(|(_, robot)| robot);
        let waiting: BTreeSet<RobotId> = waiting.collect();
        let announcement = |robot| Announcement { run: page.run, robot, route: page.route.clone() };
        waiting.into_iter().map(announcement).collect()
    }

    /// Number of routes whose points are written.
    pub fn written(&self) -> usize {
        self.written.len()
    }

    /// Whether no later route of that robot is known.
    pub fn is_last(&self, robot: RobotId, route: &Route) -> bool {
        self.last.get(&robot).is_none_or(|(_, id)| *id == route.id())
    }

    /// Whether the points of a route are missing.
    pub fn lacks_points(&self) -> bool {
        !self.missing.is_empty()
    }

    /// Needs no route until it is named again, since the journal may have lost those decisions.
    pub fn forget_missing(&mut self) {
        self.missing.clear();
        self.last.clear();
    }

    /// What to ask for at `now`: the first route whose points are missing, and again if it does not come.
    pub fn ask(&mut self, run: RunId, now: MonotonicNs) -> Option<RouteRequest> {
        self.missing.ask(run, now)
    }
}
