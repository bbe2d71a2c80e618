//! Routes that robots announce: through which points they will go.
//!
//! A route is known by its content: a command, a record and [`crate::Travel`] name its [`RouteId`], and whoever needs
//! the points asks for them ([`RouteRequest`]). So a route that was read once never has to be read again.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;

use crate::limits::{LEG_MAX_M, ROUTE_POINTS_MAX};
use crate::{Refusal, RobotId, RouteId, RunId, Waypoint};

/// Where a robot will go, straight from point to point; the first is where it stands when it announces the route.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Route {
    waypoints: Vec<Waypoint>,
}

impl Route {
    /// The route through `waypoints`.
    ///
    /// # Errors
    /// If there is none or more than [`ROUTE_POINTS_MAX`], one is no number, or two that follow each other are more than
    /// [`LEG_MAX_M`] apart.
    pub fn new(waypoints: Vec<Waypoint>) -> Result<Self, Refusal> {
        if !(1..=ROUTE_POINTS_MAX).contains(&waypoints.len()) {
            let need = format!("1 to {ROUTE_POINTS_MAX}");
            return Err(Refusal::malformed("route.waypoints", &need, waypoints.len()));
        }
        if let Some(point) = waypoints.iter().find(|point| !(point.x_m.is_finite() && point.y_m.is_finite()))
        {
            return Err(Refusal::malformed("route.waypoints", "finite metres", point));
        }
        let legs_m = waypoints.windows(2).map(|leg| leg[0].distance_m(leg[1]));
        if let Some(leg_m) = legs_m.into_iter().find(|leg_m| *leg_m > LEG_MAX_M) {
            return Err(Refusal::malformed("route.leg_m", &format!("at most {LEG_MAX_M}"), leg_m));
        }
        Ok(Self { waypoints })
    }

    /// 1 to [`ROUTE_POINTS_MAX`] points.
    #[must_use]
    pub fn waypoints(&self) -> &[Waypoint] {
        &self.waypoints
    }

    /// The fingerprint of the points.
    #[must_use]
    pub fn id(&self) -> RouteId {
        let mut bytes = Vec::with_capacity(16 * self.waypoints.len());
        for point in &self.waypoints {
            bytes.extend(point.x_m.to_bits().to_le_bytes());
            bytes.extend(point.y_m.to_bits().to_le_bytes());
        }
        RouteId(xxh3_64(&bytes).max(1))
    }

    /// Length in the plane, metres.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.waypoints.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum()
    }
}

/// What a planner tells hopper-sim before it commands [`crate::Action::Announce`]. It is sent again with the command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Announcement {
    /// The run it is meant for.
    pub run: RunId,
    /// The robot whose route it is.
    pub robot: RobotId,
    /// Where it will go.
    pub route: Route,
}

/// Asks hopper-sim for the points of a route that was announced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RouteRequest {
    /// The run in which it was announced.
    pub run: RunId,
    /// Fingerprint of the route asked for.
    pub id: RouteId,
}

/// The points of a route.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoutePage {
    /// The run in which it was announced.
    pub run: RunId,
    /// The route; its fingerprint is the one that was asked for.
    pub route: Route,
}

/// Routes that are known, by their fingerprints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Routes(BTreeMap<RouteId, Route>);

impl Routes {
    /// The route with that fingerprint, if it is known.
    #[must_use]
    pub fn get(&self, id: RouteId) -> Option<&Route> {
        self.0.get(&id)
    }

    /// All that are known, in the order of their fingerprints.
    pub fn iter(&self) -> impl Iterator<Item = &Route> {
        self.0.values()
    }

    /// Adds a route.
    pub fn insert(&mut self, route: Route) {
        self.0.insert(route.id(), route);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn route(points: usize) -> Result<Route, Refusal> {
        Route::new((0..points).map(|x| Waypoint { x_m: x as f64, y_m: 0.5 }).collect())
    }

    /// P-ROUTE-POINTS: A route has 1 to 256 points; any other number is refused by name.
    #[test]
    fn a_route_has_one_to_256_points_not_too_far_apart() {
        assert!(route(1).is_ok() && route(ROUTE_POINTS_MAX).is_ok());
        assert_eq!(route(ROUTE_POINTS_MAX).unwrap().length_m(), 255.0);
        for (points, got) in [(0, "got 0"), (257, "needs 1 to 256, got 257")] {
            let refusal = route(points).unwrap_err().to_string();
            assert!(refusal.contains(got), "{refusal}");
        }
        let point = |x_m| Waypoint { x_m, y_m: 0.0 };
        assert!(Route::new(vec![point(f64::NAN)]).is_err());
        assert!(Route::new(vec![point(0.0), point(LEG_MAX_M + 1.0)]).is_err());
    }

    #[test]
    fn a_fingerprint_is_that_of_the_points_in_order() {
        let (a, b) = (Waypoint { x_m: 1.0, y_m: 2.0 }, Waypoint { x_m: 2.0, y_m: 1.0 });
        let id = |points: &[Waypoint]| Route::new(points.to_vec()).unwrap().id();
        assert_eq!(id(&[a, b]), id(&[a, b]));
        assert_ne!(id(&[a, b]), id(&[b, a]));
        assert_ne!(id(&[a]), id(&[a, a]));
    }
}
