//! RRT*-IT: the helicopter flies where speeds are spread most (Folsom et al. 2021, eq. 12, algorithms 5 to 7).
//!
//! The utility of a path, to be minimised, is W2 · length / budget − Σ W1 · SD over the cells newly seen, each counted once a path.
//! What an edge newly shows depends on the path before it, so rewiring an inner node would change its whole subtree: only leaves
//! are rewired.

use helicopter::{AreaCounts, RowSums, Swath};
use rover::{Belief, Lattice, Point, Segment};

use crate::bucket_grid::BucketGrid;
use crate::stream::Stream;

/// Parameters of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RrtStarIt {
    /// Samples, N.
    pub iterations: usize,
    /// Longest flight, metres.
    pub budget_m: f64,
    /// Radius of the ground in view.
    pub view_m: f64,
}

impl RrtStarIt {
    /// Longest edge of the tree, metres.
    pub const EDGE_MAX_M: f64 = 20.0;
    /// Weight of the length, W2. W1 is 1 / Σ SD over the map.
    pub const LENGTH_WEIGHT: f64 = 0.2;
    /// Nodes nearest by distance, of which the best by utility is extended.
    const NEAREST: usize = 6;
    /// Neighbours farther away are not considered; an edge is not longer either.
    const NEAR_MAX_M: f64 = 20.0;
}

/// The flight of greatest utility from `start`; `start` alone if nothing is worth a flight.
#[must_use]
pub fn rrt_star_it(belief: &Belief, start: Point, settings: &RrtStarIt, seed: u64) -> Vec<Point> {
    let lattice = belief.surface().lattice();
    let spread = Spread::new(belief);
    if spread.total == 0.0 {
        return vec![start];
    }
    let mut tree = Tree::new(&spread, belief.surface().lattice(), start, settings);
    let mut samples = Stream::new(seed, "rrt_star_it");
    let (width_m, height_m) = (lattice.width() as f64, lattice.height() as f64);
    for _ in 0..settings.iterations {
        tree.extend(Point::new(samples.uniform() * width_m, samples.uniform() * height_m));
    }
    tree.best()
}

/// The standard deviation of the speed, summed over cells.
struct Spread {
    sums: RowSums,
    /// The sum over the whole map.
    total: f64,
    /// The standard deviation of the most uncertain cell.
    most: f64,
    /// Cells that are uncertain at all.
    uncertain: AreaCounts,
}

impl Spread {
    fn new(belief: &Belief) -> Self {
        let lattice = belief.surface().lattice();
        // Neighbours mostly share a distribution.
        let mut last = (belief.cells()[0], belief.cells()[0].sd_m_per_sol());
        let sd = belief.cells().iter().map(|cell| {
            if *cell != last.0 {
                last = (*cell, cell.sd_m_per_sol());
            }
            last.1
        });
        let sd: Vec<f64> = sd.collect();
        let sums = RowSums::new(lattice, sd.iter().copied());
        Self {
            total: sums.total(),
            sums,
            most: sd.iter().copied().fold(0.0, f64::max),
            uncertain: AreaCounts::new(lattice, |cell| sd[cell] > 0.0),
        }
    }
}

struct Node {
    at: Point,
    parent: u32,
    children: u32,
    length_m: f64,
    /// Σ SD over what the path has shown.
    seen: f64,
    utility: f64,
    /// What the edge to this node shows.
    swath: Swath,
}

/// A path that ends with an edge to a point.
struct Extension {
    parent: u32,
    length_m: f64,
    seen: f64,
    utility: f64,
    swath: Swath,
}

struct Tree<'a> {
    settings: &'a RrtStarIt,
    lattice: Lattice,
    spread: &'a Spread,
    /// W1.
    weight: f64,
    side_m: f64,
    grid: BucketGrid,
    nodes: Vec<Node>,
    near: Vec<(f64, u32)>,
}

impl<'a> Tree<'a> {
    fn new(spread: &'a Spread, lattice: Lattice, root: Point, settings: &'a RrtStarIt) -> Self {
        let mut grid = BucketGrid::new(lattice, settings.iterations);
        grid.insert(root);
        let swath = Swath::new(lattice, Segment { from: root, to: root }, settings.view_m);
        let seen = spread.sums.all(&swath);
        let weight = 1.0 / spread.total;
        let utility = -weight * seen;
        let side_m = (lattice.cells() as f64).sqrt();
        let root = Node { at: root, parent: 0, children: 0, length_m: 0.0, seen, utility, swath };
        Self { settings, lattice, spread, weight, side_m, grid, nodes: vec![root], near: Vec::new() }
    }

    fn utility(&self, length_m: f64, seen: f64) -> f64 {
        RrtStarIt::LENGTH_WEIGHT * length_m / self.settings.budget_m - self.weight * seen
    }

    /// The path through `parent` to `to`; none if it is beyond the budget or its utility surely not below `limit`.
    fn through(&self, parent: u32, to: Point, limit: f64) -> Option<Extension> {
        let before = &self.nodes[parent as usize];
        let length_m = before.length_m + before.at.distance_m(to);
        if length_m > self.settings.budget_m {
            return None;
        }
        let seen_before = before.seen;
        // From cheap to exact: each bound may show that nothing below the limit is to be had.
        let leg = Segment { from: before.at, to };
        let uncertain = self.spread.uncertain.around(leg, self.settings.view_m);
        if self.utility(length_m, seen_before + f64::from(uncertain) * self.spread.most) >= limit {
            return None;
        }
        if uncertain == 0 {
            let utility = self.utility(length_m, seen_before);
            return Some(Extension { parent, length_m, seen: seen_before, utility, swath: Swath::nothing() });
        }
        let swath = Swath::new(self.lattice, leg, self.settings.view_m);
        if self.utility(length_m, seen_before + self.spread.sums.all(&swath)) >= limit {
            return None;
        }
        let mut earlier = Vec::new();
        let mut node = parent;
        loop {
            let swath_before = &self.nodes[node as usize].swath;
            if swath_before.touches(&swath) {
                earlier.push(swath_before);
            }
            if node == 0 {
                break;
            }
            node = self.nodes[node as usize].parent;
        }
        let seen = seen_before + self.spread.sums.fresh(&swath, &earlier);
        let utility = self.utility(length_m, seen);
        (utility < limit).then_some(Extension { parent, length_m, seen, utility, swath })
    }

    fn extend(&mut self, sample: Point) {
        let mut near = std::mem::take(&mut self.near);
        self.grid.nearest(sample, RrtStarIt::NEAREST, &mut near);
        let mut best: Option<(Point, Extension)> = None;
        for &(away_m, node) in &near {
            let share = (RrtStarIt::EDGE_MAX_M / away_m).min(1.0);
            let to = self.nodes[node as usize].at.towards(sample, share);
            let limit = best.as_ref().map_or(f64::INFINITY, |best| best.1.utility);
            if let Some(extension) = self.through(node, to, limit) {
                best = Some((to, extension));
            }
        }
        if let Some((to, mut extension)) = best {
            let n = self.nodes.len() as f64;
            let near_m = (0.7 * self.side_m * (libm::log(n) / n).sqrt()).min(RrtStarIt::NEAR_MAX_M);
            self.grid.within(to, near_m, &mut near);
            for &(_, node) in &near {
                if let Some(better) = self.through(node, to, extension.utility) {
                    extension = better;
                }
            }
            self.insert(to, extension);
            self.rewire(&near);
        }
        self.near = near;
    }

    fn insert(&mut self, at: Point, extension: Extension) {
        let Extension { parent, length_m, seen, utility, swath } = extension;
        self.nodes[parent as usize].children += 1;
        self.nodes.push(Node { at, parent, children: 0, length_m, seen, utility, swath });
        self.grid.insert(at);
    }

    /// Leads neighbouring leaves through the newest node where their path is better so.
    fn rewire(&mut self, near: &[(f64, u32)]) {
        let newest = (self.nodes.len() - 1) as u32;
        let parent = self.nodes[newest as usize].parent;
        for &(_, leaf) in near {
            let node = &self.nodes[leaf as usize];
            if node.children > 0 || leaf == 0 || leaf == parent {
                continue;
            }
            if let Some(better) = self.through(newest, node.at, node.utility) {
                let former = node.parent;
                self.nodes[former as usize].children -= 1;
                self.nodes[newest as usize].children += 1;
                let node = &mut self.nodes[leaf as usize];
                node.parent = better.parent;
                node.length_m = better.length_m;
                node.seen = better.seen;
                node.utility = better.utility;
                node.swath = better.swath;
            }
        }
    }

    fn best(&self) -> Vec<Point> {
        let utility = |node: &usize| self.nodes[*node].utility;
        let mut node = (0..self.nodes.len()).min_by(|a, b| utility(a).total_cmp(&utility(b))).unwrap_or(0);
        let mut points = vec![self.nodes[node].at];
        while node != 0 {
            node = self.nodes[node].parent as usize;
            points.push(self.nodes[node].at);
        }
        points.reverse();
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use helicopter::{length_m, swaths};
    use rover::{Lattice, Speed, SpeedDistribution, Surface};
    use std::collections::BTreeSet;
    use std::sync::Arc;

    /// 150 x 100 cells, certain but for two patches: one that is spread little, near by, and one that is spread much.
    fn patches() -> Belief {
        let lattice = Lattice::new(150, 100).unwrap();
        let much = SpeedDistribution::new([0.5, 0.0, 0.0, 0.5]).unwrap();
        let little = SpeedDistribution::new([0.0, 0.0, 0.5, 0.5]).unwrap();
        let cells = (0..lattice.cells()).map(|cell| match (cell % 150, cell / 150) {
            (100..140, 60..100) => much,
            (20..30, 0..10) => little,
            _ => SpeedDistribution::certain(Speed::Fast),
        });
        Belief::new(Arc::new(Surface::flat(lattice)), cells.collect()).unwrap()
    }

    const SETTINGS: RrtStarIt = RrtStarIt { iterations: 600, budget_m: 300.0, view_m: 25.0 };

    #[test]
    fn the_flight_shows_what_is_spread_most_within_its_budget() {
        let belief = patches();
        let lattice = belief.surface().lattice();
        let flight = rrt_star_it(&belief, Point::new(5.0, 50.0), &SETTINGS, 1);
        assert!(length_m(&flight) <= SETTINGS.budget_m);
        let seen: BTreeSet<usize> = swaths(lattice, &flight, 25.0)
            .flat_map(|swath| swath.cells(lattice).collect::<Vec<_>>())
            .collect();
        let much = seen.iter().filter(|cell| belief.cells()[**cell].probability(Speed::Zero) > 0.0).count();
        assert!(much > 1400, "{much} of 1600 cells");
    }

    #[test]
    fn the_utility_of_each_node_is_that_of_its_path() {
        let belief = patches();
        let lattice = belief.surface().lattice();
        let sd: Vec<f64> = belief.cells().iter().map(SpeedDistribution::sd_m_per_sol).collect();
        let spread = Spread::new(&belief);
        let total = spread.total;
        let mut tree = Tree::new(&spread, lattice, Point::new(80.0, 50.0), &SETTINGS);
        let mut samples = Stream::new(2, "test");
        for _ in 0..200 {
            tree.extend(Point::new(samples.between(0.0, 150.0), samples.between(0.0, 100.0)));
        }
        for node in 0..tree.nodes.len() {
            let mut points = vec![tree.nodes[node].at];
            let mut ancestor = node;
            while ancestor != 0 {
                ancestor = tree.nodes[ancestor].parent as usize;
                points.push(tree.nodes[ancestor].at);
            }
            let seen: BTreeSet<usize> = swaths(lattice, &points, 25.0)
                .flat_map(|swath| swath.cells(lattice).collect::<Vec<_>>())
                .collect();
            let reward: f64 = seen.iter().map(|cell| sd[*cell]).sum::<f64>() / total;
            let utility = 0.2 * length_m(&points) / 300.0 - reward;
            assert!((utility - tree.nodes[node].utility).abs() < 1e-9);
        }
    }

    #[test]
    fn nothing_uncertain_is_worth_no_flight() {
        let lattice = Lattice::new(20, 20).unwrap();
        let cells = vec![SpeedDistribution::certain(Speed::Slow); 400];
        let belief = Belief::new(Arc::new(Surface::flat(lattice)), cells).unwrap();
        let start = Point::new(3.0, 4.0);
        assert_eq!(rrt_star_it(&belief, start, &SETTINGS, 1), [start]);
    }
}
