//! Header of `truth/terrain`; the payload is one [`super::GroundV1`] per cell.

use bytemuck::{Pod, Zeroable};

use super::{Wire, run_from_wire, run_to_wire};
use crate::{Grid, Refusal, RunId};

/// Which run's terrain follows, and its lattice.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TerrainHeaderV1 {
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
    /// Zero.
    pub reserved: u32,
}

const _: () = assert!(size_of::<TerrainHeaderV1>() == 40);

impl Wire for TerrainHeaderV1 {
    const NAME: &'static str = "hop.TerrainHeader.v1";
}

impl TerrainHeaderV1 {
    /// The header of `run`'s terrain on `grid`.
    #[must_use]
    pub fn new(run: RunId, grid: &Grid) -> Self {
        Self {
            run: run_to_wire(run),
            cell_size_m: grid.cell_size_m,
            width: grid.width,
            height: grid.height,
            hop_cells: grid.hop_cells,
            reserved: 0,
        }
    }

    /// The run and the checked lattice.
    ///
    /// # Errors
    /// If the lattice is out of bounds.
    pub fn decode(&self) -> Result<(RunId, Grid), Refusal> {
        let grid = Grid::new(self.width, self.height, self.cell_size_m, self.hop_cells)
            .map_err(|error| Refusal::malformed("terrain.grid", "a grid within bounds", error))?;
        Ok((run_from_wire(self.run), grid))
    }
}
