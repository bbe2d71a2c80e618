//! The routes that robots announced, and which of them are still to be asked for.

use std::collections::{BTreeMap, BTreeSet};

use contract::{
    Action, Announcement, Decision, MonotonicNs, PageCursor, Record, RobotId, Route, RouteId, RoutePage,
    RouteRequest, RunId, Team,
};

/// The announced routes of one run.
#[derive(Debug, Default)]
pub(crate) struct AnnouncedRoutes {
    /// The routes whose points are written.
    written: BTreeSet<(RobotId, RouteId)>,
    /// By the decision that announced them; their points have not come.
    wanted: BTreeMap<Decision, (RobotId, RouteId)>,
    /// The last route of each robot.
    last: BTreeMap<RobotId, (Decision, RouteId)>,
    /// When the first of `wanted` was asked for: one route is item 0 of a list of one.
    cursor: PageCursor,
}

impl AnnouncedRoutes {
    /// Notes the routes that the robots follow.
    pub fn team(&mut self, team: &Team) {
        for (robot, member) in (0..).map(RobotId).zip(team.members.iter()) {
            let travel = member.travel.as_ref();
            if let Some((decision, id)) = travel.and_then(|travel| travel.announced.zip(travel.route)) {
                self.want(decision, robot, id);
            }
        }
    }

    /// Notes the route that an executed decision announced.
    pub fn record(&mut self, record: &Record) {
        if let Action::Announce(id) = record.action {
            self.want(record.decision, record.robot, id);
        }
    }

    fn want(&mut self, decision: Decision, robot: RobotId, id: RouteId) {
        let last = self.last.entry(robot).or_insert((decision, id));
        *last = (*last).max((decision, id));
        if !self.written.contains(&(robot, id)) {
            self.wanted.insert(decision, (robot, id));
        }
    }

    /// Notes that the points of a route are written.
    pub fn wrote(&mut self, robot: RobotId, route: &Route) {
        let written = (robot, route.id());
        self.written.insert(written);
        self.wanted.retain(|_, wanted| *wanted != written);
    }

    /// What the robots that wait for the route of `page` announced.
    pub fn page(&mut self, page: &RoutePage) -> Vec<Announcement> {
        let id = page.route.id();
        let waiting: BTreeSet<RobotId> =
            self.wanted.values().filter(|(_, wanted)| *wanted == id).map(|(robot, _)| *robot).collect();
        if !waiting.is_empty() {
            self.cursor = PageCursor::default();
        }
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
        !self.wanted.is_empty()
    }

    /// Wants no route until it is named again, since the journal may have lost those decisions.
    pub fn forget_wanted(&mut self) {
        self.wanted.clear();
        self.last.clear();
    }

    /// What to ask for at `now`: the first route whose points are missing, and again if it does not come.
    pub fn ask(&mut self, run: RunId, now: MonotonicNs) -> Option<RouteRequest> {
        let (_, (_, id)) = self.wanted.first_key_value()?;
        self.cursor.ask(now)?;
        Some(RouteRequest { run, id: *id })
    }
}
