//! The names that algorithms are asked for by.

use contract::Name;

/// Every algorithm that a planner process can run.
pub const ALGORITHMS: &[&str] = &[MDP, GREEDY, ASTAR, DSTAR_LITE, HOLD];

pub(crate) const MDP: &str = "mdp";
pub(crate) const GREEDY: &str = "greedy";
pub(crate) const ASTAR: &str = "astar";
pub(crate) const DSTAR_LITE: &str = "dstar_lite";
pub(crate) const HOLD: &str = "hold";

/// The planner that sees the whole ground. No process can run it, so it is not one of [`ALGORITHMS`].
pub const CLAIRVOYANT: &str = "clairvoyant";

/// One of the names above as a [`Name`].
pub(crate) fn name(text: &'static str) -> Name {
    text.parse().expect("the names of algorithms are short and printable")
}
