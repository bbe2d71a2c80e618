//! Treasures that pay once: one model for each set of treasures still to be collected.
//!
//! With S the known treasures not yet collected, V_S the values while they are, and R the payoff of a
//! treasure, landing on t ∈ S is worth r(t) + R + V_{S∖t}(t): in the model of S the treasure absorbs at
//! that price. The sets are solved from the empty one upwards, each asking only for values of smaller
//! ones, so 2^|S| models give the exact optimum of the process whose state is (cell, S). A payoff that
//! stayed on the map would be a different process, and a wrong one: it is optimal there to hop to and
//! fro over a treasure for ever.
//!
//! With more than [`EXACT_MAX`] treasures known, the nearest are planned for and the others wait until
//! one of those is collected.

use contract::{Action, Cell};

use super::cold::{Cold, Solution};
use super::model::{Model, Node};
use super::policy;
use crate::{Budget, Situation};

/// Most treasures that are planned for at once: 16 models.
pub const EXACT_MAX: usize = 4;

/// The known treasures under one situation, and what the smaller sets of them came to.
#[derive(Clone, Debug, Default)]
pub struct Treasures {
    /// Their nodes, at most [`EXACT_MAX`].
    nodes: Vec<usize>,
    /// What collecting a treasure pays by itself.
    payoff: f64,
    /// Payoffs of landing on their cells, treasures aside.
    landing: Vec<f64>,
    /// For each set that is solved (a bit for each treasure), the value at each treasure's node once
    /// exactly that set is left.
    after: Vec<Vec<f64>>,
    /// What to do on each treasure's node once it is collected and all others are left.
    onward: Vec<Action>,
}

impl Treasures {
    /// Those of `situation` that are planned for, nearest first, ties in index order.
    pub fn rebuild(&mut self, situation: &Situation<'_>, model: &Model) {
        let here = situation.state.pose.cell;
        let mut cells: Vec<Cell> = situation.map.treasures().to_vec();
        // Stable, so that equals stay in index order.
        cells.sort_by(|a, b| a.distance_cells(here).total_cmp(&b.distance_cells(here)));
        self.nodes.clear();
        let free = |node: &usize| model.nodes[*node] == Node::Free;
        self.nodes.extend(cells.into_iter().filter_map(|cell| model.node(cell)).filter(free).take(EXACT_MAX));
        self.payoff = situation.brief.payoff.treasure;
        self.landing.clear();
        self.landing.extend(self.nodes.iter().map(|&node| model.payoffs[node]));
        self.after.clear();
        self.onward.clear();
        self.onward.resize(self.nodes.len(), Action::Hold);
    }

    /// Solves the models of all sets within `budget`, counted in sweeps, for all of them together. `model` is
    /// that without treasures, and ends as that of all of them, with `solver` holding its values.
    pub fn solve(&mut self, model: &mut Model, solver: &mut Cold, budget: &Budget) -> Solution {
        let all = (1_usize << self.nodes.len()) - 1;
        let mut total = Solution { sweeps: 0, residual: 0.0, converged: true };
        for set in 0..=all {
            self.place(model, set);
            let left = budget.work_max.map(|most| most - total.sweeps);
            let solution = solver.solve(model, &Budget { work_max: left, ..*budget });
            total.sweeps += solution.sweeps;
            total.residual = total.residual.max(solution.residual);
            total.converged &= solution.converged;
            self.after.push(self.nodes.iter().map(|&node| solver.values[node]).collect());
            for (number, &node) in self.nodes.iter().enumerate() {
                if set == all & !(1 << number) {
                    self.onward[number] = policy::action(model, &solver.values, node);
                }
            }
        }
        total
    }

    /// What to do on `node` of the last model if it is a treasure's: go on as after collecting it.
    #[must_use]
    pub fn onward(&self, node: usize) -> Option<(Action, f64)> {
        let number = self.nodes.iter().position(|treasure| *treasure == node)?;
        let rest = ((1 << self.nodes.len()) - 1) & !(1 << number);
        Some((self.onward[number], self.after.get(rest)?[number]))
    }

    /// Makes `model` that of `set`.
    fn place(&self, model: &mut Model, set: usize) {
        for (number, (&node, &landing)) in self.nodes.iter().zip(&self.landing).enumerate() {
            let left = set & (1 << number) != 0;
            model.nodes[node] = if left { Node::Treasure } else { Node::Free };
            model.payoffs[node] = match left {
                true => landing + self.payoff + self.after[set & !(1 << number)][number],
                false => landing,
            };
        }
    }
}
