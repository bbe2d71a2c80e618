//! The routes that planners have published and decisions have announced, by code that shares nothing with the product's.

use std::collections::BTreeMap;

use contract::{Announcement, Record, RobotId, RouteId, RunId, Waypoint};
use xxhash_rust::xxh3::xxh3_64;

/// The fingerprint that a route of these points has.
pub(crate) fn fingerprint(points: &[Waypoint]) -> RouteId {
    let bytes: Vec<u8> = points
        .iter()
        .flat_map(|point| [point.x_m, point.y_m])
        .flat_map(|metres| metres.to_bits().to_le_bytes())
        .collect();
    RouteId(xxh3_64(&bytes).max(1))
}

/// The routes of a run.
#[derive(Clone, Debug)]
pub(crate) struct Routes {
    run: RunId,
    /// Published by planners in any run, executed or not.
    published: BTreeMap<(RunId, RobotId, RouteId), Vec<Waypoint>>,
    /// Announced by decisions, in their order.
    announced: Vec<(RouteId, Vec<Waypoint>)>,
}

impl Routes {
    /// No route.
    pub fn none(run: RunId) -> Self {
        Self { run, published: BTreeMap::new(), announced: Vec::new() }
    }

    /// Those of another run, or of this one begun again: what planners have published stays.
    pub fn anew(&self, run: RunId) -> Self {
        Self { published: self.published.clone(), ..Self::none(run) }
    }

    /// A planner publishes the points of a route.
    pub fn publish(&mut self, announcement: &Announcement) {
        let Announcement { run, robot, route } = announcement;
        let points = route.waypoints().to_vec();
        self.published.insert((*run, *robot, fingerprint(&points)), points);
    }

    /// A record was committed, which may announce a route.
    pub fn committed(&mut self, record: &Record) {
        if let contract::Action::Announce(id) = record.action
            && let Some(points) = self.points(record.robot, id).map(<[Waypoint]>::to_vec)
        {
            self.announced.push((id, points));
        }
    }

    /// Those that decisions have announced, in their order.
    pub fn announced(&self) -> &[(RouteId, Vec<Waypoint>)] {
        &self.announced
    }

    /// The points of a route that some decision has announced.
    pub fn route(&self, id: RouteId) -> Option<&[Waypoint]> {
        self.announced.iter().find(|(known, _)| *known == id).map(|(_, points)| points.as_slice())
    }

    /// Whether some planner has published that route in the run.
    pub fn is_published(&self, run: RunId, id: RouteId) -> bool {
        self.published.keys().any(|(of, _, known)| (*of, *known) == (run, id))
    }

    /// The points of a route that a robot may announce: published for it, or announced before.
    pub fn points(&self, robot: RobotId, id: RouteId) -> Option<&[Waypoint]> {
        let published = self.published.get(&(self.run, robot, id)).map(Vec::as_slice);
        published.or_else(|| self.route(id))
    }
}
