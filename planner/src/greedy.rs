//! The algorithm that looks one hop ahead (the paper's greedy method).

use contract::{Action, Direction, Name, Profile};

use crate::belief::Belief;
use crate::names;
use crate::offers;
use crate::payoff::LandingPayoff;
use crate::plan::{Budget, Plan, PlanStatus, Planner, Situation};
use crate::tie::first_best_action;

/// Hops towards the neighbour in the map with the largest payoff; ties go to the first of north, east,
/// south, west.
///
/// With the vertical hop it hops up where a hop at the launch angle would collide, and not where both would.
///
/// A treasure known to lie on a neighbour adds its payoff.
///
/// In profile `hopper` it never hops towards ground known to be impassable. Without an eligible neighbour it holds. It
/// does not choose again what the guard has vetoed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Greedy;

impl Planner for Greedy {
    fn name(&self) -> Name {
        names::name(names::GREEDY)
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let Situation { map, state, .. } = *situation;
        let leg = situation.leg();
        let here = state.pose.cell;
        if here == leg.goal {
            return Plan::at_once(Action::Hold, PlanStatus::Solved);
        }
        let payoff = LandingPayoff::new(leg);
        let belief = Belief::new(leg, map);
        // The paper's hopper knows no ground that it must not enter; among other robots their cells are such.
        let is_of_paper = leg.profile == Profile::Paper2023 && !leg.is_shared;
        let offers = offers::offers(leg, map, &belief, here);
        let payoffs = Direction::ALL.map(|direction| {
            let cell = leg.grid.hop(here, direction);
            let ground = belief.ground(cell);
            let eligible =
                leg.grid.contains(here) && leg.grid.contains(cell) && (ground.passable || is_of_paper);
            let eligible = eligible && offers[direction as usize].is_some();
            eligible.then(|| payoff.of(cell, ground) + payoff.of_treasure(map, cell))
        });
        match first_best_action(&offers::actions(&offers), payoffs, 0.0, state.vetoed) {
            Some(action) => Plan::at_once(action, PlanStatus::Solved),
            None => Plan::at_once(Action::Hold, PlanStatus::Infeasible),
        }
    }
}
