//! Planners that search for a route of least expected cost, as if every hop had one landing (P23 section V).
//!
//! Both search the same graph, [`Costs`], with exact integer costs, and answer with the same rule: the
//! first of north, east, south, west that begins some cheapest route. That hop is a property of the
//! graph, not of the search, so [`AStar`] and [`DStarLite`] always decide alike, and what
//! [`DStarLite`] keeps between decisions cannot change an answer.
//!
//! In unknown terrain they replan at each landing over what is believed by then. Slips are priced (a
//! hop that seldom succeeds is dear) and otherwise ignored: no route minds the edge of the map.
//! Treasures are no part of a route's cost: these planners collect only what lies on their way.

pub mod astar;
pub mod costs;
pub mod dstar_lite;

pub use astar::AStar;
pub use costs::Costs;
pub use dstar_lite::DStarLite;

use contract::{Action, Direction};

use crate::{Plan, PlanStatus};

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
    /// With a cheapest route.
    Found(Found),
    /// With the certainty that there is none.
    NoRoute,
    /// With its budget.
    Cut,
}

impl Search {
    /// The plan it comes to, after so many expansions. Without a hop known to be best it holds.
    #[must_use]
    pub fn plan(self, expansions: u64) -> Plan {
        let (action, status) = match self {
            Search::Found(found) => (Action::Hop(found.direction), PlanStatus::Solved),
            Search::NoRoute => (Action::Hold, PlanStatus::Infeasible),
            Search::Cut => (Action::Hold, PlanStatus::Cut),
        };
        Plan { work: expansions, ..Plan::at_once(action, status) }
    }
}
