//! The way that a robot has come, in a bounded number of points.

use contract::{Branch, Brief, Detail, Flight, Record};
use report::way;

use super::middle;
use super::point_cloud::Point;

/// Most points of a trail. A longer way is shown by every second of its points, and so on.
const POINTS_MAX: usize = 4096;

/// Points of one flight of a hop after its launch.
const FLIGHT_POINTS: u32 = 12;

/// Most points of a straight way from cell to cell.
const STRAIGHT_POINTS_MAX: f64 = 256.0;

/// Points of a stretch that a body rolled.
const ROLL_POINTS: u32 = 6;

/// What a point of the way shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ink {
    pub part: Part,
    /// Whether the decision did not end where it was aimed.
    pub strayed: bool,
}

/// A part of the way of a hop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Where the body flew, or a robot went otherwise.
    Flight,
    /// Where it rolled.
    Rolled,
    /// Where it hit the ground.
    Impact,
}

/// Points along the way of one robot.
#[derive(Clone, Debug)]
pub(super) struct Trail {
    points: Vec<(Point, Ink)>,
    /// Every so many of the points passed are kept.
    stride: u64,
    passed: u64,
}

impl Default for Trail {
    fn default() -> Self {
        Self { points: Vec::new(), stride: 1, passed: 0 }
    }
}

impl Trail {
    /// The points, each with what it shows.
    pub fn points(&self) -> &[(Point, Ink)] {
        &self.points
    }

    /// Adds the way of a decision.
    pub fn add(&mut self, brief: &Brief, record: &Record) {
        self.add_points(way_of(brief, record));
    }

    /// Adds the way of a hop as the motion model told it: its flights, where it hit and where it rolled.
    pub fn add_way(&mut self, record: &Record, detail: &Detail) {
        self.add_points(way_told(record, detail));
    }

    /// The first point is where the last way ended.
    fn add_points(&mut self, points: Vec<(Point, Ink)>) {
        let known = usize::from(self.passed > 0);
        points.into_iter().skip(known).for_each(|(point, ink)| self.push(point, ink));
    }

    fn push(&mut self, point: Point, ink: Ink) {
        if self.passed.is_multiple_of(self.stride) {
            if self.points.len() == POINTS_MAX {
                let mut is_kept = false;
                self.points.retain(|_| {
                    is_kept = !is_kept;
                    is_kept
                });
                self.stride = self.stride.saturating_mul(2);
            }
            self.points.push((point, ink));
        }
        self.passed = self.passed.saturating_add(1);
    }
}

/// The points of the way of a decision, from where it began to where it ended, as viewers draw it; none where the robot did not move.
#[must_use]
pub fn way(brief: &Brief, record: &Record, detail: Option<&Detail>) -> Vec<Point> {
    let points = match detail {
        Some(detail) => way_told(record, detail),
        None => way_of(brief, record),
    };
    points.into_iter().map(|(point, _)| point).collect()
}

/// The way of a decision by its outcome alone.
fn way_of(brief: &Brief, record: &Record) -> Vec<(Point, Ink)> {
    let outcome = &record.outcome;
    if outcome.from == outcome.to {
        return Vec::new();
    }
    let to = middle(brief, outcome.to, record.pose.height_m);
    let from = middle(brief, outcome.from, record.pose.height_m - outcome.flight.rise_m);
    let ink = Ink { part: Part::Flight, strayed: outcome.branch != Branch::Intended };
    let mut points = vec![(from, ink)];
    let flies = outcome.flight.apex_height_m > 0.0;
    if flies {
        let flights = outcome.flight.flights.clamp(1, 2);
        let along = |share: f64| between(from, to, share);
        for flight in 0..flights {
            let share = |n: u32| f64::from(n) / f64::from(flights);
            let arc = arc(along(share(flight)), along(share(flight + 1)), &outcome.flight);
            points.extend(arc.map(|point| (point, ink)));
        }
    } else {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let cells = (libm::hypot(dx, dy) / brief.grid.cell_size_m * 2.0).ceil();
        let count = cells.clamp(1.0, STRAIGHT_POINTS_MAX) as u32;
        points.extend((1..=count).map(|n| (between(from, to, f64::from(n) / f64::from(count)), ink)));
    }
    points
}

/// The way of a hop as the motion model told it.
fn way_told(record: &Record, detail: &Detail) -> Vec<(Point, Ink)> {
    let strayed = !matches!(record.outcome.branch, Branch::Intended | Branch::Held);
    let point = |[x, y, z]: [f64; 3]| Point { x, y, z };
    let mut points = Vec::new();
    for stretch in way::stretches(detail) {
        let flies = stretch.launch_mps.is_some();
        let (count, ink) = match flies {
            true => (FLIGHT_POINTS, Ink { part: Part::Flight, strayed }),
            false => (ROLL_POINTS, Ink { part: Part::Rolled, strayed }),
        };
        if points.is_empty() {
            points.push((point(stretch.from_m), ink));
        }
        for n in 1..=count {
            let ends_in_impact = n == count && !stretch.is_last;
            let ink = if ends_in_impact { Ink { part: Part::Impact, strayed } } else { ink };
            points.push((point(stretch.at(f64::from(n) / f64::from(count))), ink));
        }
    }
    points
}

/// The point at `share` of the straight way.
pub(super) fn between(from: Point, to: Point, share: f64) -> Point {
    let at = |from: f64, to: f64| from + (to - from) * share;
    Point { x: at(from.x, to.x), y: at(from.y, to.y), z: at(from.z, to.z) }
}

/// Points after the first on the parabola from launch to landing with the apex of the flight.
fn arc(from: Point, to: Point, flight: &Flight) -> impl Iterator<Item = Point> {
    let rise_m = to.z - from.z;
    let apex_m = flight.apex_height_m.max(rise_m).max(0.0);
    // z(s) = b s − (b − rise) s² over s in 0 to 1 has its apex b² / 4 (b − rise); solved for b.
    let b = 2.0 * (apex_m + (apex_m * (apex_m - rise_m)).max(0.0).sqrt());
    (1..=FLIGHT_POINTS).map(move |n| {
        let s = f64::from(n) / f64::from(FLIGHT_POINTS);
        Point { z: from.z + b * s - (b - rise_m) * s * s, ..between(from, to, s) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_goes_from_launch_to_landing_over_the_apex() {
        let from = Point { x: 0.5, y: 0.5, z: 1.0 };
        for (rise_m, apex_height_m) in [(0.0, 0.25), (0.3, 0.5), (-0.4, 0.1)] {
            let to = Point { x: 1.5, y: 0.5, z: 1.0 + rise_m };
            let points: Vec<_> = arc(from, to, &Flight { apex_height_m, ..Flight::default() }).collect();
            let end = points[points.len() - 1];
            assert!((end.z - to.z).abs() < 1e-12 && end.x == to.x, "{end:?}");
            let highest = points.iter().fold(f64::MIN, |most, point| most.max(point.z)) - from.z;
            assert!(highest <= apex_height_m + 1e-12 && highest > 0.8 * apex_height_m, "{highest}");
        }
    }

    #[test]
    fn a_long_way_is_thinned_out_from_its_first_point_to_its_last() {
        let mut trail = Trail::default();
        let count = 10 * POINTS_MAX as u32;
        for n in 0..count {
            trail.push(
                Point { x: f64::from(n), ..Point::default() },
                Ink { part: Part::Flight, strayed: false },
            );
        }
        let xs: Vec<f64> = trail.points().iter().map(|(point, _)| point.x).collect();
        assert!(xs.len() <= POINTS_MAX && xs.len() > POINTS_MAX / 4, "{}", xs.len());
        assert_eq!(xs[0], 0.0);
        assert!(xs[xs.len() - 1] > f64::from(count) - 20.0);
        assert!(xs.windows(2).all(|pair| (pair[1] - pair[0] - (xs[1] - xs[0])).abs() < 1e-9), "evenly");
    }
}
