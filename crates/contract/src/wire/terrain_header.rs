//! Header of `truth/terrain`; the payload is one [`super::GroundV1`] per cell.

use bytemuck::{Pod, Zeroable};

use super::{Wire, run_from_wire, run_to_wire, treasures_from_wire, treasures_to_wire};
use crate::limits::TREASURES_MAX;
use crate::{Cell, Grid, Refusal, RunId};

/// Which run's terrain follows, and its lattice.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TerrainHeaderV2 {
    /// Run, high half first.
    pub run: [u64; 2],
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Cells that one hop spans.
    pub hop_cells: u32,
    /// Treasures.
    pub treasure_count: u32,
    /// Their cells (x, y) in index order; zero beyond the count.
    pub treasures: [[i32; 2]; TREASURES_MAX],
}

const _: () = assert!(size_of::<TerrainHeaderV2>() == 168);

impl Wire for TerrainHeaderV2 {
    const NAME: &'static str = "hop.TerrainHeader.v2";
}

impl TerrainHeaderV2 {
    /// The header of `run`'s terrain on `grid` with `treasures` in index order.
    ///
    /// # Panics
    /// If there are more than [`TREASURES_MAX`].
    #[must_use]
    pub fn new(run: RunId, grid: &Grid, treasures: &[Cell]) -> Self {
        let (treasure_count, treasures) = treasures_to_wire(treasures);
        Self {
            run: run_to_wire(run),
            cell_size_m: grid.cell_size_m,
            width: grid.width,
            height: grid.height,
            hop_cells: grid.hop_cells,
            treasure_count,
            treasures,
        }
    }

    /// The run, the checked lattice, and the treasures on it.
    ///
    /// # Errors
    /// If the lattice is out of bounds, or a treasure off it, out of order or one too many.
    pub fn decode(&self) -> Result<(RunId, Grid, Vec<Cell>), Refusal> {
        let grid = Grid::new(self.width, self.height, self.cell_size_m, self.hop_cells)
            .map_err(|error| Refusal::malformed("terrain.grid", "a grid within bounds", error))?;
        let treasures =
            treasures_from_wire("terrain.treasures", &grid, self.treasure_count, &self.treasures)?;
        Ok((run_from_wire(self.run), grid, treasures))
    }
}
