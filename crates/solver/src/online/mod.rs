//! Decisions while the map grows: after each landing a few nodes change, and the next hop is wanted.
//!
//! An [`OnlineSolver`] holds a world and what is known of its values. [`OnlineSolver::update`] takes in a changed
//! node; [`OnlineSolver::act`] decides at a node, by the cheapest method that proves its answer:
//!
//! - **focused** ([`Method::Focused`]): values are updated around the hopper and ahead of it, and bounded behind it;
//! - **warm** ([`Method::Warm`]): all values are updated, from where they were, until they satisfy the certificate;
//! - **canonical** ([`Method::Canonical`]): the world is solved from nothing.
//!
//! The method shows in the [`HopDecision`] and in its work, but never in its hop: see [`choice`].
//!
//! The first values of a world come from the cold solver, or, on a map of which hardly anything has been seen, from
//! the relaxation itself: see `unseen`.
//!
//! # Terms
//! - **Field**: one afterstate value per node. **Ring, sector, level, row, block**: where nodes lie, see `rings`.
//! - **Marked** block: one whose residuals are not known to be within the tolerance, see `relaxation`.
//!   **Converged**: nothing is marked.
//! - **Frozen** levels are far behind the hopper and are not updated; nearer ones are **clear**.
//!
//! # Warm
//! See `relaxation`: once nothing is marked, every residual |V − TV| is at most a tolerance τ, so
//! |V − V*| ≤ τ / (1 − γ), as after a full sweep. Only nodes that a change reaches are visited: the cone of nodes whose
//! way leads through the change, on its far side as seen from the goal, which may be most of the map. If that takes
//! too long, the canonical procedure decides, and the solver starts again from its values.
//!
//! # Focused
//! Nodes behind the hopper hardly matter to it: they come back into play only through slips, each of small
//! probability. But the answer must be proven. Let U be *super-harmonic* (TU ≤ U) and L *sub-harmonic* (TL ≥ L). T is
//! monotone and T^n U → V*, so L ≤ V* ≤ U. If the inequalities hold only to within τ, then
//! L − τ/(1−γ) ≤ V* ≤ U + τ/(1−γ), since T(U + c) = TU + γc. So two fields are kept, and the proof needs one
//! inequality per node.
//!
//! Nodes on levels from ℓ on are frozen. Freezing raises U by an offset S on **all** frozen nodes, and lowers L by as
//! much. U remains super-harmonic:
//!
//! - at a frozen node whose neighbours are frozen, T(U + S) = TU + γS ≤ U + S;
//! - at a node of level ℓ, with neighbours on the clear level ℓ − 1, all the more, since those were not raised;
//! - clear nodes are relaxed, given the raised level ℓ, until they converge again.
//!
//! So only the values of level ℓ need to change. On the levels beyond, the offset stands in the proof and in a table by
//! level; it is added to their values when these are read. The first offset leaves a slack of (1 − γ) S at every frozen
//! node. It covers nodes that had converged only at a coarse tolerance when they were frozen, and changes among frozen
//! nodes. A frozen node whose ground or neighbours have changed is measured, but not solved. Where TU ≤ U fails there,
//! another offset is added by the same argument, or, if it would have to be large, the frozen levels retreat beyond
//! the change. (A large offset is worse than none: hopping back among the frozen nodes would seem to pay more than
//! going on.) A retreat keeps the proof valid: a thawed level keeps its offset until it is relaxed. When the hopper has
//! moved on, levels nearer to it are frozen: raising all frozen nodes again, the newly frozen ones included, is the
//! same step as before.
//!
//! At the hopper, U − L is what is left of the offset after some slips in a row, and the hop values under U and L give
//! [`choice::Bounds`]. They only have to be close enough to tell the hops apart: the clear nodes converge at a coarse
//! tolerance first, and at finer ones (`tolerance::STAGES`) only while the bounds leave a doubt. If the finest leaves
//! one, the frozen levels retreat, then the solver falls back to the warm method, and then to the canonical procedure.
//!
//! # Rounding
//! Afterstate values and constants are kept within a magnitude M. To first order in u = 2⁻⁵³ the kernel's residual
//! carries at most 24 u M: six from the products of probabilities and discount, one from d q − 1, three from the base,
//! three from where a hop lands, three from the slips beside, weighted with at most one half, and two, three and three
//! from the sums of the base and what stays, of these and the slips, and of all. Where a soil's landings sum to 1 only
//! to within rounding, the kernel's slips differ from the given ones: at most eight more.
//! [`crate::certificate::rounding`] allows 32 u M, and is added to τ in every bound.

mod blocks;
pub mod choice;
mod decision;
mod dispatch;
mod enclosure;
mod goal_reachability;
mod kernel;
mod layout;
mod online_solver;
mod patterns;
mod relaxation;
mod rings;
mod tolerance;
mod unseen;

pub use decision::{DecisionStatus, HopDecision, Method};
pub use online_solver::OnlineSolver;
pub use tolerance::VALUE_ERROR;
