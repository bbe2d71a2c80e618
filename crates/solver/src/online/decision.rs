//! The answer to "where to?", and how it was come by.

use crate::Hop;

/// How a decision was proven.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum How {
    /// By bounds around the hopper.
    Focused,
    /// By values brought back to the certificate everywhere.
    Warm,
    /// By a solve from nothing.
    Canonical,
}

/// What kind of answer a decision is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The canonical hop.
    Solved,
    /// The budget ran out: the best hop so far.
    Cut,
    /// No chain of hops leads from here to a goal: there is no hop to take.
    Infeasible,
}

/// The answer to "where to?".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// The hop; `None` at a goal, where lost, and where no goal can be reached.
    pub action: Option<Hop>,
    /// By how much it is certainly better than any other, in units of payoff. Negative if another may be
    /// better by as much: at most [`choice::TIE`] where solved, but for the width of the bounds.
    pub margin: f64,
    /// Bound on the error of the values decided by, in units of payoff.
    pub bound: f64,
    /// What kind of answer it is.
    pub status: Status,
    /// Work done, in backups of a node.
    pub work: u64,
    /// How it was proven.
    pub how: How,
}
