//! The grid world of a hopper whose hops no slope describes: with the vertical hop, whose offers depend on what is in the way, with the
//! payoff of the predecessor paper, or over seen ground alone.
//!
//! In profiles `paper-2023` and `hopper` it is the process of [`super::model`], with the hops that are offered.
//!
//! In readings of P23 whose paths "are generated only in known areas", landing on a cell that has not been seen is worth what
//! [`UnseenGround`] says: as much as staying, as much as being lost, or the payoff of the landing for ever, of which the distance to the
//! goal is known and the rest is that of flat hard ground. The goal counts once its cell is seen, so it need not be reachable: until then
//! the payoffs' distance term alone leads towards it.
//!
//! In profile `paper-2022` (P22 eqs. 1 to 5, in the reading of `hopper known`) a period pays for the cell it begins on and for the hop,
//! V(x) = γ max_u \[r(x, u) + Σ p V(x′)\], r(x, u) with S = −|Δh| for a vertical hop; a hop of two flights takes two periods, the first
//! without a hop. The goal is a cell like any other, which pays in every period. Beyond the edge, and on impassable ground, the journey
//! ends with nothing. It is solved by the paper's Algorithm 1, to its stop criterion: where two ways are equal, the order of its sweeps
//! decides between them, as in `hopper known`.
//!
//! A cell from which no hop is offered is held on to.

use contract::{
    Action, Branch, Cell, Direction, Ground, Leg, ObservedMap, PolicyCell, Profile, Soil, UnseenGround,
    Vetoed,
};
use motion::{Offer, landing, soil_motion};
use solver::online::choice::{CANONICAL_ERROR, TIE};
use solver::{Effort, ListedHop, ListedWorld, Solution, SolveStatus};

use super::hop_lattice::HopLattice;
use super::treasure_sets::EXACT_MAX;
use crate::belief::Belief;
use crate::offers;
use crate::payoff::LandingPayoff;
use crate::plan::{Budget, Situation};
use crate::tie::first_best_action;

/// The ends of a hop, in the order of their draws.
const BRANCHES: [Branch; 4] = [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right];

/// Algorithm 1 of P22 stops once no value changes by more than this in a sweep.
const TOLERANCE_2022: f64 = 1e-2;

/// Whether the process of a leg has listed hops.
#[must_use]
pub fn is_listed(leg: &Leg) -> bool {
    leg.motion.vertical || leg.profile == Profile::Paper2022 || leg.reading.unseen != UnseenGround::Flat
}

/// The process of one situation with what it was solved to.
#[derive(Clone, Debug)]
pub struct ListedModel {
    lattice: HopLattice,
    world: ListedWorld,
    /// The action towards each direction, node by node.
    actions: Vec<[Action; 4]>,
    /// Node of the goal.
    goal: usize,
    /// Whether a way to the goal may begin beyond the seen ground.
    has_beyond: bool,
    /// In profile `paper-2022`, the value that Algorithm 1 starts from: the least payoff of a hop, at most 0.
    start: Option<f64>,
    values: Vec<f64>,
    /// The bound on the error of its values, once it is solved to the end.
    error_bound: Option<f64>,
    /// Nodes of the treasures that are planned for, with action and value once each is collected.
    treasures: Vec<(usize, PolicyCell)>,
}

impl ListedModel {
    /// The process of `situation`, not solved yet.
    #[must_use]
    pub fn new(situation: &Situation<'_>) -> Self {
        let (leg, map) = (situation.leg(), situation.map);
        let lattice = HopLattice::new(leg);
        let process = Process::new(leg, lattice, map);
        let mut world = ListedWorld::new(leg.payoff.discount);
        let mut actions = Vec::with_capacity(lattice.nodes());
        for node in 0..lattice.nodes() {
            let cell = lattice.cell(node);
            let offers = offers::offers(leg, map, &process.belief, cell);
            let mut hops = Vec::with_capacity(4);
            for (number, offer) in (0..).zip(&offers) {
                hops.extend(offer.map(|offer| process.hop(node, Direction::ALL[number], &offer)));
            }
            let is_stuck = hops.is_empty();
            if is_stuck {
                hops.push(process.standing(node));
            }
            actions.push(if is_stuck { [Action::Hold; 4] } else { offers::actions(&offers) });
            world.add(&hops);
        }
        world.add(&[]);
        for node in 0..lattice.nodes() {
            world.fix(node, process.fixed(node));
        }
        world.fix(lattice.nodes(), Some(process.lost));
        let goal = lattice.node(leg.goal).expect("the goal is on its lattice");
        let hops = (0..lattice.nodes()).flat_map(|node| world.hops(node));
        let least = hops.map(|hop| hop.pays).fold(0.0, f64::min);
        let start = process.pays_where_it_departs().then_some(least);
        Self {
            lattice,
            world,
            actions,
            goal,
            has_beyond: leg.reading.unseen != UnseenGround::Flat,
            start,
            values: Vec::new(),
            error_bound: None,
            treasures: Vec::new(),
        }
    }

    /// Whether it is solved to the end, without treasures, and is the process of `other`.
    #[must_use]
    pub fn is_solved_as(&self, other: &Self) -> bool {
        let is_solved = self.error_bound.is_some() && self.treasures.is_empty();
        is_solved && self.world == other.world && self.actions == other.actions
    }

    /// The bound on the error of its values; infinite before it is solved.
    #[must_use]
    pub fn error_bound(&self) -> f64 {
        self.error_bound.unwrap_or(f64::INFINITY)
    }

    /// Whether some chain of hops may lead from `cell` to the goal.
    #[must_use]
    pub fn leads_to_goal(&self, cell: Cell) -> bool {
        let leads = |node| self.has_beyond || self.world.leads_to(node, self.goal);
        self.lattice.node(cell).is_some_and(leads)
    }

    /// Solves the process from nothing, with treasures at `cells`, each of which pays `payoff` once: one world for each set of those
    /// that are left, as in [`super::treasure_sets`]. Work is counted in sweeps that choose hops.
    pub fn solve(&mut self, cells: &[Cell], payoff: f64, budget: &Budget<'_>) -> Solution {
        let free = |node: &usize| *node != self.goal && !self.world.hops(*node).is_empty();
        let nodes = cells.iter().filter_map(|cell| self.lattice.node(*cell)).filter(free);
        let nodes: Vec<usize> = nodes.take(EXACT_MAX).collect();
        let all = (1_usize << nodes.len()) - 1;
        // The value at each treasure while a set is left.
        let mut after: Vec<Vec<f64>> = Vec::with_capacity(all + 1);
        let mut bounds: Vec<f64> = Vec::with_capacity(all + 1);
        let (mut sweeps, mut status, mut onward) = (0, SolveStatus::Solved, Vec::new());
        for set in 0..=all {
            for (number, &node) in nodes.iter().enumerate() {
                let is_left = set & (1 << number) != 0;
                self.world.fix(node, is_left.then(|| payoff + after[set & !(1 << number)][number]));
            }
            let sweeps_max = budget.work_max.map_or(u64::MAX, |most| most - sweeps);
            let effort = Effort { error_max: CANONICAL_ERROR, sweeps_max };
            let pulse = || budget.pulse.beat();
            let solution = match self.start {
                Some(start) => {
                    let start = (start, TOLERANCE_2022);
                    self.world.solve_in_order(&mut self.values, start, sweeps_max, &pulse)
                }
                None => self.world.solve(&mut self.values, &effort, &pulse),
            };
            sweeps += solution.sweeps;
            if solution.status == SolveStatus::Cut {
                status = SolveStatus::Cut;
            }
            let smaller = (0..nodes.len()).filter(|number| set & (1 << number) != 0);
            let passed_on = smaller.map(|number| bounds[set & !(1 << number)]).fold(0.0, f64::max);
            bounds.push(solution.certificate.error_bound + passed_on);
            after.push(nodes.iter().map(|&node| self.values[node]).collect());
            for (number, &node) in nodes.iter().enumerate() {
                if set == all & !(1 << number) {
                    onward.push((node, self.policy_of(node)));
                }
            }
            if set == all {
                let error_bound = bounds[all];
                self.treasures = onward;
                self.error_bound = (status != SolveStatus::Cut).then_some(error_bound);
                let certificate = solver::Certificate { error_bound, ..solution.certificate };
                return Solution { certificate, sweeps, status, ..solution };
            }
        }
        unreachable!("the last set is that of all treasures")
    }

    /// The best action from `cell` among those that are not `vetoed`.
    #[must_use]
    pub fn action(&self, cell: Cell, vetoed: Vetoed) -> Action {
        let Some(node) = self.lattice.node(cell) else { return Action::Hold };
        let values = self.world.hop_values(&self.values, node);
        first_best_action(&self.actions[node], values, self.tie(), vetoed).unwrap_or(Action::Hold)
    }

    /// Action and value of every cell of the grid in index order; hold and 0 off the hop lattice.
    #[must_use]
    pub fn policy(&self) -> Vec<PolicyCell> {
        let policy_cell = |cell| match self.lattice.node(cell) {
            Some(node) => self.policy_of(node),
            None => PolicyCell { action: Action::Hold, value: 0.0 },
        };
        let mut cells: Vec<PolicyCell> = self.lattice.grid.iter().map(policy_cell).collect();
        for (node, policy) in &self.treasures {
            let index = self.lattice.grid.index(self.lattice.cell(*node));
            cells[index.expect("a node is a cell of the grid")] = *policy;
        }
        cells
    }

    /// Gap to the best hop up to which a hop is as good.
    fn tie(&self) -> f64 {
        if self.start.is_some() { 0.0 } else { TIE }
    }

    fn policy_of(&self, node: usize) -> PolicyCell {
        let values = self.world.hop_values(&self.values, node);
        let action = first_best_action(&self.actions[node], values, self.tie(), Vetoed::NONE);
        if self.world.hops(node).is_empty() {
            return PolicyCell { action: Action::Hold, value: 0.0 };
        }
        let action = action.filter(|_| node != self.goal).unwrap_or(Action::Hold);
        PolicyCell { action, value: self.values[node] }
    }
}

/// What hops and cells of a leg pay.
struct Process<'a> {
    leg: &'a Leg,
    lattice: HopLattice,
    map: &'a ObservedMap,
    belief: Belief<'a>,
    payoff: LandingPayoff<'a>,
    /// Value of being lost.
    lost: f64,
}

impl<'a> Process<'a> {
    fn new(leg: &'a Leg, lattice: HopLattice, map: &'a ObservedMap) -> Self {
        let (belief, payoff) = (Belief::new(leg, map), LandingPayoff::new(leg));
        let mut process = Self { leg, lattice, map, belief, payoff, lost: 0.0 };
        if !process.pays_where_it_departs() {
            let free = (0..lattice.nodes()).filter(|node| process.ground(*node).passable);
            let worst = free.map(|node| process.period(node)).fold(0.0, f64::min);
            process.lost = super::model::loss(leg, worst);
        }
        process
    }

    /// Whether a period pays for the cell that it begins on, and not for that where it ends.
    fn pays_where_it_departs(&self) -> bool {
        self.leg.profile == Profile::Paper2022
    }

    fn ground(&self, node: usize) -> &Ground {
        self.belief.ground(self.lattice.cell(node))
    }

    /// What a period on a node pays.
    fn period(&self, node: usize) -> f64 {
        self.payoff.of(self.lattice.cell(node), self.ground(node))
    }

    /// What the plan takes landing on a cell for that has not been seen; flat ground by default.
    fn unseen(&self, cell: Cell) -> UnseenGround {
        if self.map.ground(cell).is_some() { UnseenGround::Flat } else { self.leg.reading.unseen }
    }

    /// The value of a node where the journey is over: at the goal, unless it is a cell like any other, on impassable ground, and where the
    /// plan ends.
    fn fixed(&self, node: usize) -> Option<f64> {
        let cell = self.lattice.cell(node);
        match self.unseen(cell) {
            UnseenGround::Flat => {}
            // Hops that would end there stay.
            UnseenGround::Stays | UnseenGround::Leaves => return Some(self.lost),
            UnseenGround::Ends => {
                let landing: f64 = self.payoff.terms(cell, &Ground::FLAT).iter().sum();
                return Some(landing / (1.0 - self.leg.payoff.discount));
            }
        }
        let is_goal = self.lattice.cell(node) == self.leg.goal;
        match (is_goal, self.pays_where_it_departs()) {
            (true, true) => None,
            (true, false) => Some(self.leg.payoff.goal),
            (false, _) => (!self.ground(node).passable).then_some(self.lost),
        }
    }

    /// A period of standing still.
    fn standing(&self, node: usize) -> ListedHop {
        let nowhere = (node as u32, 0.0);
        ListedHop {
            number: 0,
            pays: self.period(node),
            ends: [(node as u32, 1.0), nowhere, nowhere, nowhere],
        }
    }

    fn hop(&self, node: usize, direction: Direction, offer: &Offer) -> ListedHop {
        let (cell, ground, discount) = (self.lattice.cell(node), self.ground(node), self.leg.payoff.discount);
        let waits = match self.pays_where_it_departs() {
            true => soil_motion(&self.leg.motion, ground.soil).flights > 1,
            false => ground.soil == Soil::Sand,
        };
        let then = if waits { discount } else { 1.0 };
        let stays = |branch| match branch {
            Branch::Left => offer.collides[0],
            Branch::Right => offer.collides[1],
            _ => false,
        };
        let ends = BRANCHES.map(|branch| {
            let to = if stays(branch) { cell } else { landing(&self.leg.grid, cell, direction, branch) };
            (self.end(node, to), offer.drawn.probability(branch))
        });
        let pays = if self.pays_where_it_departs() {
            match offer.climb_m {
                Some(climb_m) => self.payoff.of_climb(cell, ground, climb_m),
                None => self.period(node),
            }
        } else {
            let lands_on = |&&(to, _): &&(u32, f64)| {
                (to as usize) < self.lattice.nodes() && self.fixed(to as usize).is_none()
            };
            let landings = ends.iter().filter(lands_on);
            landings.map(|&(to, probability)| probability * self.period(to as usize)).sum()
        };
        let first = if waits { self.period(node) } else { 0.0 };
        ListedHop {
            number: direction as u8,
            pays: first + then * pays,
            ends: ends.map(|(to, probability)| (to, then * probability)),
        }
    }

    /// The node of a landing from `node`: the last one stands for all beyond the map.
    fn end(&self, node: usize, to: Cell) -> u32 {
        let stays_beyond = self.leg.profile == Profile::Paper2023 && self.leg.reading.leaving.is_none();
        match self.lattice.node(to) {
            Some(_) if self.unseen(to) == UnseenGround::Stays => node as u32,
            Some(to) => to as u32,
            None if stays_beyond => node as u32,
            None => self.lattice.nodes() as u32,
        }
    }
}
