//! A world whose hops are listed one by one, each with ends and probabilities of its own.
//!
//! A [`crate::GridWorld`] derives all hops from slopes and soils, and is solved by kernels made for that. Hops that a wall blocks, or that
//! are launched at another angle, follow from no slope. They are listed here, at most four a node, and solved by plain value iteration
//! in double precision, certified in the same way: T contracts by γ′, γ times the largest sum of factors, so
//! |V − V*| ≤ max |V − TV| / (1 − γ′).
//!
//! V(x) = γ max_u \[r_u + Σ f_i V(x_i)\] at a node with hops, and a fixed value at any other.

use crate::{Certificate, Effort, Solution, SolveStatus};

/// Sweeps that keep the hops, between two that choose them.
const KEEPING_SWEEPS: u32 = 8;

/// Choosing sweeps without a smaller residual after which floating point is taken to allow none.
const STALLED_SWEEPS: u32 = 48;

/// A hop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ListedHop {
    /// Its number among the hops of its node, 0 to 3: what the caller calls it.
    pub number: u8,
    /// What it pays.
    pub pays: f64,
    /// Its ends: node, and factor f, its probability, discounted where the hop takes more than a period. A factor of 0 is no end.
    pub ends: [(u32, f64); 4],
}

/// The nodes with their hops.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedWorld {
    /// Discount γ of a period.
    discount: f64,
    /// Index of the first hop of each node, and the number of hops at the end.
    first: Vec<u32>,
    hops: Vec<ListedHop>,
    /// The values of nodes that are fixed: goals, and where the hopper is lost.
    fixed: Vec<Option<f64>>,
}

impl ListedWorld {
    /// A world without nodes, in which a period is discounted by γ, in \[0, 1).
    ///
    /// # Panics
    /// If the discount is out of its range.
    #[must_use]
    pub fn new(discount: f64) -> Self {
        assert!((0.0..1.0).contains(&discount), "a discount needs to be in [0, 1), got {discount}");
        Self { discount, first: vec![0], hops: Vec::new(), fixed: Vec::new() }
    }

    /// Adds a node with its hops.
    ///
    /// # Panics
    /// If there are more than four, a number is not finite, or the factors of a hop sum to more than 1. That its ends are nodes is
    /// checked by [`ListedWorld::solve`].
    pub fn add(&mut self, hops: &[ListedHop]) {
        assert!(hops.len() <= 4, "a node has at most four hops");
        for hop in hops {
            let sum: f64 = hop.ends.iter().map(|(_, factor)| factor).sum();
            let is_scatter = hop.ends.iter().all(|(_, factor)| *factor >= 0.0) && sum <= 1.0 + 1e-6;
            assert!(hop.pays.is_finite() && is_scatter, "a hop needs finite numbers, got {hop:?}");
        }
        self.hops.extend_from_slice(hops);
        self.first.push(self.hops.len() as u32);
        self.fixed.push(None);
    }

    /// Number of nodes.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.fixed.len()
    }

    /// Fixes the value of a node, or frees it.
    pub fn fix(&mut self, node: usize, value: Option<f64>) {
        self.fixed[node] = value;
    }

    /// The hops of a node; none where its value is fixed.
    #[must_use]
    pub fn hops(&self, node: usize) -> &[ListedHop] {
        match self.fixed[node] {
            Some(_) => &[],
            None => &self.hops[self.first[node] as usize..self.first[node + 1] as usize],
        }
    }

    /// The value of a hop under `values`, not discounted by its first period.
    #[must_use]
    pub fn value_of(hop: &ListedHop, values: &[f64]) -> f64 {
        hop.ends.iter().fold(hop.pays, |sum, &(to, factor)| sum + factor * values[to as usize])
    }

    /// The values of the hops of a node under `values`, by their numbers, not discounted by their first period.
    #[must_use]
    pub fn hop_values(&self, values: &[f64], node: usize) -> [Option<f64>; 4] {
        let mut of = [None; 4];
        for hop in self.hops(node) {
            of[usize::from(hop.number)] = Some(Self::value_of(hop, values));
        }
        of
    }

    /// Whether some chain of hops leads from `node` to `goal`, each end of it with a factor above 0.
    #[must_use]
    pub fn leads_to(&self, node: usize, goal: usize) -> bool {
        let mut reached = vec![false; self.nodes()];
        reached[node] = true;
        let mut open = vec![node];
        while let Some(from) = open.pop() {
            if from == goal {
                return true;
            }
            for &(to, factor) in self.hops(from).iter().flat_map(|hop| &hop.ends) {
                if factor > 0.0 && !std::mem::replace(&mut reached[to as usize], true) {
                    open.push(to as usize);
                }
            }
        }
        false
    }

    /// Solves the world from nothing into `values`. `pulse` is called after each sweep that chooses hops.
    ///
    /// # Panics
    /// If an end of a hop is no node.
    pub fn solve(&self, values: &mut Vec<f64>, effort: &Effort, pulse: &dyn Fn()) -> Solution {
        let start = |fixed: &Option<f64>| fixed.unwrap_or(0.0);
        values.clear();
        values.extend(self.fixed.iter().map(start));
        let mut best = vec![u32::MAX; self.nodes()];
        let (mut sweeps, mut least, mut stalled) = (0, f64::INFINITY, 0);
        loop {
            let certificate = self.certify(values);
            let status = if certificate.error_bound <= effort.error_max {
                SolveStatus::Solved
            } else if sweeps >= effort.sweeps_max {
                SolveStatus::Cut
            } else if stalled >= STALLED_SWEEPS || !certificate.residual.is_finite() {
                SolveStatus::AtLimit
            } else {
                stalled = if certificate.residual < least { 0 } else { stalled + 1 };
                least = least.min(certificate.residual);
                self.sweep(values, &mut best);
                for _ in 0..KEEPING_SWEEPS {
                    self.keep(values, &best);
                }
                sweeps += 1;
                pulse();
                continue;
            };
            return Solution { certificate, sweeps, status, residual_passes: sweeps + 1 };
        }
    }

    /// Solves the world as Algorithm 1 of P22 does: from values of `start`, node by node in order, until no value changes by more than
    /// `tolerance` in a sweep, however far that is from solved. `pulse` is called after each sweep.
    ///
    /// # Panics
    /// If an end of a hop is no node.
    pub fn solve_in_order(
        &self,
        values: &mut Vec<f64>,
        (start, tolerance): (f64, f64),
        sweeps_max: u64,
        pulse: &dyn Fn(),
    ) -> Solution {
        values.clear();
        values.extend(self.fixed.iter().map(|fixed| fixed.unwrap_or(start)));
        let mut status = SolveStatus::Cut;
        let mut sweeps = 0;
        while status == SolveStatus::Cut && sweeps < sweeps_max {
            let mut change: f64 = 0.0;
            for node in 0..self.nodes() {
                let hops = self.hops(node).iter().map(|hop| Self::value_of(hop, values));
                let Some(best) = hops.reduce(f64::max) else { continue };
                let value = self.discount * best;
                change = change.max((value - values[node]).abs());
                values[node] = value;
            }
            sweeps += 1;
            pulse();
            if change <= tolerance {
                status = SolveStatus::Solved;
            }
        }
        Solution { certificate: self.certify(values), sweeps, status, residual_passes: 1 }
    }

    /// A bound on the error of `values`.
    #[must_use]
    pub fn certify(&self, values: &[f64]) -> Certificate {
        let mut residual: f64 = 0.0;
        let (mut factors, mut largest): (f64, f64) = (0.0, 0.0);
        for node in 0..self.nodes() {
            largest = largest.max(values[node].abs());
            let mut best = f64::NEG_INFINITY;
            for hop in self.hops(node) {
                largest = largest.max(hop.pays.abs() + values[node].abs());
                factors = factors.max(hop.ends.iter().map(|(_, factor)| factor).sum());
                best = best.max(Self::value_of(hop, values));
            }
            if best > f64::NEG_INFINITY {
                residual = residual.max((self.discount * best - values[node]).abs());
            }
        }
        Certificate::new(residual, self.discount * factors, largest)
    }

    /// Chooses the best hop of each node, forth and back.
    fn sweep(&self, values: &mut [f64], best: &mut [u32]) {
        let nodes = self.nodes();
        for node in (0..nodes).chain((0..nodes).rev()) {
            let mut most = f64::NEG_INFINITY;
            for (number, hop) in self.hops(node).iter().enumerate() {
                let value = Self::value_of(hop, values);
                if value > most {
                    (most, best[node]) = (value, self.first[node] + number as u32);
                }
            }
            if most > f64::NEG_INFINITY {
                values[node] = self.discount * most;
            }
        }
    }

    /// The values under the hops that were best.
    fn keep(&self, values: &mut [f64], best: &[u32]) {
        for (node, best) in best.iter().enumerate().filter(|(_, best)| **best != u32::MAX) {
            values[node] = self.discount * Self::value_of(&self.hops[*best as usize], values);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GridWorld, Hop, Kind, Leaving, Rules, Scatter, Site, Soil, Solver};

    const EFFORT: Effort = Effort { error_max: 1e-9, sweeps_max: u64::MAX };

    /// A grid world whose hops are listed.
    fn listed(world: &GridWorld) -> ListedWorld {
        let mut list = ListedWorld::new(world.rules().discount);
        let lost = world.nodes() as u32;
        for node in 0..world.nodes() {
            if world.kind(node) != Kind::Free {
                list.add(&[]);
                continue;
            }
            let hops = Hop::ALL.map(|hop| {
                let Scatter { intended, stayed, left, right } = world.scatter(node, hop);
                let to = |hop| world.neighbour(node, hop).map_or(lost, |to| to as u32);
                let ends = [
                    (to(hop), intended),
                    (node as u32, stayed),
                    (to(hop.left()), left),
                    (to(hop.right()), right),
                ];
                let pays = |&(to, probability): &(u32, f64)| match to {
                    to if to < lost && world.kind(to as usize) == Kind::Free => {
                        probability * world.payoff(to as usize)
                    }
                    _ => 0.0,
                };
                ListedHop { number: hop as u8, pays: ends.iter().map(pays).sum::<f64>(), ends }
            });
            list.add(&hops);
        }
        list.add(&[]);
        for node in 0..world.nodes() {
            match world.kind(node) {
                Kind::Free => {}
                Kind::Goal => list.fix(node, Some(world.payoff(node))),
                Kind::Lost => list.fix(node, Some(world.rules().loss)),
            }
        }
        list.fix(world.nodes(), Some(world.rules().loss));
        list
    }

    fn world() -> GridWorld {
        let hard = Soil { intended: 0.7, stuck: 0.05, sideways: 0.125, wait: 0.0 };
        let rules = Rules { discount: 0.97, loss: -400.0, leaving: Leaving::Loses, soils: vec![hard, hard] };
        let mut world = GridWorld::new(9, 7, rules).unwrap();
        for node in 0..world.nodes() {
            let kind = match node {
                40 => Kind::Goal,
                22 | 31 => Kind::Lost,
                _ => Kind::Free,
            };
            let slope = (node % 5) as f64 * 0.1 - 0.2;
            let payoff = if kind == Kind::Goal { 100.0 } else { -1.0 - (node % 3) as f64 };
            world.set(node, Site { kind, payoff, slope_east: slope, slope_north: -slope, soil: 0 });
        }
        world
    }

    /// P-UP-VALUES: The values of a world whose hops are listed are those of the grid world with the same hops, and the bound on their error holds.
    #[test]
    fn listed_hops_have_the_values_of_the_grid_world_with_the_same_hops() {
        let world = world();
        let (mut solver, mut values) = (Solver::new(), Vec::new());
        solver.solve(&world, &EFFORT);
        let list = listed(&world);
        let solution = list.solve(&mut values, &EFFORT, &|| ());
        assert_eq!(solution.status, SolveStatus::Solved);
        assert!(solution.certificate.error_bound <= 1e-9);
        for node in (0..world.nodes()).filter(|node| world.kind(*node) == Kind::Free) {
            assert!((values[node] - solver.values()[node]).abs() < 1e-8, "node {node}");
        }
        assert!(list.leads_to(0, 40) && !list.leads_to(40, 0));
        let cut = list.solve(&mut values, &Effort { sweeps_max: 2, ..EFFORT }, &|| ());
        assert_eq!((cut.status, cut.sweeps), (SolveStatus::Cut, 2));
        let off = (0..world.nodes()).filter(|node| world.kind(*node) == Kind::Free);
        let worst = off.map(|node| (values[node] - solver.values()[node]).abs()).fold(0.0, f64::max);
        assert!(worst <= cut.certificate.error_bound, "{worst} {:?}", cut.certificate);
    }
}
