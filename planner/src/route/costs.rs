//! The graph of intended hops, with the expected cost of each on the believed ground.
//!
//! A hop that is repeated until it lands where it was meant to takes 1/p tries, p from soil and slope
//! ([`motion::transitions`]). All but the last cost what a failed hop costs, so its expected cost is
//! (1/p − 1) · failed + intended steps, in the paper's count ([`motion::steps`]): 2.2 on flat hard
//! ground, 3.9 on flat sand. With the vertical hop each cell has the hops that it is offered. Unseen ground is what [`Belief`] takes it for in the brief's profile.
//!
//! Costs are integers, millionths of a step: sums are exact whatever their order, so equal routes are
//! equal, and a search from the start agrees with one from the goal to the last digit.

use contract::{Action, Branch, Cell, Direction, Grid, Ground, MotionParameters, Soil};
use motion::{Offer, steps, transitions};

use crate::belief::Belief;
use crate::offers;
use crate::plan::Situation;

/// The cost of a hop that is not allowed.
pub const FORBIDDEN: u64 = u64::MAX;

/// Millionths of a step in one step.
pub const MICROSTEPS: f64 = 1.0e6;

/// A hop less likely than this to land where it was meant to is not attempted.
pub const INTENDED_MIN: f64 = 1.0e-6;

/// Expected cost of each hop on the grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Costs {
    /// Cost of the four hops from each cell, in index order and that of [`Direction::ALL`];
    /// [`FORBIDDEN`] off the map, onto ground known to be impassable, where no hop succeeds, and what the
    /// guard has vetoed at the hopper's cell.
    pub hops: Vec<[u64; 4]>,
    /// A lower bound on the cost of any hop, which does not depend on the map.
    pub cheapest: u64,
    /// The actions of the four hops from the hopper's cell.
    pub actions: [Action; 4],
    /// Columns, rows, and cells a hop.
    shape: [u32; 3],
}

impl Costs {
    /// The graph over the ground as believed in `situation`.
    #[must_use]
    pub fn new(situation: &Situation<'_>) -> Self {
        let Situation { map, state, .. } = *situation;
        let leg = situation.leg();
        let (grid, belief) = (leg.grid, Belief::new(leg, map));
        let of = |cell: Cell| {
            let offers = offers::offers(leg, map, &belief, cell);
            let soil = belief.ground(cell).soil;
            (
                offers.map(|offer| offer.map_or(FORBIDDEN, |offer| cost(soil, &offer))),
                offers::actions(&offers),
            )
        };
        let unseen = costs(&leg.motion, &belief.unseen);
        let actions = if grid.contains(state.pose.cell) {
            of(state.pose.cell).1
        } else {
            Direction::ALL.map(Action::Hop)
        };
        let enters = |cell: Cell| cell == leg.goal || (grid.contains(cell) && belief.ground(cell).passable);
        let hops = grid.iter().map(|cell| {
            let believed = match belief.is_seen(cell) {
                true if leg.motion.vertical => of(cell).0,
                true => costs(&leg.motion, belief.ground(cell)),
                false => unseen,
            };
            Direction::ALL.map(|direction| {
                let vetoed = cell == state.pose.cell && state.vetoed.has(actions[direction as usize]);
                let open = enters(grid.hop(cell, direction)) && !vetoed;
                if open { believed[direction as usize] } else { FORBIDDEN }
            })
        });
        // No slope makes a hop more likely to succeed than the flat does.
        let flat = |soil| costs(&leg.motion, &Ground { soil, ..Ground::FLAT })[0];
        Self {
            hops: hops.collect(),
            cheapest: flat(Soil::Hard).min(flat(Soil::Sand)),
            actions,
            shape: [grid.width, grid.height, grid.hop_cells],
        }
    }

    /// Whether both graphs have the same grid and lower bound; hops may differ in cost.
    #[must_use]
    pub fn comparable(&self, other: &Costs) -> bool {
        self.shape == other.shape && self.cheapest == other.cheapest
    }
}

/// A lower bound on the cost from one cell to another. It is symmetric, hence consistent. Exact on flat ground of the cheaper soil.
#[must_use]
pub fn at_least(grid: &Grid, cheapest: u64, from: Cell, to: Cell) -> u64 {
    let cells = u64::from(from.x.abs_diff(to.x)) + u64::from(from.y.abs_diff(to.y));
    cells / u64::from(grid.hop_cells) * if cheapest == FORBIDDEN { 0 } else { cheapest }
}

/// Expected cost of the four hops from `ground`.
fn costs(motion: &MotionParameters, ground: &Ground) -> [u64; 4] {
    let scatter = transitions(motion, ground);
    Direction::ALL
        .map(|direction| expected(ground.soil, Action::Hop(direction), scatter[direction as usize].intended))
}

/// Expected cost of a hop that is offered.
fn cost(soil: Soil, offer: &Offer) -> u64 {
    expected(soil, offer.action, offer.drawn.intended)
}

/// Expected cost of a hop that is repeated until it lands as intended, with that probability each time.
fn expected(soil: Soil, hop: Action, intended: f64) -> u64 {
    if intended < INTENDED_MIN {
        return FORBIDDEN;
    }
    let once = steps(soil, hop, Branch::Intended) as f64;
    let again = steps(soil, hop, Branch::Stayed) as f64;
    libm::round(((1.0 / intended - 1.0) * again + once) * MICROSTEPS) as u64
}
