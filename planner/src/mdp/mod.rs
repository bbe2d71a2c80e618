//! The planner that solves the grid world as a Markov decision process before every hop (P23 section III).

pub mod lattice;
pub mod model;
pub mod policy;
pub mod session;
pub mod treasures;

use std::cell::RefCell;

use contract::{Action, Name, PolicyCell};
use solver::online::Method;
use solver::{GoalSearch, Solver};

use self::model::Model;
use self::session::Session;
use self::treasures::Treasures;
use crate::{Budget, Plan, PlanStatus, Planner, Pulse, Situation, algorithm};

/// The best hop from where the hopper stands, by [`session`]: work is counted in backups of a cell, and
/// what is left of the last decision saves most of it.
///
/// A budget needs an answer that repeats whatever was known before, so under one the values are solved
/// from nothing, and work is counted in sweeps. It cuts between sweeps: the plan is then the best hop
/// under the values so far, and its error bound tells how far they are from solved.
///
/// If no chain of hops leads to the goal over ground not known to be impassable, the plan is infeasible,
/// and the action is to hold: what is known cannot become passable again, and standing still is safe.
///
/// What the guard has vetoed where the hopper stands is not chosen again: the next best hop is, from values
/// solved from nothing by the session's canonical procedure, struck-out hops aside. So a veto of what the
/// session would not choose changes nothing, and costs nothing. The values themselves know of no guard; where
/// leaving the map and impassable ground are priced, as in profile `hopper`, there is little left to veto.
///
/// Known treasures are planned for by [`treasures`], one model for each set of them, each from nothing.
#[derive(Clone, Debug, Default)]
pub struct Mdp {
    /// The session, asked for a policy long after the plan.
    session: RefCell<Option<Session>>,
    /// Whether the last plan is the session's.
    in_session: bool,
    /// What the last plan was made on, unless that is the session's; `solver` has its values.
    model: Option<Model>,
    solver: Solver,
    treasures: Treasures,
}

impl Planner for Mdp {
    fn name(&self) -> Name {
        algorithm::name("mdp")
    }

    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        let here = situation.state.pose.cell;
        self.model = None;
        self.in_session = false;
        if here == situation.brief.goal {
            return Plan::at_once(Action::Hold, PlanStatus::Solved);
        }
        if budget.work_max.is_none() && situation.map.treasures().is_empty() {
            let plan = self.plan_in_session(situation, budget.pulse);
            if !situation.state.vetoed.has(plan.action) {
                return plan;
            }
            self.in_session = false;
        }
        let mut model = Model::new(situation);
        self.treasures.rebuild(situation, &model);
        let mut reach = GoalSearch::default();
        let leads_to_goal = |&node: &usize| reach.leads_to_goal(&model.world, node);
        let Some(node) = model.lattice.node(here).filter(leads_to_goal) else {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        };
        let solution = self.treasures.solve(&mut model.world, &mut self.solver, budget);
        let action = policy::allowed_action(&model.world, self.solver.values(), node, situation.state.vetoed);
        self.model = Some(model);
        Plan {
            action,
            status: if solution.converged { PlanStatus::Solved } else { PlanStatus::Cut },
            work: solution.sweeps,
            error_bound: solution.error_bound,
        }
    }

    fn policy(&self) -> Option<Vec<PolicyCell>> {
        if self.in_session {
            return self.session.borrow_mut().as_mut().map(Session::policy);
        }
        let Model { lattice, world } = self.model.as_ref()?;
        let mut cells = policy::cells(world, lattice, self.solver.values());
        for (cell, policy) in lattice.grid.iter().zip(&mut cells) {
            let onward = lattice.node(cell).and_then(|node| self.treasures.onward(node));
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
        let action = policy::named(hop);
        self.in_session = true;
        // What is promised, not what was measured: that would tell how the decision was come by.
        let beyond = if decision.method == Method::Canonical { decision.bound } else { 0.0 };
        let error_bound = solver::online::VALUE_ERROR.max(beyond);
        Plan { action, status: PlanStatus::Solved, work: decision.work, error_bound }
    }
}
