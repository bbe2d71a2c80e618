//! The planner that solves the grid world as a Markov decision process before every hop (P23 section III).

pub mod model;
pub mod policy;
pub mod treasures;
pub mod value_iteration;

use contract::{Action, Name, PolicyCell};

use self::model::Model;
use self::treasures::Treasures;
use self::value_iteration::ValueIteration;
use crate::{Budget, Plan, PlanStatus, Planner, Situation, algorithm};

/// Value iteration over all cells, then the best hop from where the hopper stands.
///
/// Work is counted in sweeps. A budget cuts between sweeps: the plan is then the best hop under the
/// values so far, and its residual tells how far they are from solved. If no chain of hops leads to
/// the goal over ground not known to be impassable, the plan is infeasible, and the action is to
/// hold: what is known cannot become passable again, and standing still is safe.
///
/// Known treasures are planned for by [`treasures`], one model for each set of them.
///
/// Every solve starts cold; only buffers live from one to the next.
#[derive(Clone, Debug, Default)]
pub struct Mdp {
    model: Option<Model>,
    solver: ValueIteration,
    treasures: Treasures,
    /// Whether the model and the values belong to the last plan.
    solved: bool,
}

impl Planner for Mdp {
    fn name(&self) -> Name {
        algorithm::name("mdp")
    }

    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        let here = situation.state.pose.cell;
        self.solved = false;
        if here == situation.brief.goal {
            return Plan::at_once(Action::Hold, PlanStatus::Solved);
        }
        if let Some(model) = &mut self.model {
            model.rebuild(situation);
        }
        let model = self.model.get_or_insert_with(|| Model::new(situation));
        self.treasures.rebuild(situation, model);
        let Some(node) = model.node(here).filter(|&node| model.leads_to_goal(node)) else {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        };
        let solution = self.treasures.solve(model, &mut self.solver, budget);
        self.solved = true;
        Plan {
            action: policy::action(model, &self.solver.values, node),
            status: if solution.converged { PlanStatus::Solved } else { PlanStatus::Cut },
            work: solution.sweeps,
            residual: solution.residual,
        }
    }

    fn policy(&self) -> Option<Vec<PolicyCell>> {
        let model = self.model.as_ref().filter(|_| self.solved)?;
        let mut cells = policy::cells(model, &self.solver.values);
        for (cell, policy) in model.grid().iter().zip(&mut cells) {
            let onward = model.node(cell).and_then(|node| self.treasures.onward(node));
            if let Some((action, value)) = onward {
                *policy = PolicyCell { action, value };
            }
        }
        Some(cells)
    }
}
