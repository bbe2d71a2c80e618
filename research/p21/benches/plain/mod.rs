//! Plain implementations of the planners, as one writes them down first: no buckets, no bounds, no sums kept.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use helicopter::BUDGET_M;
use routing::{Route, RrtStar, RrtStarIt, Stream, Trip, random_shortcuts};
use rover::{Belief, CostMap, Lattice, Point, Segment};

/// Numbers of all points with their distance, nearest first.
fn ranked(points: &[Point], from: Point) -> Vec<(f64, usize)> {
    let mut ranked: Vec<_> =
        points.iter().enumerate().map(|(number, at)| (from.distance_m(*at), number)).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked
}

/// RRT*-ETT with the parameters and samples of `rrt_star_ett`.
pub fn rrt_star_ett(costs: &CostMap, trip: &Trip, iterations: usize, seed: u64) -> Option<Route> {
    let mut samples = Stream::new(seed, "rrt_star");
    let lattice = costs.lattice();
    let (width_m, height_m) = (lattice.width() as f64, lattice.height() as f64);
    let (mut at, mut cost, mut parent) = (vec![trip.start], vec![0.0], vec![0]);
    let mut arrived = Vec::new();
    for iteration in 0..iterations * RrtStar::PATIENCE {
        if iteration >= iterations && !arrived.is_empty() {
            break;
        }
        let sample = if samples.uniform() < RrtStar::GOAL_BIAS {
            trip.goal.at
        } else {
            Point::new(samples.uniform() * width_m, samples.uniform() * height_m)
        };
        let near_m = |nodes: f64| {
            (0.7 * (width_m * height_m).sqrt() * (nodes.ln() / nodes).sqrt()).min(RrtStar::NEAR_MAX_M)
        };
        let near_m = near_m(at.len() as f64);
        let nearest = ranked(&at, sample).into_iter().take(RrtStar::NEAREST);
        let nearest = nearest.map(|(_, node)| (costs.segment(Segment { from: at[node], to: sample }), node));
        let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |nearest| nearest.1);
        let to = costs.reach(Segment { from: at[nearest], to: sample }, RrtStar::EDGE_MAX_SOL);
        if at[nearest].distance_m(to) < 1e-6 {
            continue;
        }
        let near: Vec<usize> = (0..at.len()).filter(|node| at[*node].distance_m(to) <= near_m).collect();
        let through = |node: &usize| (cost[*node] + costs.segment(Segment { from: at[*node], to }), *node);
        let best = near.iter().chain([&nearest]).map(through).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((best, through)) = best.filter(|best| best.0 < f64::INFINITY) else { continue };
        let node = at.len();
        at.push(to);
        cost.push(best);
        parent.push(through);
        for other in near {
            let rewired = best + costs.segment(Segment { from: to, to: at[other] });
            if rewired < cost[other] {
                let saved = cost[other] - rewired;
                parent[other] = node;
                // All below it: those whose way to the root leads through it.
                #[allow(clippy::needless_range_loop, reason = "an index into several lists")]
                for below in 0..at.len() {
                    let mut ancestor = below;
                    while ancestor != 0 && ancestor != other {
                        ancestor = parent[ancestor];
                    }
                    if ancestor == other {
                        cost[below] -= saved;
                    }
                }
            }
        }
        if trip.goal.distance_m(to) == 0.0 {
            arrived.push(node);
        }
    }
    let mut node = arrived.into_iter().min_by(|a, b| cost[*a].total_cmp(&cost[*b]))?;
    let mut points = vec![at[node]];
    while node != 0 {
        node = parent[node];
        points.push(at[node]);
    }
    points.reverse();
    random_shortcuts(costs, &mut points, RrtStar::SHORTCUTS, &mut Stream::new(seed, "shortcuts"));
    Some(Route::new(costs, points))
}

/// The sum of the spread over the cells that a flight shows, looked up cell by cell.
fn seen(lattice: Lattice, sd: &[f64], flight: &[Point], view_m: f64) -> f64 {
    let mut shown = vec![false; lattice.cells()];
    let mut sum = 0.0;
    let hovering = [flight[0], flight[0]];
    let legs = if flight.len() == 1 { hovering.windows(2) } else { flight.windows(2) };
    for leg in legs {
        let (from, to) = (leg[0], leg[1]);
        let (dx, dy) = (to.x_m - from.x_m, to.y_m - from.y_m);
        let rows = (from.y_m.min(to.y_m) - view_m) as usize
            ..((from.y_m.max(to.y_m) + view_m + 1.0) as usize).min(lattice.height());
        let columns = (from.x_m.min(to.x_m) - view_m) as usize
            ..((from.x_m.max(to.x_m) + view_m + 1.0) as usize).min(lattice.width());
        for cell in rows.flat_map(|row| columns.clone().map(move |column| row * lattice.width() + column)) {
            let at = lattice.centre(cell);
            let along = (at.x_m - from.x_m) * dx + (at.y_m - from.y_m) * dy;
            let share = if dx == 0.0 && dy == 0.0 { 0.0 } else { along / (dx * dx + dy * dy) };
            if !shown[cell] && at.distance_m(from.towards(to, share.clamp(0.0, 1.0))) <= view_m {
                shown[cell] = true;
                sum += sd[cell];
            }
        }
    }
    sum
}

/// RRT*-IT with the parameters and samples of `rrt_star_it`.
pub fn rrt_star_it(belief: &Belief, start: Point, iterations: usize, view_m: f64, seed: u64) -> Vec<Point> {
    let lattice = belief.surface().lattice();
    let sd: Vec<f64> = belief.cells().iter().map(|cell| cell.sd_m_per_sol()).collect();
    let total: f64 = sd.iter().sum();
    if total == 0.0 {
        return vec![start];
    }
    let side_m = (lattice.cells() as f64).sqrt();
    let mut samples = Stream::new(seed, "rrt_star_it");
    let utility = |flight: &[Point]| {
        let length_m: f64 = flight.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum();
        let worth =
            RrtStarIt::LENGTH_WEIGHT * length_m / BUDGET_M - seen(lattice, &sd, flight, view_m) / total;
        (length_m <= BUDGET_M).then_some(worth)
    };
    // Each node with its whole flight.
    let root = vec![start];
    let mut nodes: Vec<(f64, Vec<Point>)> = vec![(utility(&root).unwrap_or(0.0), root)];
    let end = |flight: &[Point]| flight[flight.len() - 1];
    for _ in 0..iterations {
        let sample = Point::new(samples.uniform() * side_m, samples.uniform() * side_m);
        let ends: Vec<Point> = nodes.iter().map(|node| end(&node.1)).collect();
        let longer = |node: usize, to: Point| {
            let flight: Vec<Point> = nodes[node].1.iter().copied().chain([to]).collect();
            utility(&flight).map(|worth| (worth, flight))
        };
        let nearest = ranked(&ends, sample).into_iter().take(6).filter_map(|(away_m, node)| {
            longer(node, ends[node].towards(sample, (RrtStarIt::EDGE_MAX_M / away_m).min(1.0)))
        });
        let Some(mut best) = nearest.min_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        let to = end(&best.1);
        let n = nodes.len() as f64;
        let near_m = (0.7 * side_m * (n.ln() / n).sqrt()).min(20.0);
        let near: Vec<usize> = (0..ends.len()).filter(|node| ends[*node].distance_m(to) <= near_m).collect();
        for node in &near {
            best = longer(*node, to).filter(|longer| longer.0 < best.0).unwrap_or(best);
        }
        let inner: Vec<bool> = near
            .iter()
            .map(|leaf| {
                nodes
                    .iter()
                    .any(|node| node.1.len() > 1 && node.1[..node.1.len() - 1].ends_with(&nodes[*leaf].1))
            })
            .collect();
        for (leaf, _) in near.iter().zip(inner).filter(|(leaf, inner)| **leaf != 0 && !inner) {
            let flight: Vec<Point> = best.1.iter().copied().chain([ends[*leaf]]).collect();
            if let Some(worth) = utility(&flight).filter(|worth| *worth < nodes[*leaf].0) {
                nodes[*leaf] = (worth, flight);
            }
        }
        nodes.push(best);
    }
    nodes.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(vec![start], |best| best.1)
}

/// Dijkstra with a binary heap over the graph of `ett_exact`, edges integrated by traversal: the cost to the cell of the goal, or
/// to every cell if there is none.
pub fn dijkstra(costs: &CostMap, start: Point, goal: Option<Point>) -> f64 {
    const MOVES: [(isize, isize); 16] = [
        (1, 0),
        (0, 1),
        (-1, 0),
        (0, -1),
        (1, 1),
        (-1, 1),
        (-1, -1),
        (1, -1),
        (2, 1),
        (1, 2),
        (-1, 2),
        (-2, 1),
        (-2, -1),
        (-1, -2),
        (1, -2),
        (2, -1),
    ];
    let lattice = costs.lattice();
    let (width, height) = (lattice.width() as isize, lattice.height() as isize);
    let (first, last) = (lattice.cell(start), goal.map(|goal| lattice.cell(goal)));
    let mut reached = vec![f64::INFINITY; lattice.cells()];
    reached[first] = 0.0;
    // Costs are positive, so their bits are in their order.
    let mut open = BinaryHeap::from([Reverse((0_u64, first))]);
    let mut farthest = 0.0;
    while let Some(Reverse((bits, cell))) = open.pop() {
        let cost = f64::from_bits(bits);
        if cost > reached[cell] {
            continue;
        }
        farthest = cost;
        if last == Some(cell) {
            break;
        }
        for (columns, rows) in MOVES {
            let (column, row) = (cell as isize % width + columns, cell as isize / width + rows);
            if (0..width).contains(&column) && (0..height).contains(&row) {
                let to = (row * width + column) as usize;
                let edge = costs.segment(Segment { from: lattice.centre(cell), to: lattice.centre(to) });
                if cost + edge < reached[to] {
                    reached[to] = cost + edge;
                    open.push(Reverse((reached[to].to_bits(), to)));
                }
            }
        }
    }
    farthest
}
