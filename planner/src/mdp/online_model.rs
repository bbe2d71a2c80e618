//! The model of one leg, kept in step with the observed map, and its online solver.
//!
//! The world is that of [`super::model`]; [`solver::online`] proves each hop by the cheapest method. What it remembers
//! saves time and changes no answer: its hop is a function of leg, map and pose alone ([`solver::online::choice`]).
//!
//! A node is updated when the belief about its cell changes: when it is first seen, or, in profile `hopper`, all unseen
//! cells when the majority among the seen soils changes. If much of the map changes at once, the solver starts again.

use contract::{Cell, Ground, Leg, ObservedMap, PolicyCell};
use solver::online::{HopDecision, OnlineSolver};

use super::hop_lattice::HopLattice;
use super::{model, policy};
use crate::belief::Belief;
use crate::payoff::LandingPayoff;
use crate::plan::Pulse;

/// A model that follows the map on one leg.
#[derive(Clone, Debug)]
pub struct OnlineModel {
    leg: Leg,
    lattice: HopLattice,
    /// The belief about each node's cell.
    believed: Vec<Ground>,
    /// The belief about unseen cells.
    unseen: Ground,
    /// Fingerprint of the map behind the belief.
    observation: u64,
    /// The least payoff of a node that is not impassable, 0 at most.
    worst_payoff: f64,
    online: OnlineSolver,
}

impl OnlineModel {
    /// The model of `leg` on `map`.
    ///
    /// # Panics
    /// If the brief's numbers are out of range: they are checked where a brief enters a process.
    #[must_use]
    pub fn new(leg: &Leg, map: &ObservedMap) -> Self {
        let lattice = HopLattice::new(leg);
        let belief = Belief::new(leg, map);
        let believed: Vec<Ground> =
            (0..lattice.nodes()).map(|node| *belief.ground(lattice.cell(node))).collect();
        let world = model::world(leg, &lattice, |node| believed[node]);
        Self {
            leg: *leg,
            lattice,
            believed,
            unseen: belief.unseen,
            observation: map.observation(),
            worst_payoff: model::worst_payoff(&world),
            online: OnlineSolver::new(world),
        }
    }

    /// Whether it models `leg`.
    #[must_use]
    pub fn is_of(&self, leg: &Leg) -> bool {
        self.leg == *leg
    }

    /// Updates the nodes whose belief has changed.
    pub fn follow(&mut self, map: &ObservedMap) {
        let belief = Belief::new(&self.leg, map);
        let changed = self.changed(map, &belief);
        (self.unseen, self.observation) = (belief.unseen, map.observation());
        for &node in &changed {
            self.believed[node] = *belief.ground(self.lattice.cell(node));
        }
        if 4 * changed.len() > self.believed.len() {
            let world = model::world(&self.leg, &self.lattice, |node| self.believed[node]);
            self.worst_payoff = model::worst_payoff(&world);
            self.online.replace(world);
            return;
        }
        let payoff = LandingPayoff::new(&self.leg);
        let mut worst_left = false;
        for node in changed {
            worst_left |= model::counted(self.online.world(), node) <= self.worst_payoff;
            let site = model::site(&self.leg, &payoff, self.lattice.cell(node), &self.believed[node]);
            self.online.update(node, site);
            self.worst_payoff = self.worst_payoff.min(model::counted(self.online.world(), node));
        }
        if worst_left {
            self.worst_payoff = model::worst_payoff(self.online.world());
        }
        // A new loss costs a pass over all values, but only where the hopper can be lost at all.
        let loss = model::loss(&self.leg, self.worst_payoff);
        self.online.set_loss(loss).expect("a loss of finite payoffs is finite");
    }

    /// The nodes whose belief has changed, in order. The map knows which cells are new; all are compared only if it no
    /// longer does, or if the belief about unseen ground has changed.
    fn changed(&self, map: &ObservedMap, belief: &Belief<'_>) -> Vec<usize> {
        let differs = |&node: &usize| *belief.ground(self.lattice.cell(node)) != self.believed[node];
        match map.changed_since(self.observation) {
            Some(cells) if belief.unseen == self.unseen => {
                let node = |&index: &u32| self.lattice.node(self.lattice.grid.cell(index as usize));
                let mut nodes: Vec<usize> = cells.iter().filter_map(node).filter(differs).collect();
                nodes.sort_unstable();
                nodes.dedup();
                nodes
            }
            _ => (0..self.lattice.nodes()).filter(differs).collect(),
        }
    }

    /// Decides at `cell`, which is on the map; `None` off the hop lattice.
    pub fn act(&mut self, cell: Cell, pulse: Pulse<'_>) -> Option<HopDecision> {
        Some(self.online.act_with(self.lattice.node(cell)?, None, &|| pulse.beat()))
    }

    /// Action and value of every cell of the grid in index order; hold and 0 off the hop lattice.
    pub fn policy(&mut self) -> Vec<PolicyCell> {
        let values = self.online.values().0.to_vec();
        policy::cells(self.online.world(), &self.lattice, &values)
    }
}
