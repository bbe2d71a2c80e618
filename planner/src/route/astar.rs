//! A*: a new search from the hopper to the goal before every hop.
//!
//! Cells are expanded in the order of (f, g, index), f = g + a consistent lower bound. The cells before
//! a cell on a cheapest route have no larger f and a smaller g (a hop costs something), so all of them
//! are expanded before it. When the goal is expanded, its set of first hops is therefore complete, and the first of north,
//! east, south, west among all cheapest routes is known.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use contract::{Action, Cell, Direction, Grid, Name};

use super::costs::{Costs, FORBIDDEN, at_least};
use super::{Found, Search};
use crate::names;
use crate::plan::{Budget, Plan, PlanStatus, Planner, Situation};

/// Plans the cheapest route by A*. Work is counted in expansions; a plan cut short holds.
#[derive(Clone, Copy, Debug, Default)]
pub struct AStar;

impl Planner for AStar {
    fn name(&self) -> Name {
        names::name(names::ASTAR)
    }

    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        let (here, leg) = (situation.state.pose.cell, situation.leg());
        if here == leg.goal {
            return Plan::at_once(Action::Hold, PlanStatus::Solved);
        }
        let costs = Costs::new(situation);
        let (search, expansions) = search(&costs, &leg.grid, here, leg.goal, budget);
        search.plan(expansions, &costs.actions)
    }
}

/// Searches for a cheapest route from `start` to another cell `goal` within `budget`, counted in expansions. Returns how
/// it ended, and the expansions made.
#[must_use]
pub fn search(costs: &Costs, grid: &Grid, start: Cell, goal: Cell, budget: &Budget) -> (Search, u64) {
    let (Some(first), Some(last)) = (grid.index(start), grid.index(goal)) else {
        return (Search::NoRoute, 0);
    };
    let bound = |cell: Cell| at_least(grid, costs.cheapest, cell, goal);
    // Cost from the start, and the first hops of the cheapest routes, a bit each.
    let mut reached = vec![(FORBIDDEN, 0_u8); grid.cells()];
    reached[first].0 = 0;
    let mut open = BinaryHeap::from([Reverse((bound(start), 0, first))]);
    let mut expansions = 0;
    while let Some(Reverse((_, cost, index))) = open.pop() {
        let (least, hops) = reached[index];
        if cost > least {
            continue;
        }
        if index == last {
            let direction = Direction::ALL[hops.trailing_zeros() as usize];
            return (Search::Found(Found { direction, cost }), expansions);
        }
        if budget.work_max == Some(expansions) {
            return (Search::Cut, expansions);
        }
        expansions += 1;
        budget.pulse.count(expansions);
        let cell = grid.cell(index);
        for direction in Direction::ALL {
            let hop = costs.hops[index][direction as usize];
            if hop == FORBIDDEN {
                continue;
            }
            let to = grid.hop(cell, direction);
            let next = grid.index(to).expect("hops off the map are forbidden");
            let sum = cost.saturating_add(hop);
            let first_hops = if index == first { 1 << direction as u8 } else { hops };
            if sum < reached[next].0 {
                reached[next] = (sum, first_hops);
                open.push(Reverse((sum.saturating_add(bound(to)), sum, next)));
            } else if sum == reached[next].0 {
                reached[next].1 |= first_hops;
            }
        }
    }
    (Search::NoRoute, expansions)
}
