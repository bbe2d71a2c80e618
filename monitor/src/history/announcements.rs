//! The routes that robots announced, in the order in which their points became known.

use std::collections::{BTreeMap, VecDeque};

use contract::{
    Action, Decision, MonotonicNs, PageCursor, Record, RobotId, Route, RouteId, RoutePage, RouteRequest,
    RunId, Team,
};

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
    wanted: BTreeMap<Decision, (RobotId, RouteId)>,
    /// When the first of `wanted` was asked for: one route is item 0 of a list of one.
    cursor: PageCursor,
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
        !self.wanted.is_empty()
    }

    /// Notes what routes the robots follow.
    pub(super) fn team(&mut self, team: &Team) {
        for (robot, member) in (0..).map(RobotId).zip(team.members.iter()) {
            let travel = member.travel.as_ref();
            if let Some((decision, id)) = travel.and_then(|travel| travel.announced.zip(travel.route)) {
                self.want(decision, robot, id);
            }
        }
    }

    /// Notes what an executed decision announced.
    pub(super) fn record(&mut self, record: &Record) {
        if let Action::Announce(id) = record.action {
            self.want(record.decision, record.robot, id);
        }
    }

    fn want(&mut self, decision: Decision, robot: RobotId, id: RouteId) {
        if !self.known.iter().rev().any(|known| known.decision == decision) {
            self.wanted.entry(decision).or_insert((robot, id));
        }
    }

    /// Adds the points of a route.
    pub(super) fn page(&mut self, page: &RoutePage) {
        let id = page.route.id();
        let decisions = self.wanted.iter().filter(|(_, (_, wanted))| *wanted == id);
        for decision in decisions.map(|(decision, _)| *decision).collect::<Vec<_>>() {
            let Some((robot, _)) = self.wanted.remove(&decision) else { continue };
            if self.known.len() == ROUTES_KEPT {
                self.known.pop_front();
                self.dropped += 1;
            }
            self.known.push_back(Announced { decision, robot, route: page.route.clone() });
            self.cursor = PageCursor::default();
        }
    }

    /// What to ask for at `now`: the first route whose points are unknown, and again if it does not come.
    pub(super) fn ask(&mut self, run: RunId, now: MonotonicNs) -> Option<RouteRequest> {
        let (_, (_, id)) = self.wanted.first_key_value()?;
        self.cursor.ask(now)?;
        Some(RouteRequest { run, id: *id })
    }
}
