//! What a rover is asked for, and what a planner answers.

use rover::{CostMap, Point, Segment};

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

    /// Where a segment enters the disc; none if it begins within it, or passes it by.
    fn entry(self, segment: Segment) -> Option<Point> {
        let Segment { from, to } = segment;
        let length_m = from.distance_m(to);
        if self.distance_m(from) == 0.0 || length_m == 0.0 {
            return None;
        }
        let direction = segment.direction();
        let (dx_m, dy_m) = (self.at.x_m - from.x_m, self.at.y_m - from.y_m);
        let ahead_m = dx_m * direction.x_m + dy_m * direction.y_m;
        let aside_m = dx_m * direction.y_m - dy_m * direction.x_m;
        let half_chord_m = (self.radius_m * self.radius_m - aside_m * aside_m).sqrt();
        // Not a number if the line misses the disc.
        let entry_m = ahead_m - half_chord_m;
        (0.0..length_m).contains(&entry_m).then(|| from.towards(to, entry_m / length_m))
    }

    /// Ends a way where it first enters the disc.
    pub(crate) fn cut(self, points: &mut Vec<Point>) {
        let entries = Segment::along(points).map(|segment| self.entry(segment));
        let first = entries.enumerate().find_map(|(leg, entry)| entry.map(|entry| (leg, entry)));
        if let Some((leg, entry)) = first {
            points.truncate(leg + 1);
            points.push(entry);
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_is_cut_where_it_first_enters_the_goal() {
        let goal = Goal { at: Point::new(10.0, 0.0), radius_m: 3.0 };
        let cut = |points: &[(f64, f64)]| {
            let mut points = points.iter().map(|(x_m, y_m)| Point::new(*x_m, *y_m)).collect();
            goal.cut(&mut points);
            points
        };
        assert_eq!(cut(&[(0.0, 0.0), (5.0, 0.0), (10.0, 0.0)]), cut(&[(0.0, 0.0), (5.0, 0.0), (7.0, 0.0)]));
        assert_eq!(*cut(&[(0.0, 0.0), (20.0, 0.0), (9.0, 0.0)]).last().unwrap(), Point::new(7.0, 0.0));
        let aslant = *cut(&[(0.0, 1.8), (9.0, 1.8), (10.0, 0.0)]).last().unwrap();
        assert!(aslant.distance_m(Point::new(7.6, 1.8)) < 1e-12, "{aslant:?}");
        let kept = [(0.0, 0.0), (0.0, 9.0), (20.0, 9.0)];
        assert_eq!(cut(&kept).len(), 3, "it passes the goal by");
        assert_eq!(cut(&[(9.0, 0.0), (11.0, 0.0)]).len(), 2, "it begins within the goal");
    }
}
