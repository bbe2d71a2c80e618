//! The paper's step count, as deduced from its tables.

use contract::{Action, Branch, Soil};

/// Steps that an action from `soil` costs: a hop 2 (observe, hop); 3 from sand if the intended move
/// succeeds, which takes two half hops there; standing still 1.
#[must_use]
pub fn steps(soil: Soil, action: Action, branch: Branch) -> u64 {
    match (action, soil, branch) {
        (Action::Hold, _, _) => 1,
        (Action::Hop(_), Soil::Sand, Branch::Intended) => 3,
        (Action::Hop(_), _, _) => 2,
    }
}
