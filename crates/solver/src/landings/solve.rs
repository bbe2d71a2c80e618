//! Values of a world whose hops land by a table: sweeps of Gauss and Seidel, and a certificate from the definition.
//!
//! A sweep begins at a goal and goes outward row by row, so that a change at the goal crosses the whole map at once. Staying is solved for: with
//! probability s of staying, V = γ (Σ p w + s (r + V)) has the solution V = γ (Σ p w + s r) / (1 − γ s), and where a hop takes two periods
//! V = γ (r + γ (Σ p w + s (r + V))) has V = γ² (Σ p w + s r + r / γ) / (1 − γ² s). Between two sweeps over all hops, the
//! best hops alone are swept, at a quarter of the cost, until little of the change is left (modified policy iteration).

use super::TableWorld;
use super::world::offset;
use crate::{Certificate, Effort, Hop, Kind, Leaving, Solution, SolveStatus};

/// Most sweeps over the best hops between two over all hops.
const EVALUATIONS: u64 = 12;

/// They end when the change has fallen to this share of the sweep's over all hops.
const EVALUATED: f64 = 0.05;

/// Most goals from which sweeps begin in turns.
const MIDDLES_MAX: usize = 4;

/// Unit roundings of the largest afterstate value that a change of values may come from, where nothing is left to gain.
const ROUNDINGS: f64 = 8.0;

/// The values of a world from nothing, and how good they are. Values of nodes that are not free are 0.
///
/// A sweep over the best hops counts as a quarter in [`Solution::sweeps`].
#[must_use]
pub fn solve(world: &TableWorld, effort: &Effort) -> (Vec<f64>, Solution) {
    let mut sweeper = Sweeper::new(world);
    let settled = effort.error_max * (1.0 - world.rules().discount);
    let limit = ROUNDINGS * f64::EPSILON * sweeper.largest();
    let (mut quarters, mut round, mut residual_passes) = (0_u64, 0, 0);
    loop {
        let change = sweeper.sweep(round, false);
        quarters += 4;
        round += 1;
        let is_cut = (quarters + 4).div_ceil(4) > effort.sweeps_max;
        if change <= settled.max(limit) || is_cut {
            let values = sweeper.values();
            let certificate = certify(world, &values);
            residual_passes += 1;
            let status = if certificate.error_bound <= effort.error_max {
                Some(SolveStatus::Solved)
            } else if is_cut {
                Some(SolveStatus::Cut)
            } else if change <= limit {
                Some(SolveStatus::AtLimit)
            } else {
                None
            };
            if let Some(status) = status {
                let sweeps = quarters.div_ceil(4);
                return (values, Solution { certificate, status, sweeps, residual_passes });
            }
        }
        for _ in 0..EVALUATIONS {
            if (quarters + 5).div_ceil(4) > effort.sweeps_max {
                break;
            }
            let left = sweeper.sweep(round, true);
            quarters += 1;
            round += 1;
            if left <= EVALUATED * change {
                break;
            }
        }
    }
}

/// The right-hand side of Bellman's equation at a free node under `values`, straight from the definition, for each of the four hops in
/// the order of [`Hop::ALL`].
#[must_use]
pub fn action_values(world: &TableWorld, values: &[f64], node: usize) -> [f64; 4] {
    values_of_hops(world, node, |to| world.afterstate_value(values, to))
}

/// The values of the four hops at a node, with the afterstate value of a node given by `afterstate`.
fn values_of_hops(world: &TableWorld, node: usize, afterstate: impl Fn(usize) -> f64) -> [f64; 4] {
    let rules = world.rules();
    let classes = world.classes(node);
    let at = [node % world.width(), node / world.width()];
    Hop::ALL.map(|hop| {
        let row = &world.table().rows()[usize::from(classes[hop as usize])];
        let mut next = row.lost() * rules.loss;
        for landing in &row.landings {
            let to = world.landing_from(at, hop, landing.forward, landing.left);
            let lands = match (to, rules.leaving) {
                (Some(to), _) => afterstate(to),
                (None, Leaving::Stays) => afterstate(node),
                (None, Leaving::Loses) => rules.loss,
            };
            next += landing.probability * lands;
        }
        match row.waits {
            true => rules.discount * (world.payoff(node) + rules.discount * next),
            false => rules.discount * next,
        }
    })
}

/// Certifies `values` by one sweep straight from the definition.
///
/// # Panics
/// If `values` has not one value a node.
#[must_use]
pub fn certify(world: &TableWorld, values: &[f64]) -> Certificate {
    assert_eq!(values.len(), world.nodes(), "a certificate needs a value a node");
    let mut residual: f64 = 0.0;
    let mut largest = world.rules().loss.abs();
    let afterstates: Vec<f64> = (0..world.nodes()).map(|node| world.afterstate_value(values, node)).collect();
    for (node, value) in values.iter().enumerate() {
        match world.kind(node) {
            Kind::Free => {
                let hops = values_of_hops(world, node, |to| afterstates[to]);
                let best = hops.into_iter().fold(f64::NEG_INFINITY, f64::max);
                let is_none = best.is_nan() || value.is_nan();
                residual = residual.max(if is_none { f64::INFINITY } else { (best - value).abs() });
                largest = largest.max(world.payoff(node).abs() + value.abs());
            }
            Kind::Goal => largest = largest.max(world.payoff(node).abs()),
            Kind::Lost => {}
        }
    }
    // Fourteen terms where `Certificate` reckons with four: each term more carries two unit roundings, that of its product and of its sum,
    // and the probability of being lost as many again. Four times the largest makes room for them.
    Certificate::new(residual, world.rules().discount, 4.0 * largest)
}

/// A row of the table for one hop, as distances between nodes.
#[derive(Clone, Copy, Debug)]
struct Stencil {
    /// Its terms among those of all.
    first: u32,
    count: u32,
    /// How often the payoff of the departure counts: the probability s of staying, and 1 / γ where the hop waits.
    pays: f64,
    /// What being lost adds.
    lost: f64,
    /// γ / (1 − γ s), with γ² in place of γ where the hop waits.
    factor: f64,
}

/// The discount of a hop until it lands, and how often the payoff of its departure counts before that, in terms of landings: 1 / γ
/// where it waits for a period.
fn periods(discount: f64, waits: bool) -> (f64, f64) {
    match waits {
        true if discount > 0.0 => (discount * discount, 1.0 / discount),
        _ => (discount, 0.0),
    }
}

/// A landing elsewhere.
#[derive(Clone, Copy, Debug)]
struct Term {
    by: isize,
    probability: f64,
}

struct Sweeper<'a> {
    world: &'a TableWorld,
    /// Afterstate values of all nodes.
    afterstates: Vec<f64>,
    best: Vec<u8>,
    stencils: Vec<Stencil>,
    terms: Vec<Term>,
    /// Where sweeps begin, in turns: at the goals, or in the corners where there is none.
    middles: Vec<[usize; 2]>,
    /// Farthest landing along an axis: nearer to the edge than that, hops may leave the grid.
    reach: usize,
}

impl<'a> Sweeper<'a> {
    fn new(world: &'a TableWorld) -> Self {
        let rules = world.rules();
        let (mut stencils, mut terms, mut reach) = (Vec::new(), Vec::new(), 0);
        for row in world.table().rows() {
            for hop in Hop::ALL {
                let first = terms.len() as u32;
                let mut stays = 0.0;
                for landing in row.landings.iter().filter(|landing| landing.probability > 0.0) {
                    let [east, north] = offset(hop, landing.forward, landing.left);
                    reach = reach.max(east.unsigned_abs()).max(north.unsigned_abs());
                    if [east, north] == [0, 0] {
                        stays += landing.probability;
                    } else {
                        let by = north * world.width() as isize + east;
                        terms.push(Term { by, probability: landing.probability });
                    }
                }
                let (discount, waiting) = periods(rules.discount, row.waits);
                stencils.push(Stencil {
                    first,
                    count: terms.len() as u32 - first,
                    pays: stays + waiting,
                    lost: row.lost() * rules.loss,
                    factor: discount / (1.0 - discount * stays),
                });
            }
        }
        // From below: nothing is worth less than paying the least for ever, or being lost.
        let payoffs = (0..world.nodes()).filter(|node| world.kind(*node) != Kind::Lost);
        let least = payoffs.map(|node| world.payoff(node)).fold(0.0, f64::min);
        let worst = (least / (1.0 - rules.discount)).min(rules.loss);
        let start = vec![worst; world.nodes()];
        let afterstates = (0..world.nodes()).map(|node| world.afterstate_value(&start, node)).collect();
        let goals = (0..world.nodes()).filter(|node| world.kind(*node) == Kind::Goal);
        let mut middles: Vec<[usize; 2]> =
            goals.take(MIDDLES_MAX).map(|node| [node % world.width(), node / world.width()]).collect();
        if middles.is_empty() {
            middles = vec![[0, 0], [world.width(), world.height()]];
        }
        Self { world, afterstates, best: vec![0; world.nodes()], stencils, terms, middles, reach }
    }

    /// The largest afterstate value there may be.
    fn largest(&self) -> f64 {
        let rules = self.world.rules();
        let payoff = (0..self.world.nodes()).map(|node| self.world.payoff(node).abs()).fold(0.0, f64::max);
        (payoff / (1.0 - rules.discount)).max(rules.loss.abs())
    }

    fn values(&self) -> Vec<f64> {
        let value = |(node, afterstate): (usize, &f64)| match self.world.kind(node) {
            Kind::Free => afterstate - self.world.payoff(node),
            Kind::Goal | Kind::Lost => 0.0,
        };
        self.afterstates.iter().enumerate().map(value).collect()
    }

    /// Updates all free nodes in the order of this round, by the best hop of all or by the one that was best; the largest change.
    fn sweep(&mut self, round: u64, best_only: bool) -> f64 {
        let (width, height) = (self.world.width(), self.world.height());
        let [middle_x, middle_y] = self.middles[round as usize % self.middles.len()];
        let mut change: f64 = 0.0;
        for y in (middle_y..height).chain((0..middle_y).rev()) {
            let is_inside = y >= self.reach && y + self.reach < height;
            for x in (middle_x..width).chain((0..middle_x).rev()) {
                let node = y * width + x;
                if self.world.kind(node) != Kind::Free {
                    continue;
                }
                let is_inside = is_inside && x >= self.reach && x + self.reach < width;
                let value = match (is_inside, best_only) {
                    (true, true) => self.hop_value(node, usize::from(self.best[node])),
                    (true, false) => self.best_value(node),
                    (false, _) => self.value_at_edge(node),
                };
                let afterstate = self.world.payoff(node) + value;
                change = change.max((afterstate - self.afterstates[node]).abs());
                self.afterstates[node] = afterstate;
            }
        }
        change
    }

    #[inline(always)]
    fn best_value(&mut self, node: usize) -> f64 {
        let values = [0, 1, 2, 3].map(|hop| self.hop_value(node, hop));
        let mut best = 0;
        for hop in 1..4 {
            if values[hop] > values[best] {
                best = hop;
            }
        }
        self.best[node] = best as u8;
        values[best]
    }

    /// The value of a node if this hop is chosen there for good; no landing of it may leave the grid.
    #[inline(always)]
    fn hop_value(&self, node: usize, hop: usize) -> f64 {
        let class = usize::from(self.world.classes(node)[hop]);
        let stencil = &self.stencils[4 * class + hop];
        let (first, count) = (stencil.first as usize, stencil.count as usize);
        let mut next = stencil.lost + stencil.pays * self.world.payoff(node);
        for term in &self.terms[first..first + count] {
            next += term.probability * self.afterstates[node.wrapping_add_signed(term.by)];
        }
        stencil.factor * next
    }

    /// The value of a node from which hops may leave the grid.
    fn value_at_edge(&mut self, node: usize) -> f64 {
        let world = self.world;
        let rules = world.rules();
        let classes = world.classes(node);
        let mut best = f64::NEG_INFINITY;
        for hop in Hop::ALL {
            let row = &world.table().rows()[usize::from(classes[hop as usize])];
            let (mut next, mut stays) = (row.lost() * rules.loss, 0.0);
            for landing in &row.landings {
                match (world.landing(node, hop, landing.forward, landing.left), rules.leaving) {
                    (Some(to), _) if to == node => stays += landing.probability,
                    (None, Leaving::Stays) => stays += landing.probability,
                    (Some(to), _) => next += landing.probability * self.afterstates[to],
                    (None, Leaving::Loses) => next += landing.probability * rules.loss,
                }
            }
            let (discount, waiting) = periods(rules.discount, row.waits);
            let value = discount * (next + (stays + waiting) * world.payoff(node)) / (1.0 - discount * stays);
            if value > best {
                (best, self.best[node]) = (value, hop as u8);
            }
        }
        best
    }
}
