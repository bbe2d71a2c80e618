//! The grid world of a hopper whose hops land by a motion table ([`contract::MotionTable`]).
//!
//! It is the process of [`super::model`] with the landings of the table in place of the four branches: class by soil and slopes
//! ([`motion::slope_classes`]), landings off the map and on impassable ground as there, a hop from sand over two periods, and what a row
//! leaves of 1 lost. It is solved from nothing to [`CANONICAL_ERROR`] with the certificate of [`solver::landings`]. Treasures are not
//! planned for.

use contract::{Action, Cell, MotionTable, PolicyCell, Profile, Soil, Vetoed};
use solver::landings::{Landing, LandingTable, Row, TableRules, TableSite, TableWorld, action_values, solve};
use solver::online::choice::{CANONICAL_ERROR, TIE};
use solver::{Effort, Hop, Kind, Leaving, Solution};

use super::hop_lattice::HopLattice;
use crate::belief::Belief;
use crate::payoff::LandingPayoff;
use crate::plan::{Budget, Situation};
use crate::tie::first_best_allowed;

/// The process of one situation with what it was solved to.
#[derive(Clone, Debug)]
pub struct TableModel {
    lattice: HopLattice,
    world: TableWorld,
    values: Vec<f64>,
    /// The bound on the error of its values, once it is solved to the end.
    error_bound: Option<f64>,
}

impl TableModel {
    /// The process of `situation` under `table`, not solved yet.
    ///
    /// # Panics
    /// If the brief's numbers are out of range: they are checked where a brief enters a process.
    #[must_use]
    pub fn new(situation: &Situation<'_>, table: &MotionTable) -> Self {
        let (leg, map) = (situation.leg(), situation.map);
        let (lattice, belief, payoff) =
            (HopLattice::new(leg), Belief::new(leg, map), LandingPayoff::new(leg));
        let mut classes = Classes::new(table);
        let site = |node| {
            let cell = lattice.cell(node);
            let ground = belief.ground(cell);
            let kind = match ground.passable {
                _ if cell == leg.goal => Kind::Goal,
                true => Kind::Free,
                false => Kind::Lost,
            };
            let known = |cell| map.ground(cell);
            let classes =
                motion::slope_classes(&leg.grid, (cell, ground), known).map(|class| classes.row(class));
            TableSite { kind, payoff: payoff.of(cell, ground), classes }
        };
        let sites: Vec<TableSite> = (0..lattice.nodes()).map(site).collect();
        let payoffs = sites.iter().filter(|site| site.kind != Kind::Lost).map(|site| site.payoff);
        let leaving = match (leg.profile, leg.reading.leaving) {
            (Profile::Paper2023, None) => Leaving::Stays,
            (Profile::Paper2023, Some(_)) | (Profile::Hopper | Profile::Paper2022, _) => Leaving::Loses,
        };
        let loss = super::model::loss(leg, payoffs.fold(0.0, f64::min));
        let rules = TableRules { discount: leg.payoff.discount, loss, leaving };
        let checked = "brief and table are checked where they enter a process";
        let table = LandingTable::new(classes.rows).expect(checked);
        let mut world = TableWorld::new(lattice.width, lattice.height, rules, table).expect(checked);
        for (node, site) in sites.into_iter().enumerate() {
            world.set(node, site);
        }
        Self { lattice, world, values: Vec::new(), error_bound: None }
    }

    /// Whether it is solved to the end and is the process of `other`.
    #[must_use]
    pub fn is_solved_as(&self, other: &Self) -> bool {
        self.error_bound.is_some() && self.world == other.world
    }

    /// The bound on the error of its values; infinite before it is solved.
    #[must_use]
    pub fn error_bound(&self) -> f64 {
        self.error_bound.unwrap_or(f64::INFINITY)
    }

    /// Whether some chain of hops may lead from `cell` to the goal.
    #[must_use]
    pub fn leads_to_goal(&self, cell: Cell) -> bool {
        let Some(start) = self.lattice.node(cell) else { return false };
        let mut is_met = vec![false; self.world.nodes()];
        let mut ahead = vec![start];
        is_met[start] = true;
        while let Some(node) = ahead.pop() {
            match self.world.kind(node) {
                Kind::Goal => return true,
                Kind::Lost if node != start => continue,
                Kind::Lost | Kind::Free => {}
            }
            for (hop, class) in Hop::ALL.into_iter().zip(self.world.classes(node)) {
                let landings = &self.world.table().rows()[usize::from(class)].landings;
                for landing in landings.iter().filter(|landing| landing.probability > 0.0) {
                    let to = self.world.landing(node, hop, landing.forward, landing.left);
                    if let Some(to) = to.filter(|to| !is_met[*to]) {
                        is_met[to] = true;
                        ahead.push(to);
                    }
                }
            }
        }
        false
    }

    /// Solves the process from nothing. Work is counted in sweeps that choose hops.
    pub fn solve(&mut self, budget: &Budget<'_>) -> Solution {
        let sweeps_max = budget.work_max.unwrap_or(u64::MAX);
        let (values, solution) = solve(&self.world, &Effort { error_max: CANONICAL_ERROR, sweeps_max });
        budget.pulse.beat();
        self.values = values;
        let is_whole = solution.status != solver::SolveStatus::Cut;
        self.error_bound = is_whole.then_some(solution.certificate.error_bound);
        solution
    }

    /// The best action from `cell` among those that are not `vetoed`.
    #[must_use]
    pub fn action(&self, cell: Cell, vetoed: Vetoed) -> Action {
        let Some(node) = self.lattice.node(cell) else { return Action::Hold };
        // The solver's hops are in the order of the contract's directions.
        let values = action_values(&self.world, &self.values, node).map(Some);
        first_best_allowed(values, TIE, vetoed).map_or(Action::Hold, Action::Hop)
    }

    /// Action and value of every cell of the grid in index order; hold and 0 off the hop lattice.
    #[must_use]
    pub fn policy(&self) -> Vec<PolicyCell> {
        let policy_cell = |cell| match self.lattice.node(cell) {
            Some(node) => {
                let is_free = self.world.kind(node) == Kind::Free;
                let action = if is_free { self.action(cell, Vetoed::NONE) } else { Action::Hold };
                PolicyCell { action, value: self.values[node] }
            }
            None => PolicyCell { action: Action::Hold, value: 0.0 },
        };
        self.lattice.grid.iter().map(policy_cell).collect()
    }
}

/// The rows that a map needs of the table, which are few of all.
struct Classes<'a> {
    table: &'a MotionTable,
    /// Number of each class among `rows`, once it is there.
    numbers: Vec<Option<u16>>,
    rows: Vec<Row>,
}

impl<'a> Classes<'a> {
    fn new(table: &'a MotionTable) -> Self {
        Self { table, numbers: vec![None; MotionTable::ROWS], rows: Vec::new() }
    }

    fn row(&mut self, class: usize) -> u16 {
        if let Some(number) = self.numbers[class] {
            return number;
        }
        let landings = self.table.rows()[class].landings().iter();
        let landings =
            landings.map(|at| Landing { forward: at.forward, left: at.left, probability: at.probability });
        // A hop from sand takes two periods.
        let waits = MotionTable::soil_of(class) == Soil::Sand;
        self.rows.push(Row { landings: landings.collect(), waits });
        let number = (self.rows.len() - 1) as u16;
        self.numbers[class] = Some(number);
        number
    }
}
