//! Profile `hopper`'s hunt: what a known treasure is worth, and what it is worth to see cells that may hold another.
//!
//! A hunt needs treasures on the map, by the brief's [`contract::Priors`], and steps to spare: more than [`RESERVE`] times
//! those that the way to the goal is expected to take, and [`RESERVE_STEPS`] more. Without them the mission is planned as
//! one without a hunt, with the brief's payoff for what is known.
//!
//! # A known treasure
//! It pays [`TREASURE_FACTOR`] times the brief's payoff R, 400 by default. A period costs 30 to 40 here
//! ([`PERIOD_PRICE`]), so that is worth a detour of 10 to 13 periods. In the paper, where a period costs 10 at most and
//! nothing near the goal, R = 20 is enough for the treasures that it sees.
//!
//! # A cell not yet seen
//! holds a treasure with probability λ = (treasures on the map − treasures found) / (unseen cells). A treasure found is
//! worth what it pays, G = [`TREASURE_FACTOR`] · R, less a period to fetch it. Landing on x brings u(x) unseen cells into
//! sight, those of the sensor's disc from the height that x is believed to have. Landings in a row see most of these
//! cells together: on a straight way over flat ground each sees κ = (2r + 1) · stride / (cells of the disc) of its disc
//! for the first time, 5 of 13 with the paper's sensor. So landing on x pays κ λ u(x) G more.
//!
//! That is an estimate: the model has no memory of what was seen along the way, and would collect it again and again.
//! So it never pays more than [`SEARCH_SHARE_MAX`] of what a period costs at least. Every period still has a price, no
//! plan lingers among unseen cells, and a search goes no further than its cells are worth. The next landing plans anew,
//! with what it has seen.
//!
//! Neither factor needs to be exact. Over 400 random places of four treasures on the paper's hard ground, 9 missions
//! each, 0.75 treasures were collected in 74.3 steps without a hunt, 1.18 in 77.0 without the search, 1.41, 1.43, 1.42,
//! 1.44 in 78.8 to 79.2 with it at factors 10, 15, 20, 30.
//!
//! # Danger
//! The loss of the hopper is [`LOSS_TREASURES`] treasures worse, so that no treasure at the edge of the map is worth a
//! risk that the goal is not.

use contract::{Action, Branch, Cell, Leg, ObservedMap, Profile};
use motion::{soil_motion, steps};
use solver::{GridWorld, Kind, Site};

use super::hop_lattice::HopLattice;
use super::model::Model;
use crate::belief::Belief;
use crate::payoff::PERIOD_PRICE;
use crate::plan::{Pulse, Situation};

/// What a treasure pays in profile `hopper`, in units of the brief's payoff.
pub const TREASURE_FACTOR: f64 = 20.0;

/// Most that seeing new cells pays, as a share of the least price of a period.
pub const SEARCH_SHARE_MAX: f64 = 0.9;

/// Steps to spare for a hunt, as a factor on those that the way to the goal is expected to take.
pub const RESERVE: f64 = 1.25;

/// Steps to spare besides: as many as the longest detour for a treasure takes.
pub const RESERVE_STEPS: f64 = 30.0;

/// How much more being lost costs during a hunt, in treasures.
pub const LOSS_TREASURES: f64 = 20.0;

/// The hunt of one situation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hunt {
    /// Payoff of collecting a treasure.
    pub treasure: f64,
    /// Payoff of landing where one unseen cell comes into sight, 0 if all treasures are found.
    per_cell: f64,
    /// Most that landing on a cell pays for what comes into sight.
    search_max: f64,
}

impl Hunt {
    /// The hunt of `situation`; `None` where there is nothing to hunt, or not the steps for it.
    #[must_use]
    pub fn of(situation: &Situation<'_>) -> Option<Self> {
        let Situation { map, state, .. } = *situation;
        let leg = situation.leg();
        let treasures = leg.priors.treasures;
        let hunts = leg.profile == Profile::Hopper && treasures > 0 && leg.payoff.treasure > 0.0;
        if !hunts || !has_steps_to_spare(situation) {
            return None;
        }
        let weights = &leg.weights;
        let treasure = TREASURE_FACTOR * leg.payoff.treasure;
        let period_price = weights.distance * PERIOD_PRICE;
        let found = f64::from(state.collected.count()) + map.treasures().len() as f64;
        let unseen = (leg.grid.cells() - map.seen_cells()).max(1) as f64;
        let density = (f64::from(treasures) - found).max(0.0) / unseen;
        let least_price = period_price - weights.safety.abs() - weights.information.abs();
        Some(Self {
            treasure,
            per_cell: seen_first(leg) * density * (treasure - period_price).max(0.0),
            search_max: SEARCH_SHARE_MAX * least_price.max(0.0),
        })
    }

    /// Whether seeing new cells pays anything.
    #[must_use]
    pub fn searches(&self) -> bool {
        self.per_cell > 0.0 && self.search_max > 0.0
    }

    /// Turns `model`, without treasures, into the model of the hunt.
    pub fn prepare(&self, situation: &Situation<'_>, model: &mut Model, pulse: Pulse<'_>) {
        let Model { lattice, world } = model;
        let loss = world.rules().loss - LOSS_TREASURES * self.treasure;
        world.set_loss(loss).expect("a brief is checked where it enters a process");
        if self.searches() {
            self.add_search(situation, lattice, world, pulse);
        }
    }

    fn add_search(
        &self,
        situation: &Situation<'_>,
        lattice: &HopLattice,
        world: &mut GridWorld,
        pulse: Pulse<'_>,
    ) {
        let (leg, map) = (situation.leg(), situation.map);
        let belief = Belief::new(leg, map);
        let unseen = UnseenCells::new(map);
        for node in (0..lattice.nodes()).filter(|&node| world.kind(node) == Kind::Free).collect::<Vec<_>>() {
            let cell = lattice.cell(node);
            let reach_cells = leg.sensor.reach_cells(&leg.grid, belief.ground(cell).height_m);
            let search = self.per_cell * unseen.within(reach_cells, cell) as f64;
            let site = world.site(node);
            world.set(node, Site { payoff: site.payoff + search.min(self.search_max), ..site });
            pulse.count(node as u64 + 1);
        }
    }
}

/// Whether the steps left are enough for the way to the goal with the reserve. Visits in turn have steps without end.
fn has_steps_to_spare(situation: &Situation<'_>) -> bool {
    let Situation { map, state, .. } = *situation;
    let leg = situation.leg();
    let (here, goal) = (state.pose.cell, leg.goal);
    let soil = Belief::new(leg, map).unseen.soil;
    let hop = Action::Hop(contract::Direction::North);
    let [once, again] = [Branch::Intended, Branch::Stayed].map(|branch| steps(soil, hop, branch) as f64);
    // A hop is repeated until it succeeds.
    let per_hop = once + again * (1.0 / soil_motion(&leg.motion, soil).intended - 1.0);
    let cells = f64::from(here.x.abs_diff(goal.x)) + f64::from(here.y.abs_diff(goal.y));
    let needed = per_hop * cells / f64::from(leg.grid.hop_cells);
    let left = leg.limits.steps_max.saturating_sub(state.steps) as f64;
    left > RESERVE * needed + RESERVE_STEPS
}

/// κ: which share of the disc that a landing sees is seen for the first time, on a straight way over flat ground.
fn seen_first(leg: &Leg) -> f64 {
    let grid = &leg.grid;
    let reach_cells = leg.sensor.reach_cells(grid, 0.0).min(f64::from(grid.width.max(grid.height)));
    let rows = reach_cells as i32;
    let disc: f64 = (-rows..=rows).map(|row| f64::from(2 * half_row(reach_cells, row) + 1)).sum();
    (f64::from(2 * rows + 1) * f64::from(grid.hop_cells) / disc).min(1.0)
}

/// Cells of a disc to either side of its middle, `row` rows away from it.
fn half_row(reach_cells: f64, row: i32) -> i32 {
    (reach_cells * reach_cells - f64::from(row) * f64::from(row)).max(0.0).sqrt() as i32
}

/// The unseen cells of a map, counted along its rows.
struct UnseenCells {
    width: i32,
    height: i32,
    /// For each row, how many cells before each are unseen: width + 1 numbers a row.
    before: Vec<u32>,
}

impl UnseenCells {
    fn new(map: &ObservedMap) -> Self {
        let (width, height) = (map.grid.width, map.grid.height);
        let mut before = Vec::with_capacity((width as usize + 1) * height as usize);
        for row in map.cells().chunks(width as usize) {
            let mut count = 0;
            before.push(count);
            before.extend(row.iter().map(|cell| {
                count += u32::from(cell.is_none());
                count
            }));
        }
        Self { width: width as i32, height: height as i32, before }
    }

    /// How many lie in the closed disc around `centre`, a cell of the map.
    fn within(&self, reach_cells: f64, centre: Cell) -> u32 {
        let reach = reach_cells as i32;
        let last = centre.y.saturating_add(reach).min(self.height - 1);
        (centre.y.saturating_sub(reach).max(0)..=last)
            .map(|y| {
                let half = half_row(reach_cells, y - centre.y);
                let first = centre.x.saturating_sub(half).max(0);
                let end = centre.x.saturating_add(half).saturating_add(1).min(self.width);
                let row = y as usize * (self.width as usize + 1);
                self.before[row + end as usize] - self.before[row + first as usize]
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use contract::{Grid, Ground, RobotId, RunId};

    use super::*;

    #[test]
    fn unseen_cells_are_counted_as_the_sensor_sees_them() {
        let grid = Grid::new(9, 7, 1.0, 1).unwrap();
        let mut map = ObservedMap::unseen(RunId(1), RobotId(0), grid);
        for index in [3, 10, 11, 30, 31, 32, 40, 62] {
            map.learn(index, Ground::FLAT);
        }
        let unseen = UnseenCells::new(&map);
        for centre in grid.iter() {
            for reach_cells in [1.0, 2.0, 2.32, 5.0, 30.0, 1e9] {
                let sees = |cell: &Cell| cell.distance_cells(centre) <= reach_cells;
                let counted = grid.iter().filter(sees).filter(|&cell| map.ground(cell).is_none()).count();
                assert_eq!(unseen.within(reach_cells, centre), counted as u32, "{centre} {reach_cells}");
            }
        }
    }
}
