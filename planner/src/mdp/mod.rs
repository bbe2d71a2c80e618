//! The planner that solves the grid world as a Markov decision process before every hop (P23 section III).

pub mod cold;
pub mod model;
pub mod policy;
pub mod session;
pub mod treasures;

use std::cell::RefCell;

use contract::{Action, Name, PolicyCell};
use solver::online::How;

use self::cold::Cold;
use self::model::Model;
use self::session::Session;
use self::treasures::Treasures;
use crate::{Budget, Plan, PlanStatus, Planner, Pulse, Situation, algorithm};

/// The best hop from where the hopper stands, by [`session`]: work is counted in backups of a cell, and
/// what is left of the last decision saves most of it.
///
/// A budget needs an answer that repeats whatever was known before, so under one the values are solved
/// from nothing, and work is counted in sweeps. It cuts between sweeps: the plan is then the best hop
/// under the values so far, and its residual tells how far they are from solved.
///
/// If no chain of hops leads to the goal over ground not known to be impassable, the plan is infeasible,
/// and the action is to hold: what is known cannot become passable again, and standing still is safe.
///
/// Known treasures are planned for by [`treasures`], one model for each set of them, each from nothing.
#[derive(Clone, Debug, Default)]
pub struct Mdp {
    /// The session, asked for a policy long after the plan.
    session: RefCell<Option<Session>>,
    /// Whether the last plan is the session's.
    in_session: bool,
    model: Option<Model>,
    solver: Cold,
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
        self.in_session = false;
        if here == situation.brief.goal {
            return Plan::at_once(Action::Hold, PlanStatus::Solved);
        }
        if budget.work_max.is_none() && situation.map.treasures().is_empty() {
            return self.plan_in_session(situation, budget.pulse);
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
        if self.in_session {
            return self.session.borrow_mut().as_mut().map(Session::policy);
        }
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

impl Mdp {
    /// Plans by the session.
    fn plan_in_session(&mut self, situation: &Situation<'_>, pulse: Pulse<'_>) -> Plan {
        let Situation { brief, map, state } = *situation;
        let slot = self.session.get_mut();
        match slot.as_mut().filter(|session| session.is_of(brief)) {
            Some(session) => session.follow(map),
            None => *slot = Some(Session::new(brief, map)),
        }
        let session = slot.as_mut().expect("made just now, if there was none");
        // Off the goal's lattice there is no decision, where no goal can be reached no hop.
        let decision = session.act(state.pose.cell, pulse);
        let Some((decision, hop)) = decision.and_then(|decision| Some((decision, decision.action?))) else {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        };
        let action = session::action(hop);
        self.in_session = true;
        // What is promised, not what was measured: that would tell how the decision was come by.
        let beyond = if decision.how == How::Canonical { decision.bound } else { 0.0 };
        let residual = solver::online::VALUE_ERROR.max(beyond) * (1.0 - brief.payoff.discount);
        Plan { action, status: PlanStatus::Solved, work: decision.work, residual }
    }
}
