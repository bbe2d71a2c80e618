//! The names that planners are asked for by.

use contract::Name;

pub(crate) const MDP: &str = "mdp";
pub(crate) const GREEDY: &str = "greedy";
pub(crate) const ASTAR: &str = "astar";
pub(crate) const DSTAR_LITE: &str = "dstar_lite";
pub(crate) const HOLD: &str = "hold";
pub(crate) const RRT_STAR: &str = "rrt_star";
pub(crate) const RRT_STAR_ETT: &str = "rrt_star_ett";
pub(crate) const ETT_EXACT: &str = "ett_exact";
pub(crate) const SCOUT_ROUTE: &str = "scout_route";
pub(crate) const RRT_STAR_IT: &str = "rrt_star_it";
pub(crate) const SCOUT_VALUE: &str = "scout_value";
pub(crate) const SCOUT_AHEAD: &str = "scout_ahead";

/// The planner that sees the whole ground. No process can run it, so it is not in the table.
pub const CLAIRVOYANT: &str = "clairvoyant";

/// A planner's name as a [`Name`].
pub(crate) fn name(text: &'static str) -> Name {
    text.parse().expect("the names of algorithms are short and printable")
}
