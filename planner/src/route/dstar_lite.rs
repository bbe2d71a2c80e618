//! D* Lite (Koenig & Likhachev 2002): an incremental search from the goal, repaired as the map grows.
//!
//! g(x) is the cost from x to the goal as far as settled, rhs(x) = min over hops of cost + g; a cell
//! whose two differ waits in a queue under the key (min(g, rhs) + bound to the hopper + k_m, min(g,
//! rhs)). A landing moves the hopper: k_m grows by the bound on the distance, so that old keys stay lower
//! bounds. Changed costs reopen the cells that the hops leave from.
//!
//! # Why it obeys the law of planners
//! A search is over when no key is below the hopper's and the hopper's own g and rhs agree. A
//! neighbour n with cost + g(n), or rhs(n), up to g(hopper) would have a key below the hopper's if it
//! were unsettled: the bound is at most the cost, and min(g, rhs) < g(hopper). So all neighbours that
//! could begin a cheapest route are settled, with their true cost; costs are integers, so that cost has
//! one value however it was computed; and the hop taken is the first of north, east, south, west among
//! them. So it is a function of the graph alone, whatever the history of the queue.
//!
//! A repaired search differs from a new one only in the number of expansions. A budget bounds that number, so under a
//! budget every search is new.

use std::collections::BTreeSet;

use contract::{Action, Cell, Direction, Grid, Name};

use super::costs::{Costs, FORBIDDEN, at_least};
use super::{Found, Search};
use crate::names;
use crate::plan::{Budget, Plan, PlanStatus, Planner, Situation};

/// Plans the cheapest route by D* Lite. Work is counted in expansions, and depends on the search kept from the last plan;
/// a plan cut short holds.
#[derive(Clone, Debug, Default)]
pub struct DStarLite {
    kept: Option<IncrementalSearch>,
}

impl Planner for DStarLite {
    fn name(&self) -> Name {
        names::name(names::DSTAR_LITE)
    }

    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        let (here, leg) = (situation.state.pose.cell, situation.leg());
        if here == leg.goal {
            return Plan::at_once(Action::Hold, PlanStatus::Solved);
        }
        let connected = leg.grid.on_same_lattice(here, leg.goal);
        if !connected || !leg.grid.contains(here) || !leg.grid.contains(leg.goal) {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        }
        let costs = Costs::new(situation);
        let actions = costs.actions;
        if budget.work_max.is_some() {
            self.kept = None;
            let (search, expansions) = IncrementalSearch::new(costs, leg.grid, here, leg.goal).search(budget);
            return search.plan(expansions, &actions);
        }
        let kept = self.kept.take().filter(|kept| kept.continues(&costs, &leg.grid, leg.goal));
        let search = match kept {
            Some(mut kept) => {
                kept.repair(here, costs);
                kept
            }
            None => IncrementalSearch::new(costs, leg.grid, here, leg.goal),
        };
        let (found, expansions) = self.kept.insert(search).search(budget);
        found.plan(expansions, &actions)
    }
}

/// A search that can be repaired.
#[derive(Clone, Debug)]
pub struct IncrementalSearch {
    costs: Costs,
    grid: Grid,
    here: Cell,
    goal: Cell,
    /// g of each cell.
    settled: Vec<u64>,
    /// rhs of each cell.
    ahead: Vec<u64>,
    /// Key of each cell in the queue.
    keys: Vec<Option<(u64, u64)>>,
    queue: BTreeSet<((u64, u64), usize)>,
    /// k_m, the sum of the bounds on the hopper's moves.
    offset: u64,
}

impl IncrementalSearch {
    /// A new search: no cell is settled, and the goal is in the queue. `here` and `goal` lie on the grid.
    #[must_use]
    pub fn new(costs: Costs, grid: Grid, here: Cell, goal: Cell) -> Self {
        let cells = grid.cells();
        let mut search = Self {
            costs,
            grid,
            here,
            goal,
            settled: vec![FORBIDDEN; cells],
            ahead: vec![FORBIDDEN; cells],
            keys: vec![None; cells],
            queue: BTreeSet::new(),
            offset: 0,
        };
        let index = search.index(goal);
        search.ahead[index] = 0;
        search.requeue(index);
        search
    }

    /// Whether the search can be repaired into one over `costs` for `goal`.
    #[must_use]
    pub fn continues(&self, costs: &Costs, grid: &Grid, goal: Cell) -> bool {
        self.costs.comparable(costs) && self.grid == *grid && self.goal == goal
    }

    /// Repairs the search for a hopper at `here` and hops that cost `costs`.
    pub fn repair(&mut self, here: Cell, costs: Costs) {
        self.offset = self.offset.saturating_add(at_least(&self.grid, self.costs.cheapest, self.here, here));
        self.here = here;
        let before = std::mem::replace(&mut self.costs, costs);
        for index in 0..before.hops.len() {
            if before.hops[index] != self.costs.hops[index] {
                self.update(index);
            }
        }
    }

    /// Settles the cells that the hop from here depends on, within `budget`, counted in expansions.
    pub fn search(&mut self, budget: &Budget) -> (Search, u64) {
        let here = self.index(self.here);
        let mut expansions = 0;
        while let Some(&(key, index)) = self.queue.first() {
            if key >= self.key(here) && self.settled[here] == self.ahead[here] {
                break;
            }
            if budget.work_max == Some(expansions) {
                return (Search::Cut, expansions);
            }
            expansions += 1;
            budget.pulse.count(expansions);
            self.expand(key, index);
        }
        (self.found(here), expansions)
    }

    fn found(&self, here: usize) -> Search {
        let cost = self.settled[here];
        if cost == FORBIDDEN {
            return Search::NoRoute;
        }
        let direction = Direction::ALL.into_iter().find(|&direction| self.through(here, direction) == cost);
        Search::Found(Found { direction: direction.expect("a settled cell has a best hop"), cost })
    }

    fn expand(&mut self, key: (u64, u64), index: usize) {
        if key < self.key(index) {
            // Its key dates from an earlier position of the hopper.
            self.requeue(index);
            return;
        }
        if self.settled[index] > self.ahead[index] {
            self.settled[index] = self.ahead[index];
            self.requeue(index);
        } else {
            self.settled[index] = FORBIDDEN;
            self.update(index);
        }
        let cell = self.grid.cell(index);
        for direction in Direction::ALL {
            if let Some(before) = self.grid.index(self.grid.hop(cell, direction)) {
                self.update(before);
            }
        }
    }

    /// Recomputes rhs of a cell.
    fn update(&mut self, index: usize) {
        if index != self.index(self.goal) {
            self.ahead[index] = Direction::ALL
                .map(|direction| self.through(index, direction))
                .into_iter()
                .fold(FORBIDDEN, u64::min);
        }
        self.requeue(index);
    }

    /// Cost to the goal by a hop from a cell, as far as settled.
    fn through(&self, index: usize, direction: Direction) -> u64 {
        let hop = self.costs.hops[index][direction as usize];
        if hop == FORBIDDEN {
            return FORBIDDEN;
        }
        let to = self.grid.hop(self.grid.cell(index), direction);
        hop.saturating_add(self.settled[self.index(to)])
    }

    /// Puts a cell into the queue under its present key, or takes it out if it is settled.
    fn requeue(&mut self, index: usize) {
        if let Some(key) = self.keys[index].take() {
            self.queue.remove(&(key, index));
        }
        if self.settled[index] != self.ahead[index] {
            let key = self.key(index);
            self.keys[index] = Some(key);
            self.queue.insert((key, index));
        }
    }

    fn key(&self, index: usize) -> (u64, u64) {
        let least = self.settled[index].min(self.ahead[index]);
        let bound = at_least(&self.grid, self.costs.cheapest, self.here, self.grid.cell(index));
        (least.saturating_add(bound).saturating_add(self.offset), least)
    }

    fn index(&self, cell: Cell) -> usize {
        self.grid.index(cell).expect("a search stays on the map")
    }
}
