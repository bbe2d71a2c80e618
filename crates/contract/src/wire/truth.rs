//! `truth/terrain`: request and header; the payload is one [`super::GroundV2`] per cell.

use crate::Role;
use crate::{fixed_payload, slice_payload};

use super::declaration::wire;
use super::{
    CELL_SIZE, GRID_SIDE, GroundV2, HOP_CELLS, TREASURE_COUNT, TREASURES, cells_at_most, grid_from_wire,
    treasures_from_wire, treasures_to_wire,
};
use crate::codec::{ANY, RUN};
use crate::limits::{TREASURES_MAX, TRUTH_PAGE_CELLS};
use crate::message::{Request, RequestResponse};
use crate::{Grid, Ground, TruthPage, TruthRequest};

wire! {
    /// Asks for the truth from an index on.
    pub struct TruthRequestV1 = "hop.TruthRequest.v1", 24 bytes, refused as "truth" {
        /// Run whose ground is wanted.
        run: [u64; 2] = RUN,
        /// First index wanted; beyond the grid there is nothing.
        from: u32 = ANY,
        reserved: u32,
    }
    of TruthRequest { run, from }
}

wire! {
    /// Which run's ground follows, its lattice, and where on it; the payload is its cells.
    pub struct TruthPageV1 = "hop.TruthPage.v1", 176 bytes, refused as "truth" {
        /// Run it belongs to.
        run: [u64; 2] = RUN,
        /// Edge of a cell, metres.
        cell_size_m: f64 = CELL_SIZE => "truth.grid",
        /// Columns.
        width: u32 = GRID_SIDE => "truth.grid",
        /// Rows.
        height: u32 = GRID_SIDE => "truth.grid",
        /// Cells that one hop spans.
        hop_cells: u32 = HOP_CELLS => "truth.grid",
        /// Index of the first cell; beyond the grid there is none.
        from: u32 = ANY,
        /// Treasures anywhere on the lattice.
        treasure_count: u32 = TREASURE_COUNT => "truth.treasures",
        reserved: u32,
        /// Cells (x, y) of these treasures; zero beyond their number.
        treasures: [[i32; 2]; TREASURES_MAX] = TREASURES,
    }
    of TruthPage { run, grid, from, cells, treasures }
    to_wire {
        let Grid { width, height, cell_size_m, hop_cells } = grid;
        let (treasure_count, treasures) = &treasures_to_wire(treasures);
    }
    from_wire(wire) {
        let grid = grid_from_wire("truth.grid", [width, height], cell_size_m, hop_cells)?;
        let most = TRUTH_PAGE_CELLS.min(grid.cells().saturating_sub(from as usize));
        cells_at_most("truth.cells", most, cells)?;
        let cells = cells.iter().map(Ground::try_from).collect::<Result<_, _>>()?;
        let treasures = treasures_from_wire("truth.treasures", &grid, treasure_count, &treasures)?;
    }
    /// The page of a copied answer.
    ///
    /// # Errors
    /// If the lattice is out of bounds, there are too many cells, or one is out of range.
    pub fn truth_page_from_wire(cells: &[GroundV2]);
}

fixed_payload!(TruthRequest => TruthRequestV1);

slice_payload!(TruthPage => TruthPageV1, GroundV2, cells, truth_page_from_wire);

/// The true ground: perception asks for it, and whoever echoes it by hand; no planner may.
impl Request for TruthRequest {
    type Response = TruthPage;
    const SERVICE: RequestResponse = RequestResponse {
        name: "truth/terrain",
        server: Role::HopperSim,
        max_clients: 8,
        page: TRUTH_PAGE_CELLS,
    };
}
