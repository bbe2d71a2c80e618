//! The step count of Sakamoto & Kunii 2023, as deduced from its tables.

use contract::{Action, Branch, Soil};

/// Steps that an action from `soil` costs: 2 for a hop (observe, hop), 3 for a hop from sand that lands as intended (it
/// takes two half hops there), 1 for standing still.
#[must_use]
pub fn steps(soil: Soil, action: Action, branch: Branch) -> u64 {
    match (action, soil, branch) {
        (Action::Hop(_) | Action::Up(_), Soil::Sand, Branch::Intended) => 3,
        (Action::Hop(_) | Action::Up(_), _, _) => 2,
        // All others but to hold are those of other robots, and not counted by the paper.
        _ => 1,
    }
}
