//! Treasures that pay once: one model for each set of treasures still to collect.
//!
//! With S the known treasures not yet collected, V_S the values while they remain, and R the payoff of a treasure, the
//! afterstate value of landing on t ∈ S is r(t) + R + V_{S∖t}(t): in the model of S the treasure is a goal with that
//! payoff. The sets are solved from the empty one upwards, each needing only values of smaller ones, so 2^|S| models
//! give the exact optimum of the process whose state is (cell, S). If the payoff stayed on the map, hopping to and fro
//! over a treasure for ever would be optimal.
//!
//! With more than [`EXACT_MAX`] treasures known, the nearest are planned for until one of them is collected.

use contract::{Action, Cell};
use solver::online::choice::CANONICAL_ERROR;
use solver::{Effort, GridWorld, Kind, Site, Solver};

use super::model::Model;
use super::policy;
use crate::plan::{Budget, Situation};

/// Most treasures that are planned for at once: 16 models.
pub const EXACT_MAX: usize = 4;

/// The treasures planned for in one situation, and the solutions of their subsets.
#[derive(Clone, Debug, Default)]
pub struct TreasureSets {
    /// Their nodes, at most [`EXACT_MAX`].
    nodes: Vec<usize>,
    /// Payoff R of collecting a treasure.
    payoff: f64,
    /// Payoffs r of landing on their cells, without treasures.
    landing: Vec<f64>,
    /// For each solved set (one bit per treasure), the value at each treasure's node while exactly that set is left.
    after: Vec<Vec<f64>>,
    /// The action on each treasure's node once it is collected and all others are left.
    onward: Vec<Action>,
}

/// How the solves of all sets ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreasureSolution {
    /// Sweeps over all nodes, of all sets together.
    pub sweeps: u64,
    /// Bound |V − V*| on the values of the last world, in units of payoff: its own, plus the largest of the sets whose
    /// values its treasures pay, since an error of a payoff changes no value by more.
    pub error_bound: f64,
    /// Whether the model of every set is solved.
    pub converged: bool,
}

impl TreasureSets {
    /// Chooses the treasures of `situation` to plan for, each of which pays `payoff`: the nearest first, ties in index
    /// order.
    pub fn rebuild(&mut self, situation: &Situation<'_>, model: &Model, payoff: f64) {
        let here = situation.state.pose.cell;
        let mut cells: Vec<Cell> = situation.map.treasures().to_vec();
        // A stable sort, so that ties stay in index order.
        cells.sort_by(|a, b| a.distance_cells(here).total_cmp(&b.distance_cells(here)));
        self.nodes.clear();
        let Model { lattice, world } = model;
        let free = |node: &usize| world.kind(*node) == Kind::Free;
        self.nodes
            .extend(cells.into_iter().filter_map(|cell| lattice.node(cell)).filter(free).take(EXACT_MAX));
        self.payoff = payoff;
        self.landing.clear();
        self.landing.extend(self.nodes.iter().map(|&node| world.payoff(node)));
        self.after.clear();
        self.onward.clear();
        self.onward.resize(self.nodes.len(), Action::Hold);
    }

    /// Solves the models of all sets, each to [`CANONICAL_ERROR`] or the limit of floating point, within `budget`, counted
    /// in sweeps of all sets together. `world` comes without treasures and ends with all of them, and `solver` holds its
    /// values.
    pub fn solve(&mut self, world: &mut GridWorld, solver: &mut Solver, budget: &Budget) -> TreasureSolution {
        let all = (1_usize << self.nodes.len()) - 1;
        let mut total = TreasureSolution { sweeps: 0, error_bound: 0.0, converged: true };
        let mut bounds = Vec::with_capacity(all + 1);
        for set in 0..=all {
            self.place(world, set);
            let sweeps_max = budget.work_max.map_or(u64::MAX, |most| most - total.sweeps);
            let effort = Effort { error_max: CANONICAL_ERROR, sweeps_max };
            let solution = solver.solve_with(world, &effort, &|| budget.pulse.beat());
            total.sweeps += solution.sweeps;
            let smaller = (0..self.nodes.len()).filter(|number| set & (1 << number) != 0);
            let passed_on = smaller.map(|number| bounds[set & !(1 << number)]).fold(0.0, f64::max);
            total.error_bound = solution.certificate.error_bound + passed_on;
            bounds.push(total.error_bound);
            total.converged &= solution.status.is_converged();
            let values = solver.values();
            self.after.push(self.nodes.iter().map(|&node| values[node]).collect());
            for (number, &node) in self.nodes.iter().enumerate() {
                if set == all & !(1 << number) {
                    self.onward[number] = policy::action(world, values, node);
                }
            }
        }
        total
    }

    /// Action and value on `node` of the last world if a treasure lies there: those after collecting it.
    #[must_use]
    pub fn onward(&self, node: usize) -> Option<(Action, f64)> {
        let number = self.nodes.iter().position(|treasure| *treasure == node)?;
        let rest = ((1 << self.nodes.len()) - 1) & !(1 << number);
        Some((self.onward[number], self.after.get(rest)?[number]))
    }

    /// Turns `world` into the model of `set`.
    fn place(&self, world: &mut GridWorld, set: usize) {
        for (number, (&node, &landing)) in self.nodes.iter().zip(&self.landing).enumerate() {
            let (kind, payoff) = match set & (1 << number) != 0 {
                true => (Kind::Goal, landing + self.payoff + self.after[set & !(1 << number)][number]),
                false => (Kind::Free, landing),
            };
            world.set(node, Site { kind, payoff, ..world.site(node) });
        }
    }
}
