//! `truth/terrain`: request and header; the payload is one [`super::GroundV2`] per cell.

use bytemuck::{Pod, Zeroable};

use crate::Role;
use crate::{fixed_payload, slice_payload};

use super::{
    GroundV2, Wire, at_most, grid_from_wire, run_from_wire, run_to_wire, treasures_from_wire,
    treasures_to_wire,
};
use crate::limits::{TREASURES_MAX, TRUTH_PAGE_CELLS};
use crate::message::{Request, RequestResponse};
use crate::{Ground, Refusal, TruthPage, TruthRequest};

/// Asks for the truth from an index on.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct TruthRequestV1 {
    pub run: [u64; 2],
    pub from: u32,
    pub reserved: u32,
}

/// Which run's ground follows, its lattice, and where on it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TruthPageV1 {
    pub run: [u64; 2],
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    pub width: u32,
    pub height: u32,
    /// Cells that one hop spans.
    pub hop_cells: u32,
    /// Index of the first cell.
    pub from: u32,
    /// Treasures anywhere on the lattice.
    pub treasure_count: u32,
    pub reserved: u32,
    /// Their cells (x, y) in index order; zero beyond the count.
    pub treasures: [[i32; 2]; TREASURES_MAX],
}

const _: () = assert!(size_of::<TruthRequestV1>() == 24);
const _: () = assert!(size_of::<TruthPageV1>() == 176);

impl Wire for TruthRequestV1 {
    const NAME: &'static str = "hop.TruthRequest.v1";
}

impl Wire for TruthPageV1 {
    const NAME: &'static str = "hop.TruthPage.v1";
}

impl From<&TruthRequest> for TruthRequestV1 {
    fn from(request: &TruthRequest) -> Self {
        Self { run: run_to_wire(request.run), from: request.from, reserved: 0 }
    }
}

impl TryFrom<&TruthRequestV1> for TruthRequest {
    type Error = Refusal;

    fn try_from(wire: &TruthRequestV1) -> Result<Self, Refusal> {
        Ok(Self { run: run_from_wire(wire.run), from: wire.from })
    }
}

impl From<&TruthPage> for TruthPageV1 {
    fn from(page: &TruthPage) -> Self {
        let (treasure_count, treasures) = treasures_to_wire(&page.treasures);
        Self {
            run: run_to_wire(page.run),
            cell_size_m: page.grid.cell_size_m,
            width: page.grid.width,
            height: page.grid.height,
            hop_cells: page.grid.hop_cells,
            from: page.from,
            treasure_count,
            reserved: 0,
            treasures,
        }
    }
}

/// The page of a copied answer.
///
/// # Errors
/// If the lattice is out of bounds, there are too many cells, or one is out of range.
pub fn truth_page_from_wire(header: &TruthPageV1, cells: &[GroundV2]) -> Result<TruthPage, Refusal> {
    let size = [header.width, header.height];
    let grid = grid_from_wire("truth.grid", size, header.cell_size_m, header.hop_cells)?;
    let most = TRUTH_PAGE_CELLS.min(grid.cells().saturating_sub(header.from as usize));
    at_most("truth.cells", most, cells)?;
    let cells = cells.iter().map(Ground::try_from).collect::<Result<_, _>>()?;
    let treasures = treasures_from_wire("truth.treasures", &grid, header.treasure_count, &header.treasures)?;
    Ok(TruthPage { run: run_from_wire(header.run), grid, from: header.from, cells, treasures })
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
