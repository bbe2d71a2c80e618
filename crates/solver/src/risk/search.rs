//! The multiplier under which the bound on the risk holds, and the policies that are mixed there.

use std::sync::Arc;

use super::{LeastRisk, PolicyBounds, Process, Solved, least_risk};
use crate::Error;

/// Significant bits of a multiplier. The grid of multipliers is fixed, so that no question depends on another.
const BITS: u32 = 16;

/// From one multiplier to the next while none keeps the bound.
const GROWTH: f64 = 16.0;

/// The largest multiplier, steps: one for which a step is worth a risk of 2⁻³⁰.
const MULTIPLIER_MAX: f64 = (1_u64 << 30) as f64;

/// Most multipliers of a question.
const MULTIPLIERS_MAX: u32 = 64;

/// The gap that ends a search, a share of the cost.
pub const GAP: f64 = 1e-4;

/// A bound on the probability of being lost, above 0 and below 1.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct RiskBound(f64);

impl RiskBound {
    /// The least budget that is told from none.
    const LEAST: f64 = f64::MIN_POSITIVE;

    /// The bound Δ on the probability of being lost.
    ///
    /// # Errors
    /// If it is not above 0 and below 1: no plan over ground with any danger keeps 0, and every plan keeps 1.
    pub fn new(bound: f64) -> Result<Self, Error> {
        if bound > 0.0 && bound < 1.0 { Ok(Self(bound)) } else { Err(Error::RiskBound { got: bound }) }
    }

    /// What is left of a bound: a certified probability of being lost, in [0, 1]. 0 and 1 become the nearest bounds.
    ///
    /// # Panics
    /// If it is not in [0, 1].
    #[must_use]
    pub fn left(budget: f64) -> Self {
        assert!((0.0..=1.0).contains(&budget), "a budget of risk is a probability, got {budget}");
        Self(budget.clamp(Self::LEAST, 1.0 - f64::EPSILON))
    }

    /// The bound, in (0, 1).
    #[must_use]
    pub fn get(self) -> f64 {
        self.0
    }
}

/// From where, and with which bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// The node that the hopper is at.
    pub node: usize,
    /// The bound Δ on the probability of being lost.
    pub bound: RiskBound,
    /// The charge C for a loss, steps: those left of the mission.
    pub charge: f64,
}

/// One of the policies of a plan.
#[derive(Clone, Debug)]
pub struct Part {
    /// The probability with which it is drawn.
    pub share: f64,
    /// The multiplier under which it costs least.
    pub multiplier: f64,
    /// What it does, and what it risks.
    pub policy: Arc<PolicyBounds>,
}

/// The answer to a [`Question`].
#[derive(Clone, Debug)]
pub struct BoundedPlan {
    /// One policy, or the two that are mixed, the riskier one first. Where the bound cannot be kept, the one that risks least.
    pub parts: Vec<Part>,
    /// Upper bound on the probability of being lost.
    pub risk: f64,
    /// Upper bound on the expected steps.
    pub steps: f64,
    /// Upper bound on G = E\[steps\] + C P(loss).
    pub cost: f64,
    /// Lower bound on the G of every plan that keeps the bound: the dual. 0 where none was found.
    pub lower_bound: f64,
    /// The multiplier λ of the dual, steps.
    pub multiplier: f64,
    /// The least risk that any plan achieves, where the bound cannot be kept.
    pub least: Option<LeastRisk>,
    /// Multipliers that were tried.
    pub solves: u32,
}

impl BoundedPlan {
    /// Whether the plan keeps the bound.
    #[must_use]
    pub fn is_feasible(&self) -> bool {
        self.least.is_none()
    }

    /// How far the cost may be from the least one, steps; infinite where the bound cannot be kept.
    #[must_use]
    pub fn gap(&self) -> f64 {
        if self.is_feasible() { (self.cost - self.lower_bound).max(0.0) } else { f64::INFINITY }
    }

    /// The policy that is drawn by a number in [0, 1).
    #[must_use]
    pub fn drawn(&self, draw: f64) -> &Part {
        let mut sum = 0.0;
        for part in &self.parts {
            sum += part.share;
            if draw < sum {
                return part;
            }
        }
        // Shares sum to 1 but for rounding; the last policy is the safest.
        &self.parts[self.parts.len() - 1]
    }
}

/// A multiplier that was tried.
#[derive(Clone)]
struct Tried {
    multiplier: f64,
    policy: Arc<PolicyBounds>,
    solved: Arc<Solved>,
    risk: f64,
    cost: f64,
}

/// The plan of least expected steps among those that keep the bound, solved from nothing. `pulse` is called after each sweep.
///
/// `None` where the node is not free, or no chain of hops leads from it to a goal.
///
/// # Panics
/// If the charge is not finite and at least 0.
#[must_use]
pub fn bounded(process: &Process, question: &Question, pulse: &dyn Fn()) -> Option<BoundedPlan> {
    let Question { node, bound, charge } = *question;
    assert!(
        charge >= 0.0 && charge.is_finite(),
        "a charge for a loss needs to be finite and at least 0, got {charge}"
    );
    let place = process.place(node)?;
    let mut search = Search { process, place, charge, bound: bound.0, lower: [0.0; 2], solves: 0, pulse };
    let free = search.tried(0.0, None);
    if free.risk <= bound.0 {
        return Some(search.plan(&[(1.0, &free)], None));
    }
    let (mut riskier, mut safer) = (free.clone(), free);
    let mut safest = safer.clone();
    while safer.risk > bound.0 && safer.multiplier < MULTIPLIER_MAX {
        let next = if safer.multiplier == 0.0 { charge.max(1.0) } else { GROWTH * safer.multiplier };
        let next = search.tried(on_grid(next).min(MULTIPLIER_MAX), Some(&safer));
        riskier = std::mem::replace(&mut safer, next);
        if safer.risk < safest.risk {
            safest = safer.clone();
        }
    }
    if safer.risk > bound.0 {
        let least = least_risk(process, place, safest.risk, pulse);
        return Some(search.plan(&[(1.0, &safest)], Some(least)));
    }
    let mut is_midway = false;
    loop {
        let share = share_of_riskier(riskier.risk, safer.risk, bound.0);
        let cost = share * riskier.cost + (1.0 - share) * safer.cost;
        let is_close = cost - search.lower[0] <= GAP * cost;
        let next = next_multiplier(&riskier, &safer, is_midway);
        let Some(next) = next.filter(|_| !is_close && search.solves < MULTIPLIERS_MAX) else {
            if share == 0.0 {
                return Some(search.plan(&[(1.0, &safer)], None));
            }
            return Some(search.plan(&[(share, &riskier), (1.0 - share, &safer)], None));
        };
        let next = search.tried(next, Some(&safer));
        // A chord that finds no new policy is at the kink, but for the grid; halving the bracket ends there too.
        is_midway = !is_midway && (next.risk == riskier.risk || next.risk == safer.risk);
        if next.risk > bound.0 {
            riskier = next;
        } else {
            safer = next;
        }
    }
}

struct Search<'a> {
    process: &'a Process,
    place: usize,
    charge: f64,
    bound: f64,
    /// The greatest lower bound, and its multiplier.
    lower: [f64; 2],
    solves: u32,
    pulse: &'a dyn Fn(),
}

impl Search<'_> {
    fn tried(&mut self, multiplier: f64, start: Option<&Tried>) -> Tried {
        let start = start.map(|start| &*start.solved);
        let solved = self.process.solve(self.charge + multiplier, start, self.pulse);
        let lower = solved.least_cost(self.process).at(self.place) - multiplier * self.bound;
        if lower > self.lower[0] {
            self.lower = [lower, multiplier];
        }
        self.solves += 1;
        let solved = Arc::new(solved);
        let policy = PolicyBounds::new(self.process, Arc::clone(&solved));
        let risk = policy.risk(self.place)[1];
        let cost = policy.steps(self.place)[1] + self.charge * risk;
        Tried { multiplier, policy: Arc::new(policy), solved, risk, cost }
    }

    fn plan(&self, parts: &[(f64, &Tried)], least: Option<LeastRisk>) -> BoundedPlan {
        let sum =
            |of: &dyn Fn(&Tried) -> f64| parts.iter().map(|(share, part)| share * of(part)).sum::<f64>();
        BoundedPlan {
            risk: sum(&|part| part.risk),
            steps: sum(&|part| part.policy.steps(self.place)[1]),
            cost: sum(&|part| part.cost),
            lower_bound: if least.is_none() { self.lower[0] } else { 0.0 },
            multiplier: if least.is_none() { self.lower[1] } else { MULTIPLIER_MAX },
            least,
            solves: self.solves,
            parts: parts
                .iter()
                .map(|(share, part)| Part {
                    share: *share,
                    multiplier: part.multiplier,
                    policy: Arc::clone(&part.policy),
                })
                .collect(),
        }
    }
}

/// The largest share of the riskier policy with which the mixture keeps the bound.
fn share_of_riskier(riskier: f64, safer: f64, bound: f64) -> f64 {
    let mut share = ((bound - safer) / (riskier - safer)).clamp(0.0, 1.0);
    let mut less = f64::EPSILON;
    while share > 0.0 && share * riskier + (1.0 - share) * safer > bound {
        share = (share - less).max(0.0);
        less *= 2.0;
    }
    share
}

/// The multiplier to try next: where both policies cost the same, or midway; `None` where the grid has none between them.
fn next_multiplier(riskier: &Tried, safer: &Tried, is_midway: bool) -> Option<f64> {
    let (low, high) = (riskier.multiplier, safer.multiplier);
    let chord = (safer.cost - riskier.cost) / (riskier.risk - safer.risk);
    let middle = if low == 0.0 { 0.5 * high } else { low.midpoint(high) };
    let candidates = if is_midway { [middle, chord] } else { [chord, middle] };
    candidates.into_iter().map(on_grid).find(|next| *next > low && *next < high)
}

/// The largest multiplier of the grid that is not above `multiplier`: one of [`BITS`] significant bits.
fn on_grid(multiplier: f64) -> f64 {
    f64::from_bits(multiplier.to_bits() & !((1 << (f64::MANTISSA_DIGITS - BITS)) - 1))
}
