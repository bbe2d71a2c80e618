//! The answer of the online solver: the hop, and how it was proven.

use crate::Hop;

/// How a decision was proven, the cheapest method first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Method {
    /// By bounds around the hopper.
    Focused,
    /// By values converged to the certificate everywhere.
    Warm,
    /// By a solve from nothing.
    Canonical,
}

/// Whether a decision is final.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecisionStatus {
    /// The hop is the canonical one.
    Solved,
    /// The budget ran out; the hop is the best so far.
    Cut,
    /// No chain of hops leads from here to a goal: there is no hop to take.
    Infeasible,
}

/// The hop to take from a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HopDecision {
    /// The hop; `None` at a goal, where lost, and where no goal can be reached.
    pub action: Option<Hop>,
    /// How much better than any other hop it is at least, in units of payoff. Negative if another may be better by as
    /// much: at most [`TIE`](super::choice::TIE) where solved, apart from the width of the bounds.
    pub margin: f64,
    /// Bound on the error of the values behind the decision, in units of payoff.
    pub bound: f64,
    /// Whether the decision is final.
    pub status: DecisionStatus,
    /// Work done, in Bellman backups of a node.
    pub work: u64,
    /// How it was proven.
    pub method: Method,
}
