//! Algorithms that search for a route of least expected cost, as if every hop had one landing (P23 section V).
//!
//! Both search the same graph, [`Costs`], with exact integer costs, and take the first of north, east, south, west that
//! begins some cheapest route. That hop is a property of the graph, not of the search, so [`AStar`] and [`DStarLite`]
//! always decide alike, and what [`DStarLite`] keeps between decisions cannot change an answer.
//!
//! They replan at each landing over the ground as believed by then. Slips enter the cost (a hop that rarely succeeds is
//! expensive) and are otherwise ignored: no route avoids the edge of the map because of them. Treasures have no part in
//! a route's cost, so these algorithms collect only those on their way.

pub mod astar;
pub mod costs;
pub mod dstar_lite;

pub use astar::AStar;
pub use costs::Costs;
pub use dstar_lite::DStarLite;

use contract::{Action, Direction};

use crate::plan::{Plan, PlanStatus};

/// What a search found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// First hop of a cheapest route; the first of north, east, south, west among equals.
    pub direction: Direction,
    /// Expected cost of the route in millionths of a step.
    pub cost: u64,
}

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// Found a cheapest route.
    Found(Found),
    /// Proved that there is none.
    NoRoute,
    /// The budget ran out.
    Cut,
}

impl Search {
    /// The plan that follows, after `expansions` expansions, where `actions` are the hops from the hopper's cell. Without a known best
    /// hop it holds.
    #[must_use]
    pub fn plan(self, expansions: u64, actions: &[Action; 4]) -> Plan {
        let (action, status) = match self {
            Search::Found(found) => (actions[found.direction as usize], PlanStatus::Solved),
            Search::NoRoute => (Action::Hold, PlanStatus::Infeasible),
            Search::Cut => (Action::Hold, PlanStatus::Cut),
        };
        Plan { work: expansions, ..Plan::at_once(action, status) }
    }
}
