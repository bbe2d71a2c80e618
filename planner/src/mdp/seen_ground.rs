//! The plan over seen ground alone: readings of P23, whose paths "are generated only in known areas".
//!
//! States are the nodes whose cells have been seen. What a hop that lands elsewhere is worth is the reading's
//! ([`UnseenGround`]): as much as staying, as much as being lost, or the payoff of the landing for ever, of which the distance
//! to the goal is known and the rest is that of flat hard ground. The goal counts once its cell is seen, so it need not be
//! reachable: until then the payoffs' distance term alone leads towards it.
//!
//! The equations are those of [`super::model`]. A hop that may stay is solved for the node's own value, V = a + b V giving
//! a / (1 − b), which has the same fixed point and is a contraction at least as strong; sweeps go to and fro. They end when the
//! best action at the hopper is certain, or, where two are equal, at [`CHANGE_MIN`]. Nothing is kept from decision to decision.

use contract::{Action, Cell, Ground, Leg, PolicyCell, UnseenGround, Vetoed};
use solver::online::choice::TIE;
use solver::{GridWorld, Hop, Kind, Leaving};

use super::hop_lattice::HopLattice;
use super::model::Model;
use super::treasure_sets::EXACT_MAX;
use crate::payoff::LandingPayoff;
use crate::plan::{Plan, PlanStatus, Situation};
use crate::tie::first_best_allowed;

/// Largest change of a value in a sweep at which values count as solved, in units of payoff.
const CHANGE_MIN: f64 = 1e-9;

/// The solution of one situation.
#[derive(Clone, Debug)]
pub struct SeenGround {
    lattice: HopLattice,
    /// State of each node; none if its cell has not been seen.
    state_of: Vec<Option<usize>>,
    /// Node of each state, in order.
    nodes: Vec<usize>,
    /// The four hops of each state, none at the goal and where the hopper is lost.
    hops: Vec<Option<[HopTerms; 4]>>,
    values: Vec<f64>,
}

/// A hop under values V: constant + Σ weight · V(state) + own · V(here).
#[derive(Clone, Copy, Debug, Default)]
struct HopTerms {
    constant: f64,
    own: f64,
    others: [(f64, usize); 3],
}

/// The value of a landing: constant, and the state whose value is added.
type Landing = (f64, Option<usize>);

impl HopTerms {
    fn value(&self, values: &[f64], here: f64) -> f64 {
        let others = self.others.iter().map(|(weight, state)| weight * values[*state]);
        self.constant + others.sum::<f64>() + self.own * here
    }

    /// Its value if it is taken for ever.
    fn repeated(&self, values: &[f64]) -> f64 {
        self.value(values, 0.0) / (1.0 - self.own)
    }
}

/// Whether `leg` asks for a plan over seen ground alone.
#[must_use]
pub fn is_asked(leg: &Leg) -> bool {
    leg.reading.unseen != UnseenGround::Flat
}

impl SeenGround {
    /// Solves `situation` for the best hop that is not vetoed.
    #[must_use]
    pub fn plan(situation: &Situation<'_>) -> (Plan, Option<Self>) {
        let hold = Plan::at_once(Action::Hold, PlanStatus::Infeasible);
        let model = Model::new(situation);
        let Some(here) = model.lattice.node(situation.state.pose.cell) else { return (hold, None) };
        let mut solution = Self::new(situation, &model);
        let Some(here) = solution.state_of[here] else { return (hold, None) };
        let vetoed = situation.state.vetoed;
        let treasures = Treasures::nearest(situation, &model, &solution);
        // What each set of treasures still to collect is worth on each of them, the smaller sets first.
        let mut after: Vec<Vec<f64>> = Vec::new();
        let (mut sweeps, mut error) = (0, 0.0);
        for set in 0..1_usize << treasures.states.len() {
            let collected = |state: usize| {
                let number = treasures.states.iter().position(|treasure| *treasure == state)?;
                (set & (1 << number) != 0).then(|| treasures.payoff + after[set & !(1 << number)][number])
            };
            solution.pose(situation.leg(), &model.world, collected);
            let is_last = set + 1 == 1 << treasures.states.len();
            let (took, bound) = solution.sweep(is_last.then_some((here, vetoed)));
            sweeps += took;
            error = bound;
            after.push(treasures.states.iter().map(|state| solution.values[*state]).collect());
        }
        let action = solution.action(here, vetoed);
        let plan = Plan { action, status: PlanStatus::Solved, work: sweeps, error_bound: error };
        (plan, Some(solution))
    }

    fn new(situation: &Situation<'_>, model: &Model) -> Self {
        let lattice = model.lattice;
        let is_seen = |node: &usize| situation.map.ground(lattice.cell(*node)).is_some();
        let nodes: Vec<usize> = (0..lattice.nodes()).filter(is_seen).collect();
        let mut state_of = vec![None; lattice.nodes()];
        nodes.iter().enumerate().for_each(|(state, node)| state_of[*node] = Some(state));
        Self { lattice, state_of, nodes, hops: Vec::new(), values: Vec::new() }
    }

    /// Writes down all hops, where landing on some states is worth `collected` beside the payoff of the landing, and ends the plan.
    fn pose(&mut self, leg: &Leg, world: &GridWorld, collected: impl Fn(usize) -> Option<f64>) {
        let rules = world.rules();
        let discount = rules.discount;
        let landing = |node: usize| -> Landing {
            let Some(state) = self.state_of[node] else {
                return match leg.reading.unseen {
                    UnseenGround::Ends => {
                        (unseen_payoff(leg, self.lattice.cell(node)) / (1.0 - discount), None)
                    }
                    _ => (rules.loss, None),
                };
            };
            match (world.kind(node), collected(state)) {
                (Kind::Lost, _) => (rules.loss, None),
                (Kind::Goal, _) => (world.payoff(node), None),
                (Kind::Free, Some(more)) => (world.payoff(node) + more, None),
                (Kind::Free, None) => (world.payoff(node), Some(state)),
            }
        };
        let of_state = |(state, &node): (usize, &usize)| {
            if world.kind(node) != Kind::Free {
                return None;
            }
            let own = (world.payoff(node), Some(state));
            let around = Hop::ALL.map(|hop| match world.neighbour(node, hop) {
                Some(to) if self.state_of[to].is_none() && leg.reading.unseen == UnseenGround::Stays => own,
                Some(to) => landing(to),
                None if rules.leaving == Leaving::Stays => own,
                None => (rules.loss, None),
            });
            // A hop from sand takes two periods, the first spent where it begins.
            let wait = world.soil(node).wait;
            let late = discount * (1.0 - wait + wait * discount);
            Some(Hop::ALL.map(|hop| {
                let scatter = world.scatter(node, hop);
                let ends = [
                    (scatter.intended, around[hop as usize]),
                    (scatter.left, around[hop.left() as usize]),
                    (scatter.right, around[hop.right() as usize]),
                    (scatter.stayed, own),
                ];
                let mut terms =
                    HopTerms { constant: discount * wait * world.payoff(node), ..HopTerms::default() };
                for (number, (chance, (payoff, to))) in ends.into_iter().enumerate() {
                    terms.constant += late * chance * payoff;
                    match to {
                        Some(to) if to == state => terms.own += late * chance,
                        Some(to) => terms.others[number] = (late * chance, to),
                        None => {}
                    }
                }
                terms
            }))
        };
        self.hops = self.nodes.iter().enumerate().map(of_state).collect();
        let least = self.nodes.iter().map(|node| world.payoff(*node)).fold(0.0, f64::min);
        self.values = self.hops.iter().map(|hops| if hops.is_some() { least } else { 0.0 }).collect();
    }

    /// Sweeps until the values are solved, or the hop of a state is certain. The sweeps, and a bound on the error of the values.
    fn sweep(&mut self, decided_at: Option<(usize, Vetoed)>) -> (u64, f64) {
        let contraction = self.contraction();
        let mut sweeps = 0;
        loop {
            sweeps += 2;
            let mut change = 0.0_f64;
            let mut improve = |state: usize| {
                let Some(hops) = &self.hops[state] else { return };
                let value =
                    hops.iter().map(|hop| hop.repeated(&self.values)).fold(f64::NEG_INFINITY, f64::max);
                change = change.max((value - self.values[state]).abs());
                self.values[state] = value;
            };
            (0..self.nodes.len()).for_each(&mut improve);
            (0..self.nodes.len()).rev().for_each(&mut improve);
            let error = change * contraction / (1.0 - contraction);
            let is_certain = decided_at.is_some_and(|(state, vetoed)| self.is_certain(state, vetoed, error));
            if change <= CHANGE_MIN || is_certain {
                return (sweeps, error);
            }
        }
    }

    /// The most that a sweep leaves of an error: the discount, at most.
    fn contraction(&self) -> f64 {
        let weights = |hop: &HopTerms| hop.own + hop.others.iter().map(|(weight, _)| weight).sum::<f64>();
        self.hops.iter().flatten().flatten().map(weights).fold(0.0, f64::max)
    }

    fn hop_values(&self, state: usize) -> Option<[f64; 4]> {
        Some(self.hops[state]?.map(|hop| hop.value(&self.values, self.values[state])))
    }

    /// Whether no error of the values up to `error` changes the hop of `state`.
    fn is_certain(&self, state: usize, vetoed: Vetoed, error: f64) -> bool {
        let Some(values) = self.hop_values(state).filter(|_| vetoed == Vetoed::NONE) else { return false };
        let best = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        values.iter().filter(|value| **value > best - TIE - 2.0 * error).count() == 1
    }

    fn action(&self, state: usize, vetoed: Vetoed) -> Action {
        let values = self.hop_values(state).map(|values| values.map(Some));
        let hop = values.and_then(|values| first_best_allowed(values, TIE, vetoed));
        hop.map_or(Action::Hold, Action::Hop)
    }

    /// Action and value of every cell of the grid in index order; hold and 0 where nobody has seen the ground.
    #[must_use]
    pub fn policy(&mut self) -> Vec<PolicyCell> {
        self.sweep(None);
        let none = PolicyCell { action: Action::Hold, value: 0.0 };
        let of_state =
            |state: usize| PolicyCell { action: self.action(state, Vetoed::NONE), value: self.values[state] };
        let state = |cell| self.lattice.node(cell).and_then(|node| self.state_of[node]);
        self.lattice.grid.iter().map(|cell| state(cell).map_or(none, of_state)).collect()
    }
}

/// The payoff of landing on a cell of which only the distance to the goal is known.
fn unseen_payoff(leg: &Leg, cell: Cell) -> f64 {
    LandingPayoff::new(leg).terms(cell, &Ground::FLAT).iter().sum()
}

/// Treasures that are planned for.
struct Treasures {
    states: Vec<usize>,
    payoff: f64,
}

impl Treasures {
    /// The nearest known ones, as [`super::treasure_sets`] chooses them.
    fn nearest(situation: &Situation<'_>, model: &Model, solution: &SeenGround) -> Self {
        let here = situation.state.pose.cell;
        let mut cells = situation.map.treasures().to_vec();
        cells.sort_by(|a, b| a.distance_cells(here).total_cmp(&b.distance_cells(here)));
        let is_free = |node: &usize| model.world.kind(*node) == Kind::Free;
        let nodes = cells.into_iter().filter_map(|cell| model.lattice.node(cell)).filter(is_free);
        let states = nodes.filter_map(|node| solution.state_of[node]).take(EXACT_MAX).collect();
        Self { states, payoff: situation.leg().payoff.treasure }
    }
}
