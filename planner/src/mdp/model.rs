//! The grid world as a Markov decision process: what a hop pays, and where it may lead.
//!
//! With r(x) the payoff of landing on x, γ the discount, p(x′ | x, u) the scatter of hop u:
//!
//! - from hard ground V(x) = γ max_u Σ p (r(x′) + V(x′));
//! - from sand a hop takes two periods, the first spent at x:
//!   V(x) = γ max_u \[r(x) + γ Σ p (r(x′) + V(x′))\];
//! - the goal absorbs: V = 0, and landing there pays the brief's goal payoff;
//! - unseen cells are as [`Belief`] assumes;
//! - in profile `paper-2023` leaving the map counts as staying, in the plan only, unless the brief's
//!   [`contract::Reading`] prices it; in profile `hopper` it loses the hopper, from unseen cells too;
//! - landing on ground known to be impassable loses the hopper, in both profiles (the paper's worlds
//!   have none).
//!
//! The afterstate value of being lost replaces r(x′) + V(x′). It lies [`LOSS`] below the worst payoff for ever on this
//! map, min r / (1 − γ). A fixed value such as −300 fails on a map of 50 × 50 cells: far from the goal the way there costs
//! more than that, and the best plan would be to jump off the map.
//!
//! Hops keep to a lattice of every `hop_cells`-th cell, so only the goal's lattice is modelled.

use contract::{Cell, Ground, Leg, Profile, Soil};
use motion::soil_motion;
use scatter::slope_in_limits;
use solver::{GridWorld, Kind, Leaving, Rules, Site};

use super::hop_lattice::HopLattice;
use crate::belief::Belief;
use crate::payoff::LandingPayoff;
use crate::plan::Situation;

/// How far the value of being lost lies below the worst payoff for ever, in units of payoff.
pub const LOSS: f64 = -300.0;

/// The Markov decision process of one situation.
#[derive(Clone, Debug)]
pub struct Model {
    /// The cells of its nodes.
    pub lattice: HopLattice,
    /// The process as the solver sees it.
    pub world: GridWorld,
}

impl Model {
    /// The process of `situation`, without treasures.
    ///
    /// # Panics
    /// If the brief's numbers are out of range: they are checked where a brief enters a process.
    #[must_use]
    pub fn new(situation: &Situation<'_>) -> Self {
        let leg = situation.leg();
        let (lattice, belief) = (HopLattice::new(leg), Belief::new(leg, situation.map));
        let world = world(leg, &lattice, |node| *belief.ground(lattice.cell(node)));
        Self { lattice, world }
    }
}

/// The process on the ground that `ground` gives for each node.
///
/// # Panics
/// If the brief's numbers are out of range: they are checked where a brief enters a process.
#[must_use]
pub fn world(leg: &Leg, lattice: &HopLattice, ground: impl Fn(usize) -> Ground) -> GridWorld {
    let leaving = match (leg.profile, leg.reading.leaving) {
        (Profile::Paper2023, None) => Leaving::Stays,
        (Profile::Paper2023, Some(_)) | (Profile::Hopper | Profile::Paper2022, _) => Leaving::Loses,
    };
    let rules = Rules { discount: leg.payoff.discount, loss: 0.0, leaving, soils: soils(leg).to_vec() };
    let refused = "a brief is checked where it enters a process";
    let mut world = GridWorld::new(lattice.width, lattice.height, rules).expect(refused);
    let payoff = LandingPayoff::new(leg);
    for node in 0..lattice.nodes() {
        world.set(node, site(leg, &payoff, lattice.cell(node), &ground(node)));
    }
    world.set_loss(loss(leg, worst_payoff(&world))).expect(refused);
    world
}

/// The node of a cell.
#[must_use]
pub fn site(leg: &Leg, payoff: &LandingPayoff<'_>, cell: Cell, ground: &Ground) -> Site {
    Site {
        kind: match ground.passable {
            _ if cell == leg.goal => Kind::Goal,
            true => Kind::Free,
            false => Kind::Lost,
        },
        payoff: payoff.of(cell, ground),
        slope_east: slope_in_limits(ground.gradient[0], leg.motion.slope_limit_rad),
        slope_north: slope_in_limits(ground.gradient[1], leg.motion.slope_limit_rad),
        soil: u8::from(ground.soil == Soil::Sand),
    }
}

/// A node's payoff for [`worst_payoff`]: 0 where it is impassable.
#[must_use]
pub fn counted(world: &GridWorld, node: usize) -> f64 {
    if world.kind(node) == Kind::Lost { 0.0 } else { world.payoff(node) }
}

/// The least payoff of a node that is not impassable, 0 at most.
#[must_use]
pub fn worst_payoff(world: &GridWorld) -> f64 {
    (0..world.nodes()).map(|node| counted(world, node)).fold(0.0, f64::min)
}

/// The afterstate value of being lost: that of the brief's reading, or [`LOSS`] below the worst payoff for ever.
#[must_use]
pub fn loss(leg: &Leg, worst_payoff: f64) -> f64 {
    if let Some(leaving) = leg.reading.leaving {
        return leaving;
    }
    LOSS + worst_payoff / (1.0 - leg.payoff.discount)
}

/// Hard ground and sand, as the solver knows soils: a hop from sand takes two periods.
fn soils(leg: &Leg) -> [solver::Soil; 2] {
    [Soil::Hard, Soil::Sand].map(|soil| {
        let motion = soil_motion(&leg.motion, soil);
        // Both sides share the remainder to 1, which rounding may leave just below 0 where there are no slips.
        let sideways = (0.5 * (1.0 - motion.intended - motion.stuck)).max(0.0);
        let wait = f64::from(u8::from(soil == Soil::Sand));
        solver::Soil { intended: motion.intended, stuck: motion.stuck, sideways, wait }
    })
}
