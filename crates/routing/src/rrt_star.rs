//! RRT* for the rover: by distance (naive), or by expected travel time (RRT*-ETT, Folsom et al. 2021, algorithms 1 to 4).
//!
//! Both are one search on different [`CostMap`]s. Three points differ from the printed algorithms. A parent is chosen by its
//! cost-to-come plus the edge; algorithm 3 leaves out the cost-to-come, which would grow a tree of short edges. Forbidden cells
//! are not entered, instead of at a large cost. An extension towards a forbidden cell ends at its border.

use rover::{CostMap, Point, Segment};

use crate::bucket_grid::BucketGrid;
use crate::shorten::random_shortcuts;
use crate::stream::Stream;
use crate::{Route, Trip};

/// Parameters of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RrtStar {
    /// Samples, N. If none of them led to the goal, up to [`RrtStar::PATIENCE`] times as many are drawn until one does.
    pub iterations: usize,
    /// Longest edge, in the units of the cost map.
    pub edge_max: f64,
    /// Random shortcuts tried at the end.
    pub shortcuts: usize,
}

impl RrtStar {
    /// How many times N samples are drawn at most.
    pub const PATIENCE: usize = 8;
    /// Nodes nearest by distance, of which the nearest by cost is extended.
    pub const NEAREST: usize = 6;
    /// Share of the samples that are the goal itself.
    pub const GOAL_BIAS: f64 = 0.05;
    /// Neighbours farther away are not rewired.
    pub const NEAR_MAX_M: f64 = 25.0;
    /// Longest edge of [`rrt_star_ett`].
    pub const EDGE_MAX_SOL: f64 = 0.1125;
    /// Longest edge of [`rrt_star`].
    pub const EDGE_MAX_M: f64 = 15.0;
    /// Random shortcuts of both.
    pub const SHORTCUTS: usize = 300;

    /// The radius for `nodes` nodes on a map of this side: below the bound of RRT* for asymptotic optimality, which therefore is
    /// not claimed.
    fn near_m(side_m: f64, nodes: usize) -> f64 {
        let n = nodes as f64;
        (0.7 * side_m * (libm::log(n) / n).sqrt()).min(Self::NEAR_MAX_M)
    }
}

/// The naive planner: the shortest route on `distance`, which forbids only what is surely impassable.
#[must_use]
pub fn rrt_star(distance: &CostMap, trip: &Trip, iterations: usize, seed: u64) -> Option<Route> {
    let settings = RrtStar { iterations, edge_max: RrtStar::EDGE_MAX_M, shortcuts: RrtStar::SHORTCUTS };
    search(distance, trip, &settings, seed)
}

/// The safe planner: the route of least expected travel time on `expected_time`.
#[must_use]
pub fn rrt_star_ett(expected_time: &CostMap, trip: &Trip, iterations: usize, seed: u64) -> Option<Route> {
    let settings = RrtStar { iterations, edge_max: RrtStar::EDGE_MAX_SOL, shortcuts: RrtStar::SHORTCUTS };
    search(expected_time, trip, &settings, seed)
}

/// A route of low cost, or none if the samples did not reach the goal.
fn search(costs: &CostMap, trip: &Trip, settings: &RrtStar, seed: u64) -> Option<Route> {
    let mut samples = Stream::new(seed, "rrt_star");
    let mut tree = Tree::new(costs, trip.start, settings.iterations);
    let lattice = costs.lattice();
    let (width_m, height_m) = (lattice.width() as f64, lattice.height() as f64);
    let side_m = (width_m * height_m).sqrt();
    let mut arrived: Vec<u32> = Vec::new();
    if trip.goal.distance_m(trip.start) == 0.0 {
        arrived.push(0);
    }
    for iteration in 0..settings.iterations * RrtStar::PATIENCE {
        if iteration >= settings.iterations && !arrived.is_empty() {
            break;
        }
        let sample = if samples.uniform() < RrtStar::GOAL_BIAS {
            trip.goal.at
        } else {
            Point::new(samples.uniform() * width_m, samples.uniform() * height_m)
        };
        let near_m = RrtStar::near_m(side_m, tree.nodes.len());
        if let Some(node) = tree.extend(sample, settings.edge_max, near_m)
            && trip.goal.distance_m(tree.node(node).at) == 0.0
        {
            arrived.push(node);
        }
    }
    let best = arrived.into_iter().min_by(|a, b| tree.node(*a).cost.total_cmp(&tree.node(*b).cost))?;
    let mut points = tree.way(best);
    random_shortcuts(costs, &mut points, settings.shortcuts, &mut Stream::new(seed, "shortcuts"));
    // A node counts as arrived wherever it lies in the disc; what the route drives on within it leads nowhere.
    trip.goal.cut(&mut points);
    Some(Route::new(costs, points))
}

struct Tree<'a> {
    costs: &'a CostMap,
    grid: BucketGrid,
    nodes: Vec<Node>,
    /// Neighbours of the node in hand, kept for their memory.
    near: Vec<(f64, u32)>,
    ranked: Vec<(f64, u32)>,
    /// Nodes whose cost is still to be lowered, kept for its memory.
    open: Vec<u32>,
}

/// A node with its links, together in memory: most of the time of a large tree is spent on what is not in the cache.
#[derive(Clone, Copy)]
struct Node {
    at: Point,
    /// From the root.
    cost: f64,
    parent: u32,
    /// A child, the others in a chain behind it.
    first_child: u32,
    next_sibling: u32,
    previous_sibling: u32,
}

/// In place of a node.
const NONE: u32 = u32::MAX;

impl<'a> Tree<'a> {
    fn new(costs: &'a CostMap, root: Point, expected: usize) -> Self {
        let mut grid = BucketGrid::new(costs.lattice(), expected);
        grid.insert(root);
        let root = Node {
            at: root,
            cost: 0.0,
            parent: 0,
            first_child: NONE,
            next_sibling: NONE,
            previous_sibling: NONE,
        };
        Self { costs, grid, nodes: vec![root], near: Vec::new(), ranked: Vec::new(), open: Vec::new() }
    }

    fn node(&self, node: u32) -> &Node {
        &self.nodes[node as usize]
    }

    /// Adds a node towards `sample`, unless nothing lies that way.
    fn extend(&mut self, sample: Point, edge_max: f64, near_m: f64) -> Option<u32> {
        let nearest = self.nearest(sample);
        let from = self.node(nearest).at;
        let to = self.costs.reach(Segment { from, to: sample }, edge_max);
        if from.distance_m(to) < 1e-6 {
            return None;
        }
        self.grid.within(to, near_m, &mut self.near);
        let (parent, cost) = self.parent(nearest, to)?;
        let node = self.nodes.len() as u32;
        let alone = Node { first_child: NONE, ..self.nodes[0] };
        self.nodes.push(Node { at: to, cost, ..alone });
        self.link(node, parent);
        self.grid.insert(to);
        self.rewire(node);
        Some(node)
    }

    /// Makes a node a child of another one.
    fn link(&mut self, node: u32, parent: u32) {
        let next = std::mem::replace(&mut self.nodes[parent as usize].first_child, node);
        if next != NONE {
            self.nodes[next as usize].previous_sibling = node;
        }
        let node = &mut self.nodes[node as usize];
        (node.parent, node.previous_sibling, node.next_sibling) = (parent, NONE, next);
    }

    /// Takes a node from its parent.
    fn unlink(&mut self, node: u32) {
        let Node { parent, previous_sibling, next_sibling, .. } = *self.node(node);
        if previous_sibling == NONE {
            self.nodes[parent as usize].first_child = next_sibling;
        } else {
            self.nodes[previous_sibling as usize].next_sibling = next_sibling;
        }
        if next_sibling != NONE {
            self.nodes[next_sibling as usize].previous_sibling = previous_sibling;
        }
    }

    /// The cheapest by cost of the nearest by distance (algorithm 2); the nearest by distance if forbidden ground lies between.
    fn nearest(&mut self, sample: Point) -> u32 {
        self.grid.nearest(sample, RrtStar::NEAREST, &mut self.ranked);
        let mut best = (f64::MAX, self.ranked[0].1);
        for &(away_m, node) in &self.ranked {
            if away_m * self.costs.least() < best.0 {
                let cost = self.costs.within(Segment { from: self.node(node).at, to: sample }, best.0);
                if cost < best.0 {
                    best = (cost, node);
                }
            }
        }
        best.1
    }

    /// The neighbour through which `to` is cheapest, with that cost. In the order of a lower bound, few edges are integrated.
    fn parent(&mut self, nearest: u32, to: Point) -> Option<(u32, f64)> {
        let least = self.costs.least();
        let bound = |away_m: f64, node: u32| self.nodes[node as usize].cost + away_m * least;
        self.ranked.clear();
        self.ranked.extend(self.near.iter().map(|&(away_m, node)| (bound(away_m, node), node)));
        let away_m = self.node(nearest).at.distance_m(to);
        self.ranked.push((bound(away_m, nearest), nearest));
        self.ranked.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<(u32, f64)> = None;
        for &(bound, node) in &self.ranked {
            let limit = best.map_or(f64::MAX, |best| best.1);
            if bound >= limit {
                break;
            }
            let Node { at, cost: so_far, .. } = *self.node(node);
            let edge = self.costs.within(Segment { from: at, to }, limit - so_far);
            if so_far + edge < limit {
                best = Some((node, so_far + edge));
            }
        }
        best
    }

    /// Leads neighbours through the new node where that is cheaper.
    fn rewire(&mut self, node: u32) {
        let Node { at: from, cost: so_far, .. } = *self.node(node);
        let near = std::mem::take(&mut self.near);
        for &(away_m, other) in &near {
            let Node { at: to, cost, .. } = *self.node(other);
            let saved = cost - so_far;
            if away_m * self.costs.least() >= saved {
                continue;
            }
            let edge = self.costs.within(Segment { from, to }, saved);
            if edge < saved {
                self.unlink(other);
                self.link(other, node);
                self.cheapen(other, saved - edge);
            }
        }
        self.near = near;
    }

    /// Takes `saved` off the cost of a node and of all below it.
    fn cheapen(&mut self, node: u32, saved: f64) {
        self.open.push(node);
        while let Some(node) = self.open.pop() {
            let node = &mut self.nodes[node as usize];
            node.cost -= saved;
            let mut child = node.first_child;
            while child != NONE {
                self.open.push(child);
                child = self.node(child).next_sibling;
            }
        }
    }

    fn way(&self, node: u32) -> Vec<Point> {
        let mut points = vec![self.node(node).at];
        let mut node = node;
        while node != 0 {
            node = self.node(node).parent;
            points.push(self.node(node).at);
        }
        points.reverse();
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Goal;
    use rover::{Lattice, Surface};
    use std::sync::Arc;

    /// 60 x 40 cells, a wall with a gap in the north.
    fn walled() -> (CostMap, Trip) {
        let lattice = Lattice::new(60, 40).unwrap();
        let wall = |cell: usize| (28..32).contains(&(cell % 60)) && cell / 60 < 32;
        let costs = (0..lattice.cells()).map(|cell| if wall(cell) { f64::INFINITY } else { 0.005 });
        let map = CostMap::new(Arc::new(Surface::flat(lattice)), costs.collect());
        let goal = Goal { at: Point::new(55.0, 10.0), radius_m: 3.0 };
        (map, Trip { start: Point::new(5.0, 10.0), goal })
    }

    #[test]
    fn a_route_leads_around_a_wall_near_the_shortest_way() {
        let (map, trip) = walled();
        let route = rrt_star_ett(&map, &trip, 1200, 7).unwrap();
        assert_eq!(route.points[0], trip.start);
        let end_m = route.points.last().unwrap().distance_m(trip.goal.at);
        assert!((end_m - trip.goal.radius_m).abs() < 1e-9, "it ends where it reaches the goal: {end_m}");
        let shortest_m = trip.start.distance_m(Point::new(28.0, 32.0))
            + 4.0
            + trip.goal.distance_m(Point::new(32.0, 32.0));
        let ratio = route.cost / (0.005 * shortest_m);
        assert!((0.9999..1.03).contains(&ratio), "{ratio}");
        assert_eq!(rrt_star_ett(&map, &trip, 1200, 7), Some(route), "a function of its seed");
    }

    #[test]
    fn more_samples_never_cost_more_and_tree_costs_are_those_of_their_ways() {
        let (map, trip) = walled();
        let mut tree = Tree::new(&map, trip.start, 600);
        let mut samples = Stream::new(3, "test");
        let mut before = Vec::new();
        for _ in 0..600 {
            let sample = Point::new(samples.between(0.0, 60.0), samples.between(0.0, 40.0));
            let _ = tree.extend(sample, 0.1, RrtStar::near_m(49.0, tree.nodes.len()));
            for (node, before) in before.iter().enumerate() {
                assert!(tree.nodes[node].cost <= *before);
            }
            before = tree.nodes.iter().map(|node| node.cost).collect();
        }
        for node in 0..tree.nodes.len() {
            let way = map.way(&tree.way(node as u32));
            assert!((way - tree.nodes[node].cost).abs() < 1e-9, "{way} against {}", tree.nodes[node].cost);
        }
    }

    #[test]
    fn no_route_is_none() {
        let (map, trip) = walled();
        let mut costs = map.costs().to_vec();
        for row in 0..40 {
            costs[row * 60 + 30] = f64::INFINITY;
        }
        let closed = CostMap::new(Arc::clone(map.surface()), costs);
        assert_eq!(rrt_star_ett(&closed, &trip, 100, 1), None);
    }
}
