//! Routes made cheaper by straight lines.

use rover::{CostMap, Point, Segment};

use crate::KeptClear;
use crate::stream::Stream;

/// Tries `count` times to replace the way between two random points of a route by a straight line, and keeps what is cheaper.
pub fn random_shortcuts(costs: &CostMap, points: &mut Vec<Point>, count: usize, random: &mut Stream) {
    for _ in 0..count {
        let length_m: f64 = points.windows(2).map(|pair| pair[0].distance_m(pair[1])).sum();
        let (a, b) = (random.uniform() * length_m, random.uniform() * length_m);
        let (leg_a, from) = along(points, a.min(b));
        let (leg_b, to) = along(points, a.max(b));
        if leg_a == leg_b {
            continue;
        }
        let mut way = vec![from];
        way.extend_from_slice(&points[leg_a + 1..=leg_b]);
        way.push(to);
        if costs.within(Segment { from, to }, costs.way(&way)) < costs.way(&way) {
            points.splice(leg_a + 1..=leg_b, [from, to]);
        }
    }
}

/// The leg and the point at a distance along the way.
fn along(points: &[Point], distance_m: f64) -> (usize, Point) {
    let mut left_m = distance_m;
    for (leg, pair) in points.windows(2).enumerate() {
        let leg_m = pair[0].distance_m(pair[1]);
        if left_m <= leg_m && leg_m > 0.0 {
            return (leg, pair[0].towards(pair[1], left_m / leg_m));
        }
        left_m -= leg_m;
    }
    (points.len().saturating_sub(2), points[points.len() - 1])
}

/// How many waypoints a straight line may skip at once; what is left is pulled again.
const SKIPPED_MAX: usize = 48;

/// Steps by which waypoints are moved, in metres.
const STEPS_M: [f64; 6] = [2.0, 1.0, 0.5, 0.25, 0.1, 0.05];

/// Makes a route cheaper until neither leaving out waypoints nor moving them helps much. Its ends stay.
///
/// Never dearer than before: every change is measured by the exact integral.
pub fn pull_tight(ways: &KeptClear<'_>, points: &mut Vec<Point>) {
    straighten(points);
    loop {
        let before = points.len();
        skip(ways, points);
        if points.len() == before {
            break;
        }
    }
    for _ in 0..3 {
        let before = ways.way(points);
        for step_m in STEPS_M {
            move_points(ways, points, step_m);
        }
        skip(ways, points);
        if ways.way(points) > before * (1.0 - 1e-5) {
            break;
        }
    }
}

/// Leaves out waypoints on straight lines.
fn straighten(points: &mut Vec<Point>) {
    let mut kept: Vec<Point> = Vec::with_capacity(points.len());
    for at in 0..points.len() {
        if let (Some(before), Some(after)) = (kept.last(), points.get(at + 1)) {
            let here = points[at];
            let cross = (here.x_m - before.x_m) * (after.y_m - here.y_m)
                - (here.y_m - before.y_m) * (after.x_m - here.x_m);
            let ahead = (here.x_m - before.x_m) * (after.x_m - here.x_m)
                + (here.y_m - before.y_m) * (after.y_m - here.y_m);
            if cross.abs() < 1e-9 && ahead > 0.0 {
                continue;
            }
        }
        kept.push(points[at]);
    }
    *points = kept;
}

/// The cheapest way along some of the waypoints, in their order.
fn skip(ways: &KeptClear<'_>, points: &mut Vec<Point>) {
    let mut best = vec![(0.0, 0); points.len()];
    for to in 1..points.len() {
        let mut found = (f64::INFINITY, to - 1);
        for from in (to.saturating_sub(SKIPPED_MAX)..to).rev() {
            let so_far: f64 = best[from].0;
            let bound = so_far + points[from].distance_m(points[to]) * ways.costs().least();
            if bound < found.0 {
                let segment = Segment { from: points[from], to: points[to] };
                let cost = so_far + ways.within(segment, found.0.min(f64::MAX) - so_far);
                // Of equal ones the longest leg.
                if cost <= found.0 {
                    found = (cost, from);
                }
            }
        }
        best[to] = found;
    }
    let mut kept = vec![points.len() - 1];
    while let Some(last) = kept.last().copied().filter(|last| *last > 0) {
        kept.push(best[last].1);
    }
    *points = kept.into_iter().rev().map(|at| points[at]).collect();
}

/// Moves each inner waypoint a step in the best of eight directions, as long as that is cheaper.
fn move_points(ways: &KeptClear<'_>, points: &mut [Point], step_m: f64) {
    const DIRECTIONS: [(f64, f64); 8] = [
        (1.0, 0.0),
        (1.0, 1.0),
        (0.0, 1.0),
        (-1.0, 1.0),
        (-1.0, 0.0),
        (-1.0, -1.0),
        (0.0, -1.0),
        (1.0, -1.0),
    ];
    for at in 1..points.len().saturating_sub(1) {
        let (before, after) = (points[at - 1], points[at + 1]);
        let mut cost = ways.way(&points[at - 1..=at + 1]);
        let moves_max = 8;
        for _ in 0..moves_max {
            let here = points[at];
            for (dx, dy) in DIRECTIONS {
                let there = Point::new(here.x_m + dx * step_m, here.y_m + dy * step_m);
                let bound = (before.distance_m(there) + there.distance_m(after)) * ways.costs().least();
                if bound >= cost || !ways.costs().lattice().contains(there) {
                    continue;
                }
                let first = ways.within(Segment { from: before, to: there }, cost);
                let whole = first + ways.within(Segment { from: there, to: after }, cost - first);
                if whole < cost {
                    cost = whole;
                    points[at] = there;
                }
            }
            if points[at] == here {
                break;
            }
        }
    }
}
