//! The planner that reaches the bound on success, by the quickest of such plans.

use contract::{Action, Cell, Direction, Ground, Leg, MotionTable, Name};
use planner::{Budget, Plan, PlanStatus, Planner, Situation};
use terrain::Terrain;

use crate::horizon::{Horizon, offers_from};

/// Most entries of the table of hops, cells times steps.
pub const TABLE_MAX: u64 = 1 << 28;

/// In place of the directions of vertical hops, on a cell from which no hop is offered.
const NO_HOP: u8 = u8::MAX;

/// Why a mission has no clairvoyant planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ClairvoyantError {
    /// The table of hops would exceed [`TABLE_MAX`].
    #[error("a clairvoyant planner needs cells times steps of at most {TABLE_MAX}, got {cells} x {steps}")]
    TooLarge {
        /// Cells of the grid.
        cells: u64,
        /// Step limit of the mission.
        steps: u64,
    },
}

/// Knows the whole map, and takes the steps left into account. All work is done in advance, so a plan is a table lookup,
/// and the law of planners holds: it depends on the cell and the steps left alone.
#[derive(Clone, Debug)]
pub struct Clairvoyant {
    /// Best hop of each cell, layer by layer from 1 step left on.
    hops: Vec<Direction>,
    /// Directions towards which the hop of each cell is the vertical one, a bit each; [`NO_HOP`] where none is offered.
    ups: Vec<u8>,
    cells: usize,
    steps_max: u64,
}

impl Clairvoyant {
    /// Solves `leg` on `terrain`, with hops that land by `table`, or by the law without one. By a table it takes the hop of the least
    /// restricted mean: an estimate of what is possible, and no bound where truth is continuous.
    ///
    /// # Errors
    /// [`ClairvoyantError::TooLarge`] beyond [`TABLE_MAX`] entries.
    pub fn new(leg: &Leg, terrain: &Terrain, table: Option<&MotionTable>) -> Result<Self, ClairvoyantError> {
        let (cells, steps_max) = (leg.grid.cells(), leg.limits.steps_max);
        let entries = (cells as u64).checked_mul(steps_max).filter(|&entries| entries <= TABLE_MAX);
        let Some(entries) = entries else {
            return Err(ClairvoyantError::TooLarge { cells: cells as u64, steps: steps_max });
        };
        let mut hops = vec![Direction::North; entries as usize];
        let mut horizon = Horizon::new(leg, terrain, table);
        for layer in hops.chunks_exact_mut(cells) {
            horizon.next_layer(&mut |index, direction| layer[index] = direction);
        }
        let up_from = |(cell, ground): (Cell, &Ground)| {
            if table.is_some() {
                return 0;
            }
            let offers = offers_from(leg, terrain, cell, ground);
            let ups = offers.iter().flatten().filter_map(|offer| match offer.action {
                Action::Up(direction) => Some(1_u8 << direction as u8),
                _ => None,
            });
            if offers.iter().all(Option::is_none) { NO_HOP } else { ups.sum() }
        };
        let ups = leg.grid.iter().zip(&terrain.cells).map(up_from).collect();
        Ok(Self { hops, ups, cells, steps_max })
    }
}

impl Planner for Clairvoyant {
    fn name(&self) -> Name {
        planner::CLAIRVOYANT.parse().expect("a short and printable name")
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let (leg, here) = (situation.leg(), situation.state.pose.cell);
        if here == leg.goal {
            return Plan::at_once(Action::Hold, PlanStatus::Solved);
        }
        let left = self.steps_max.saturating_sub(situation.state.steps);
        match leg.grid.index(here) {
            Some(index) if left > 0 && self.ups[index] != NO_HOP => {
                let hop = self.hops[(left as usize - 1) * self.cells + index];
                let is_up = self.ups[index] >> hop as u8 & 1 == 1;
                Plan::at_once(if is_up { Action::Up(hop) } else { Action::Hop(hop) }, PlanStatus::Solved)
            }
            _ => Plan::at_once(Action::Hold, PlanStatus::Infeasible),
        }
    }
}
