//! The naive helicopter: along the rover's announced route.

use helicopter::within_budget;
use rover::Point;

use crate::Route;

/// The flight along `route` as far as the budget reaches; the helicopter starts where the rover stands.
#[must_use]
pub fn scout_route(route: &Route, budget_m: f64) -> Vec<Point> {
    within_budget(&route.points, budget_m)
}
