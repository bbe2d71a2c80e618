//! What a rover is asked for, and what a planner answers.

use rover::{CostMap, Point};

/// Where a trip ends: anywhere within a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Its middle.
    pub at: Point,
    /// Its radius; 0 for the point alone.
    pub radius_m: f64,
}

impl Goal {
    /// Distance from `point` to the disc; 0 within it.
    #[must_use]
    pub fn distance_m(self, point: Point) -> f64 {
        (point.distance_m(self.at) - self.radius_m).max(0.0)
    }

    /// The point of the disc that is nearest to `point`.
    #[must_use]
    pub fn nearest(self, point: Point) -> Point {
        let away_m = point.distance_m(self.at);
        if away_m <= self.radius_m { point } else { self.at.towards(point, self.radius_m / away_m) }
    }
}

/// A trip of the rover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trip {
    /// Where the rover stands.
    pub start: Point,
    /// Where it is to go.
    pub goal: Goal,
}

/// A way through waypoints, straight between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// From start to end, at least one.
    pub points: Vec<Point>,
    /// What it costs on the map that it was planned on: expected Sol, or metres for the naive planner.
    pub cost: f64,
}

impl Route {
    /// The way through `points` with its cost on `costs`.
    #[must_use]
    pub fn new(costs: &CostMap, points: Vec<Point>) -> Self {
        Self { cost: costs.way(&points), points }
    }

    /// Length in the plane.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.points.windows(2).map(|pair| pair[0].distance_m(pair[1])).sum()
    }
}
