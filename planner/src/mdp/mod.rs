//! The algorithm that solves the grid world as a Markov decision process before every hop (P23 section III).

pub mod hop_lattice;
pub mod hunt;
pub mod listed_model;
pub mod model;
pub mod online_model;
pub mod policy;
pub mod table_model;
pub mod treasure_sets;

use contract::{Action, Cell, MotionTable, Name, PolicyCell};
use solver::online::Method;
use solver::{GoalSearch, SolveStatus, Solver};

use self::hunt::Hunt;
use self::listed_model::ListedModel;
use self::model::Model;
use self::online_model::OnlineModel;
use self::table_model::TableModel;
use self::treasure_sets::TreasureSets;
use crate::names;
use crate::plan::{Budget, Plan, PlanStatus, Planner, Pulse, Situation};

/// The best hop from the hopper's cell.
///
/// - **Usually** the online model ([`online_model`]) decides. Work is counted in backups of a node, and what is known
///   from the last decision saves most of it.
/// - **Under a budget** the answer must not depend on what was known before, so the values are solved from nothing, and
///   work is counted in sweeps. A budget ends a solve between sweeps: the plan is then the best hop under the values so
///   far, and its error bound says how far they are from solved.
/// - **Infeasible.** If no chain of hops leads to the goal over ground not known to be impassable, the action is to
///   hold: known ground cannot become passable again, and standing still is safe.
/// - **Vetoes.** A hop that the guard has vetoed at this pose is not chosen again. The next best one is, under values of
///   the canonical procedure. So a veto of a hop that would not be chosen changes nothing, and costs nothing. The values
///   do not take the guard into account; where leaving the map and impassable ground have a price, as in profile
///   `hopper`, there is little to veto.
/// - **With the vertical hop**, in profile `paper-2022`, and in readings of P23 that plan over seen ground alone, no slope describes the
///   hops: [`listed_model`] lists them, and is solved from nothing, without a hunt.
/// - **With a motion table** the landings are the table's: [`table_model`], solved from nothing, without treasures. Without the
///   table that the brief names, or with another, the action is to hold.
/// - **Known treasures** are planned for by [`treasure_sets`], with one model for each set of them, solved from nothing.
/// - **A hunt** ([`hunt`]) values treasures higher, and looks for those not yet seen; its model is solved from nothing too.
#[derive(Clone, Debug, Default)]
pub struct Mdp {
    /// The model of the last leg planned for online.
    online: Option<OnlineModel>,
    /// Whether the last plan is the online model's.
    is_online: bool,
    /// The model of the last plan, if it was solved from nothing; `solver` has its values.
    model: Option<Model>,
    solver: Solver,
    treasures: TreasureSets,
    /// The last model of listed hops, and whether it is that of the last plan.
    listed: Option<ListedModel>,
    is_listed: bool,
    /// The last model by a motion table, and whether it is that of the last plan.
    table: Option<TableModel>,
    is_by_table: bool,
}

impl Planner for Mdp {
    fn name(&self) -> Name {
        names::name(names::MDP)
    }

    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        let here = situation.state.pose.cell;
        self.model = None;
        self.is_online = false;
        self.is_listed = false;
        self.is_by_table = false;
        if here == situation.leg().goal {
            return Plan::at_once(Action::Hold, PlanStatus::Solved);
        }
        let fingerprint = situation.leg().motion.table;
        match situation.table {
            Some(table) if table.fingerprint() == fingerprint => {
                return self.plan_by_table(situation, table, budget);
            }
            _ if fingerprint != 0 => return Plan::at_once(Action::Hold, PlanStatus::Infeasible),
            _ => {}
        }
        if listed_model::is_listed(situation.leg()) {
            return self.plan_listed(situation, budget);
        }
        let hunt = Hunt::of(situation);
        let is_plain = situation.map.treasures().is_empty() && !hunt.is_some_and(|hunt| hunt.searches());
        if budget.work_max.is_none() && is_plain {
            let plan = self.plan_online(situation, budget.pulse);
            if !situation.state.vetoed.has(plan.action) {
                return plan;
            }
            self.is_online = false;
        }
        let mut model = Model::new(situation);
        if let Some(hunt) = hunt {
            hunt.prepare(situation, &mut model, budget.pulse);
        }
        let treasure = hunt.map_or(situation.leg().payoff.treasure, |hunt| hunt.treasure);
        self.treasures.rebuild(situation, &model, treasure);
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

    fn policy(&mut self) -> Option<Vec<PolicyCell>> {
        if self.is_online {
            return self.online.as_mut().map(OnlineModel::policy);
        }
        if self.is_listed {
            return self.listed.as_ref().map(ListedModel::policy);
        }
        if self.is_by_table {
            return self.table.as_ref().map(TableModel::policy);
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
    /// Plans with the model of listed hops. Where nothing about it has changed, its values are kept: they are those of the process alone.
    fn plan_listed(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        let Situation { map, state, .. } = *situation;
        let (leg, here) = (situation.leg(), state.pose.cell);
        let model = ListedModel::new(situation);
        if !model.leads_to_goal(here) {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        }
        let mut treasures: Vec<Cell> = map.treasures().to_vec();
        treasures.sort_by(|a, b| a.distance_cells(here).total_cmp(&b.distance_cells(here)));
        let keeps = budget.work_max.is_none() && treasures.is_empty();
        let kept = self.listed.take().filter(|kept| keeps && kept.is_solved_as(&model));
        let (listed, work, error_bound, status) = match kept {
            Some(kept) => {
                let error_bound = kept.error_bound();
                (kept, 0, error_bound, PlanStatus::Solved)
            }
            None => {
                let mut model = model;
                let solution = model.solve(&treasures, leg.payoff.treasure, budget);
                let is_cut = solution.status == SolveStatus::Cut;
                let status = if is_cut { PlanStatus::Cut } else { PlanStatus::Solved };
                (model, solution.sweeps, solution.certificate.error_bound, status)
            }
        };
        self.is_listed = true;
        let action = self.listed.insert(listed).action(here, state.vetoed);
        Plan { action, status, work, error_bound }
    }

    /// Plans with the landings of `table`. Where nothing about the process has changed, its values are kept.
    fn plan_by_table(&mut self, situation: &Situation<'_>, table: &MotionTable, budget: &Budget) -> Plan {
        let state = situation.state;
        let here = state.pose.cell;
        let mut model = TableModel::new(situation, table);
        if !model.leads_to_goal(here) {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        }
        let keeps = budget.work_max.is_none();
        let kept = self.table.take().filter(|kept| keeps && kept.is_solved_as(&model));
        let (model, work, error_bound, status) = match kept {
            Some(kept) => {
                let error_bound = kept.error_bound();
                (kept, 0, error_bound, PlanStatus::Solved)
            }
            None => {
                let solution = model.solve(budget);
                let is_cut = solution.status == SolveStatus::Cut;
                let status = if is_cut { PlanStatus::Cut } else { PlanStatus::Solved };
                (model, solution.sweeps, solution.certificate.error_bound, status)
            }
        };
        self.is_by_table = true;
        let action = self.table.insert(model).action(here, state.vetoed);
        Plan { action, status, work, error_bound }
    }

    /// Plans with the online model.
    fn plan_online(&mut self, situation: &Situation<'_>, pulse: Pulse<'_>) -> Plan {
        let Situation { map, state, .. } = *situation;
        let leg = situation.leg();
        // In place: the model is large.
        match &mut self.online {
            Some(online) if online.is_of(leg) => online.follow(map),
            online => *online = Some(OnlineModel::new(leg, map)),
        }
        let online = self.online.as_mut().expect("the model was just brought up to date");
        // There is no decision off the hop lattice, and no hop where no goal can be reached.
        let decision = online.act(state.pose.cell, pulse);
        let Some((decision, hop)) = decision.and_then(|decision| Some((decision, decision.action?))) else {
            return Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        };
        let action = policy::to_action(hop);
        self.is_online = true;
        // The promised bound, not the measured one, which would depend on how the decision was found.
        let beyond = if decision.method == Method::Canonical { decision.bound } else { 0.0 };
        let error_bound = solver::online::VALUE_ERROR.max(beyond);
        Plan { action, status: PlanStatus::Solved, work: decision.work, error_bound }
    }
}
