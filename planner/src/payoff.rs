//! The payoff of landing on a cell, r = w1·S + w2·I + w3·D (P23 eq. 3): one home for every planner.
//!
//! I is the height, min–max normalised by the brief's range. D = −‖goal − x‖ / ‖goal − start‖. S is
//! the profile's:
//!
//! - `paper-2023`: −|∇h| − T, min–max normalised by the brief's range, T the brief's soil term on sand
//!   and 0 on hard ground, taken with the sign it has (the paper's −5 makes sand attractive).
//! - `hopper`: −|∇h| alone, 1 on the flat and 0 at the steepest of the brief's range. Sand's price is
//!   what it does, time and risk, and the motion model charges that already; a term on top would charge
//!   it twice, and squeeze the slopes out of S. Over 1,000 missions a cell on the paper's three worlds
//!   the MDP did better so than with T of either sign (sandy ground at w1 > 0: 98.7 % success against
//!   98.0–98.2 %, restricted mean 114 steps against 116), and greedy was no longer caught on
//!   heterogeneous ground (99.8 % at w1 = 1, where the paper's T gives 2.6 %).

use contract::{Brief, Cell, Ground, ObservedMap, Profile, Range, Soil};

/// The payoff under one brief.
#[derive(Clone, Copy, Debug)]
pub struct LandingPayoff<'a> {
    brief: &'a Brief,
    start_to_goal_cells: f64,
}

impl<'a> LandingPayoff<'a> {
    /// The payoff that `brief` asks for.
    #[must_use]
    pub fn new(brief: &'a Brief) -> Self {
        Self { brief, start_to_goal_cells: brief.start.distance_cells(brief.goal) }
    }

    /// Payoff of landing on `cell`, believed to be like `ground`. The goal's replaces the formula, and
    /// is known from the start.
    #[must_use]
    pub fn of(&self, cell: Cell, ground: &Ground) -> f64 {
        if cell == self.brief.goal {
            return self.brief.payoff.goal;
        }
        let weights = &self.brief.weights;
        weights.safety * self.safety(ground)
            + weights.information * self.brief.priors.height_m.normalise(ground.height_m)
            + weights.distance * self.distance(cell)
    }

    /// What landing on `cell` pays on top of [`LandingPayoff::of`]: that of the treasure known to be there.
    #[must_use]
    pub fn of_treasure(&self, map: &ObservedMap, cell: Cell) -> f64 {
        if map.treasures().contains(&cell) { self.brief.payoff.treasure } else { 0.0 }
    }

    /// S.
    fn safety(&self, ground: &Ground) -> f64 {
        let range = self.brief.priors.safety;
        let sand_term = self.brief.payoff.sand_term;
        match self.brief.profile {
            Profile::Paper2023 => {
                let term = if ground.soil == Soil::Sand { sand_term } else { 0.0 };
                range.normalise(-ground.steepness() - term)
            }
            Profile::Hopper => steepness_range(range, sand_term).normalise(-ground.steepness()),
        }
    }

    /// D, 0 at the goal, −1 as far away as the start.
    fn distance(&self, cell: Cell) -> f64 {
        if self.start_to_goal_cells > 0.0 {
            -cell.distance_cells(self.brief.goal) / self.start_to_goal_cells
        } else {
            0.0
        }
    }
}

/// Range of −|∇h|, recovered from the range of −|∇h| − T: where both soils occur, that range is wider
/// by |T|.
fn steepness_range(safety: Range, sand_term: f64) -> Range {
    let width = safety.max - safety.min;
    let both_soils = width > sand_term.abs();
    Range { min: if both_soils { sand_term.abs() - width } else { -width }, max: 0.0 }
}
