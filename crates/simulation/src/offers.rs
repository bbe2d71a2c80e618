//! Routes whose points one life of hopper-sim has received and that no decision has announced yet.

use std::collections::{BTreeMap, VecDeque};

use contract::{RobotId, RouteId};

/// Routes kept for each robot: those that came last.
const OFFERS_MAX: usize = 4;

/// The routes that planners have proposed for each robot, the last first.
#[derive(Clone, Debug, Default)]
pub(crate) struct Offers(BTreeMap<RobotId, VecDeque<RouteId>>);

impl Offers {
    /// The points of a route have come.
    pub fn received(&mut self, robot: RobotId, id: RouteId) {
        let offers = self.0.entry(robot).or_default();
        if !offers.contains(&id) {
            offers.truncate(OFFERS_MAX - 1);
            offers.push_front(id);
        }
    }

    /// Whether the points of that route are kept for a robot.
    pub fn has(&self, robot: RobotId, id: RouteId) -> bool {
        self.0.get(&robot).is_some_and(|offers| offers.contains(&id))
    }

    /// A robot has announced a route.
    pub fn announced(&mut self, robot: RobotId) {
        self.0.remove(&robot);
    }
}
