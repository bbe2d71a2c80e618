//! Certified bounds on the steps and the risk of a policy, and on what any policy costs.

use std::sync::Arc;

use super::{Process, Solved};

/// Share by which h is longer than it needs to be, so that rounding and residuals leave h − P h ≥ 1.
const LONGER: f64 = 1e-6;

/// Unit roundings of the largest value in a sum over the landings of a hop.
const ROUNDINGS: f64 = 32.0;

/// Steps and risk of a policy at each place, with proven bounds on their errors.
///
/// Upper bounds of the risk are a super-solution: at each place the bound is at least the probability of being lost at the next landing plus the
/// expectation of the bound where it lands.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicyBounds {
    policy: Arc<Solved>,
    /// Bounds on the errors of steps and risk, a step of the policy.
    slack: [f64; 2],
    /// A policy whose steps no bound could be proven for: it may never arrive.
    is_proper: bool,
    /// From the steps of a place to h, the bound on the hops that are left.
    hops_a_step: f64,
}

impl PolicyBounds {
    /// The bounds of a policy, by one sweep straight from the definition.
    #[must_use]
    pub fn new(process: &Process, policy: Arc<Solved>) -> Self {
        let Solved { hops, values, .. } = &*policy;
        let (mut residuals, mut largest) = ([0.0_f64; 2], [0.0_f64; 2]);
        for (place, value) in values.iter().enumerate() {
            let hop = usize::from(hops[place]);
            let steps = process.row(place, hop).steps + process.expect(place, hop, 0.0, |to| values[to][0]);
            let risk = process.expect(place, hop, 1.0, |to| values[to][1]);
            for (of, next) in [steps, risk].into_iter().enumerate() {
                let error = (next - value[of]).abs();
                residuals[of] = if error.is_nan() { f64::INFINITY } else { residuals[of].max(error) };
                largest[of] = largest[of].max(value[of].abs());
            }
        }
        let rounding = largest.map(|largest| ROUNDINGS * f64::EPSILON * largest);
        let slack = [residuals[0] + rounding[0], residuals[1] + rounding[1]];
        // h = s (1 + LONGER) / c with s − P s ≥ c − slack, and s ≥ 0.
        let steps_min = process.steps_min();
        let is_proper = values.iter().all(|of| of[0] >= 0.0) && slack[0] <= 0.5 * LONGER * steps_min;
        Self { policy, slack, is_proper, hops_a_step: (1.0 + LONGER) / steps_min }
    }

    /// Whether the policy is proven to end, so that its bounds are finite.
    #[must_use]
    pub fn is_proper(&self) -> bool {
        self.is_proper
    }

    /// Number of the hop at a place, in the order of [`crate::Hop::ALL`].
    #[must_use]
    pub fn hop(&self, place: usize) -> usize {
        usize::from(self.policy.hops[place])
    }

    /// Lower and upper bound on the probability of being lost from a place on.
    #[must_use]
    pub fn risk(&self, place: usize) -> [f64; 2] {
        if !self.is_proper {
            return [0.0, 1.0];
        }
        let error = self.slack[1] * self.hops_left(place);
        // A certain loss is a super-solution, and so is the lesser of two.
        [(self.policy.values[place][1] - error).max(0.0), (self.policy.values[place][1] + error).min(1.0)]
    }

    /// Lower and upper bound on the expected steps from a place until the hopper arrives or is lost.
    #[must_use]
    pub fn steps(&self, place: usize) -> [f64; 2] {
        if !self.is_proper {
            return [0.0, f64::INFINITY];
        }
        let error = self.slack[0] * self.hops_left(place);
        [(self.policy.values[place][0] - error).max(0.0), self.policy.values[place][0] + error]
    }

    /// The upper bound on the probability of being lost if one hop is taken at a place, and then the policy is followed.
    #[must_use]
    pub fn risk_of_hop(&self, process: &Process, place: usize, hop: usize) -> f64 {
        process.expect(place, hop, 1.0, |to| self.risk(to)[1]).min(1.0)
    }

    /// Upper bound on the expected hops that are left, up to the factor that makes h − P h ≥ 1.
    fn hops_left(&self, place: usize) -> f64 {
        self.hops_a_step * self.policy.values[place][0]
    }
}

impl Solved {
    /// A lower bound on E\[steps\] + price · P(loss) of every policy from a place: a sub-solution of Bellman's equation, by one sweep straight from
    /// the definition over all hops.
    #[must_use]
    pub fn least_cost(&self, process: &Process) -> CostBound<'_> {
        let cost = |place: usize| self.values[place][0] + self.price * self.values[place][1];
        let (mut excess, mut largest) = (0.0_f64, self.price);
        for place in 0..process.places() {
            let of = cost(place);
            largest = largest.max(of.abs());
            for hop in 0..4 {
                let next = process.row(place, hop).steps + process.expect(place, hop, self.price, cost);
                let over = of - next;
                excess = if over.is_nan() { f64::INFINITY } else { excess.max(over) };
            }
        }
        let excess = excess + ROUNDINGS * f64::EPSILON * largest;
        let steps_min = process.steps_min();
        CostBound { solved: self, factor: steps_min / (steps_min + excess) }
    }
}

/// Lower bounds on what any policy costs at the price of a [`Solved`].
#[derive(Clone, Copy, Debug)]
pub struct CostBound<'a> {
    solved: &'a Solved,
    factor: f64,
}

impl CostBound<'_> {
    /// The bound from a place.
    #[must_use]
    pub fn at(&self, place: usize) -> f64 {
        let [steps, risk] = self.solved.values[place];
        (self.factor * (steps + self.solved.price * risk)).max(0.0)
    }
}
