//! The payoff of landing on a cell, r = w1·S + w2·I + w3·D (P23 eq. 3), for all planners and whoever explains their choices.
//!
//! I is the height, min–max normalised by the brief's range. S and D are the profile's.
//!
//! `paper-2023`: S = −|∇h| − T, min–max normalised by the brief's range, T the brief's soil term on sand
//! and 0 on hard ground, taken with the sign it has (the paper's −5 makes sand attractive).
//! D = −‖goal − x‖ / ‖goal − start‖, in the norm and to the scale of the brief's [`crate::Reading`].
//!
//! `hopper`: S = −|∇h| alone, 1 on the flat and 0 at the steepest of the brief's range. The motion model already charges
//! what sand costs in time and risk; a soil term would charge it twice, and leave little of S's range to the slopes. D is
//! the paper's, less [`PERIOD_PRICE`].
//!
//! `paper-2022` (P22 eqs. 3 to 5, in the reading of `hopper known`): r = w1·S + w2·I + P for a period on a cell. S = −|∇h| is normalised
//! to [−1, 0], a cost; P is the brief's soil term on sand, after the weights; D is the paper's of 2023, for missions that give it a
//! weight. The goal is a cell like any other whose periods pay its payoff besides.
//!
//! # The price of a period
//! In the paper only D rewards speed, and it falls to zero at the goal, where a flat or high cell pays up to w1 + w2 for
//! every period spent on it. So preferences lead to detours: on
//! heterogeneous ground at w = (1, 0) the slope of the first hill pushed the hopper into the sand beside
//! it, at 76.7 ± 0.1 steps against the 75.2 ± 0.1 of now (3,000 and 4,000 missions; the latter are the
//! first repetitions of campaigns/hopper-mdp-10000.toml). With the same price everywhere, a
//! period costs w3 · [`PERIOD_PRICE`] = 30 at the paper's weights, and w1·S + w2·I can pay for
//! one more period only by a gain of 1, its whole range, over 30 of them. What remains to the
//! preferences is the choice among the many ways of nearly equal length, which is their purpose.
//!
//! The plan need not count the steps left. On the known map the stationary policy under this payoff
//! reaches 99.04 to 99.06 % on sandy ground, in 111.98 to 112.00 steps, where the clairvoyant with its
//! clock reaches 99.12 %, or 111.94 steps: `priced_time_leaves_nothing_for_a_clock_to_gain`, a
//! test of the clairvoyant bounds. The rest is lost by not knowing the map.

use crate::{Cell, Ground, Leg, ObservedMap, Profile, Range, Soil};

/// What a period costs in profile `hopper` besides the paper's D, in units of w3: as much as three times
/// the distance from start to goal.
///
/// The exact value hardly matters. On heterogeneous ground at w = (1, 0), over the same 1,000 missions, ways were of 76.3
/// steps with 0 in its place, of 74.8 with 1.5, 2 and 4, and of 75.1 with 6, each ± 0.2.
///
/// It also sets the value of a treasure: one of payoff R is worth R / (w3 (3 − D)) periods of detour.
pub const PERIOD_PRICE: f64 = 3.0;

/// The payoff on one leg.
#[derive(Clone, Copy, Debug)]
pub struct LandingPayoff<'a> {
    leg: &'a Leg,
    /// Distance at which D is −1, cells; 0 where every distance counts as none.
    scale_cells: f64,
}

impl<'a> LandingPayoff<'a> {
    /// The payoff with the weights, ranges and profile of `leg`.
    #[must_use]
    pub fn new(leg: &'a Leg) -> Self {
        let reading = &leg.reading;
        let start_to_goal = || reading.distance.cells(leg.start, leg.goal);
        Self { leg, scale_cells: reading.distance_scale_cells.unwrap_or_else(start_to_goal) }
    }

    /// Payoff of landing on `cell`, whose ground is believed to be `ground`. The goal has its own payoff instead of the
    /// formula; in profile `paper-2022` it is added.
    #[must_use]
    pub fn of(&self, cell: Cell, ground: &Ground) -> f64 {
        let is_paper_2022 = self.leg.profile == Profile::Paper2022;
        if cell == self.leg.goal && !is_paper_2022 {
            return self.leg.payoff.goal;
        }
        let [safety, information, distance] = self.terms(cell, ground);
        let payoff = safety + information + distance;
        if is_paper_2022 { payoff + self.beyond_the_weights(cell, ground) } else { payoff }
    }

    /// What a vertical hop pays that climbs or drops so many metres from `cell` (P22 eq. 10: S = −|Δh|), in profile `paper-2022`.
    #[must_use]
    pub fn of_climb(&self, cell: Cell, ground: &Ground, climb_m: f64) -> f64 {
        let [_, information, distance] = self.terms(cell, ground);
        let safety = self.leg.weights.safety * self.cost(climb_m.abs());
        safety + information + distance + self.beyond_the_weights(cell, ground)
    }

    /// The terms of profile `paper-2022` without a weight: those of sand and of the goal.
    fn beyond_the_weights(&self, cell: Cell, ground: &Ground) -> f64 {
        let sand = if ground.soil == Soil::Sand { self.leg.payoff.sand_term } else { 0.0 };
        sand + if cell == self.leg.goal { self.leg.payoff.goal } else { 0.0 }
    }

    /// S of profile `paper-2022`, by a slope or a climb: normalised to [−1, 0] over the brief's range.
    fn cost(&self, steepness: f64) -> f64 {
        self.leg.priors.safety.normalise(-steepness) - 1.0
    }

    /// The weighted terms w1·S, w2·I and w3·D of landing on `cell`, also where the goal's payoff replaces their sum.
    #[must_use]
    pub fn terms(&self, cell: Cell, ground: &Ground) -> [f64; 3] {
        let weights = &self.leg.weights;
        [
            weights.safety * self.safety(ground),
            weights.information * self.leg.priors.height_m.normalise(ground.height_m),
            weights.distance * self.distance(cell),
        ]
    }

    /// What landing on `cell` pays in addition to [`LandingPayoff::of`]: the payoff of a treasure known to be there.
    #[must_use]
    pub fn of_treasure(&self, map: &ObservedMap, cell: Cell) -> f64 {
        if map.treasures().contains(&cell) { self.leg.payoff.treasure } else { 0.0 }
    }

    /// S, normalised to [0, 1] over the brief's range; in profile `paper-2022` to [−1, 0].
    fn safety(&self, ground: &Ground) -> f64 {
        let range = self.leg.priors.safety;
        let sand_term = self.leg.payoff.sand_term;
        match self.leg.profile {
            Profile::Paper2023 => {
                let term = if ground.soil == Soil::Sand { sand_term } else { 0.0 };
                range.normalise(-ground.steepness() - term)
            }
            Profile::Hopper => steepness_range(range, sand_term).normalise(-ground.steepness()),
            Profile::Paper2022 => self.cost(ground.steepness()),
        }
    }

    /// D: in the paper 0 at the goal, −1 as far away as the start.
    fn distance(&self, cell: Cell) -> f64 {
        let period_price = match self.leg.profile {
            Profile::Paper2023 | Profile::Paper2022 => 0.0,
            Profile::Hopper => PERIOD_PRICE,
        };
        if self.scale_cells > 0.0 {
            let distance_cells = self.leg.reading.distance.cells(cell, self.leg.goal);
            -distance_cells / self.scale_cells - period_price
        } else {
            -period_price
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
