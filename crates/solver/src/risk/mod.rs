//! Least expected steps with a certified bound on the probability of losing the hopper.
//!
//! The process is that of a [`GridWorld`](crate::GridWorld) or a [`TableWorld`](crate::landings::TableWorld) without discount and without
//! payoffs: a hop costs steps (2, and 1 more for an intended hop from soil that takes two periods), and ends where the hopper is lost or
//! at a goal. With P(loss) the probability of being lost before the goal and C a charge for a loss in steps, [`bounded`] minimises
//!
//! G = E\[steps\] + C P(loss) subject to P(loss) ≤ Δ.
//!
//! The charge is the steps left of the mission: without it a loss would save steps, and the cheapest plan would leave the map. Loss is
//! absorbing, so P(loss) is the expectation of an indicator and nothing is lost to Boole's inequality.
//!
//! # Method
//! For a multiplier λ ≥ 0 the problem without the constraint, min E\[steps\] + (C + λ) P(loss), is a stochastic shortest path with a price
//! C + λ of a loss ([`Process::solve`]). Its least cost less λ Δ is a lower bound of G for every λ (weak duality). Multipliers come from a
//! fixed grid, so that equal questions have equal answers. A bracket of two of them, one whose policy breaks the bound and one
//! whose policy keeps it, is narrowed until the gap is small; at the kink the two policies are mixed: one is drawn once, and followed.
//!
//! # What is certified
//! No bound depends on how values were found. Let c be the least steps of a hop, above 0.
//! - **Steps and risk of a policy** ([`PolicyBounds`]). With residuals of at most δ and h = s (1 + 10⁻⁶) / c, for which h − P h ≥ 1, the
//!   values r + δ h are a super-solution, and r − δ h a sub-solution. A super-solution U ≥ P U + loss bounds the probability of loss from above,
//!   whatever the policy, and makes induction over hops work: whoever has the budget U(x) and hops by the policy has the budget U(x′)
//!   where it lands, and the expectation of that is at most U(x). h exists only if the policy is proper.
//! - **The least cost** ([`Solved::least_cost`]). If J exceeds the value of no hop by more than ε, then J c / (c + ε) is a sub-solution, and bounds from
//!   below what any policy costs.
//! - **The least risk** ([`least_risk`]) is 1 − max P(goal). End components, in which a policy can stay for ever, are merged first, without which
//!   an iteration from above would end too early. The least P(loss) alone would be met by never arriving.
//!
//! Rounding is part of each bound. Ground from which no chain of hops leads to a goal counts as lost: whoever lands there cannot arrive.
//!
//! ```
//! use solver::risk::{Process, Question, RiskBound, bounded};
//! use solver::{GridWorld, Kind, Leaving, Rules, Site, Soil};
//!
//! let hard = Soil { intended: 0.9, stuck: 0.0, sideways: 0.05, wait: 0.0 };
//! let rules = Rules { discount: 0.99, loss: 0.0, leaving: Leaving::Loses, soils: vec![hard] };
//! let mut world = GridWorld::new(7, 7, rules)?;
//! world.set(3 * 7 + 6, Site { kind: Kind::Goal, ..world.site(0) });
//! let process = Process::of_grid(&world);
//! let question = Question { node: 3 * 7, bound: RiskBound::new(0.06)?, charge: 300.0 };
//! let plan = bounded(&process, &question, &|| ()).expect("the goal can be reached");
//! assert!(plan.is_feasible() && plan.risk <= 0.06);
//! assert!(plan.lower_bound <= plan.cost && plan.gap() <= 1e-4 * plan.cost);
//! # Ok::<(), solver::Error>(())
//! ```

mod bounds;
mod least;
mod process;
mod search;
mod solve;

pub use bounds::PolicyBounds;
pub use least::{LeastRisk, least_risk};
pub use process::{Ends, Landing, Process};
pub use search::{BoundedPlan, Part, Question, RiskBound, bounded};
pub use solve::Solved;
