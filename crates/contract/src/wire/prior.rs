//! `hop/prior`.

use bytemuck::{Pod, Zeroable};

use super::{Wire, at_most, grid_from_wire, length, run_from_wire, run_to_wire};
use crate::limits::PRIOR_PAGE_CELLS;
use crate::message::{Request, RequestResponse};
use crate::{PriorCell, PriorPage, PriorRequest, Refusal, Role, SpeedPrior, fixed_payload, slice_payload};

/// Asks for the prior from an index on.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct PriorRequestV1 {
    pub run: [u64; 2],
    pub from: u32,
    pub reserved: u32,
}

/// Which run's prior follows, its lattice, and where on it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PriorPageV1 {
    pub run: [u64; 2],
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    pub width: u32,
    pub height: u32,
    /// Cells that one hop spans.
    pub hop_cells: u32,
    /// Index of the first cell.
    pub from: u32,
}

/// What is known of one cell.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PriorCellV1 {
    /// Probabilities of 0, 50, 150 and 200 m/Sol.
    pub probabilities: [f64; 4],
    /// Height at the middle of the cell, metres.
    pub height_m: f64,
}

const _: () = assert!(size_of::<PriorRequestV1>() == 24);
const _: () = assert!(size_of::<PriorPageV1>() == 40);
const _: () = assert!(size_of::<PriorCellV1>() == 40);

impl Wire for PriorRequestV1 {
    const NAME: &'static str = "hop.PriorRequest.v1";
}

impl Wire for PriorPageV1 {
    const NAME: &'static str = "hop.PriorPage.v1";
}

impl Wire for PriorCellV1 {
    const NAME: &'static str = "hop.PriorCell.v1";
}

impl From<&PriorRequest> for PriorRequestV1 {
    fn from(request: &PriorRequest) -> Self {
        Self { run: run_to_wire(request.run), from: request.from, reserved: 0 }
    }
}

impl TryFrom<&PriorRequestV1> for PriorRequest {
    type Error = Refusal;

    fn try_from(wire: &PriorRequestV1) -> Result<Self, Refusal> {
        Ok(Self { run: run_from_wire(wire.run), from: wire.from })
    }
}

impl From<&PriorCell> for PriorCellV1 {
    fn from(cell: &PriorCell) -> Self {
        Self { probabilities: cell.speeds.probabilities(), height_m: cell.height_m }
    }
}

impl TryFrom<&PriorCellV1> for PriorCell {
    type Error = Refusal;

    fn try_from(wire: &PriorCellV1) -> Result<Self, Refusal> {
        let speeds = SpeedPrior::new(wire.probabilities)?;
        Ok(Self { speeds, height_m: length("prior.height_m", wire.height_m)? })
    }
}

impl From<&PriorPage> for PriorPageV1 {
    fn from(page: &PriorPage) -> Self {
        Self {
            run: run_to_wire(page.run),
            cell_size_m: page.grid.cell_size_m,
            width: page.grid.width,
            height: page.grid.height,
            hop_cells: page.grid.hop_cells,
            from: page.from,
        }
    }
}

/// The page of a copied answer.
///
/// # Errors
/// If the lattice is out of bounds, there are too many cells, the probabilities of one do not add up, or its height
/// is out of range.
pub fn prior_page_from_wire(header: &PriorPageV1, cells: &[PriorCellV1]) -> Result<PriorPage, Refusal> {
    let size = [header.width, header.height];
    let grid = grid_from_wire("prior.grid", size, header.cell_size_m, header.hop_cells)?;
    let most = PRIOR_PAGE_CELLS.min(grid.cells().saturating_sub(header.from as usize));
    at_most("prior.cells", most, cells)?;
    let cells = cells.iter().map(PriorCell::try_from).collect::<Result<_, _>>()?;
    Ok(PriorPage { run: run_from_wire(header.run), grid, from: header.from, cells })
}

fixed_payload!(PriorRequest => PriorRequestV1);

slice_payload!(PriorPage => PriorPageV1, PriorCellV1, cells, prior_page_from_wire);

/// What planners know of the ground before the mission. Served only where speeds are uncertain.
impl Request for PriorRequest {
    type Response = PriorPage;
    const SERVICE: RequestResponse = RequestResponse {
        name: "hop/prior",
        server: Role::HopperSim,
        max_clients: 24,
        page: PRIOR_PAGE_CELLS,
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::Payload;
    use crate::{Grid, RunId};

    /// P-PRIOR-SUM.
    #[test]
    fn pages_that_cannot_be_are_refused_by_name() {
        let grid = Grid::new(20, 10, 1.0, 1).unwrap();
        let speeds = SpeedPrior::new([0.25, 0.0, 0.5, 0.25]).unwrap();
        let cells = vec![PriorCell { speeds, height_m: -2.5 }; 3];
        let page = PriorPage { run: RunId(1 << 90), grid, from: 190, cells };
        let (header, cell) = (page.header(), page.cell(0));
        assert_eq!(PriorPage::from_wire(&header, &[cell; 3]).unwrap(), page);
        let cases = [
            ("at most 10 cells", header, vec![cell; 11]),
            ("prior.grid", PriorPageV1 { width: 0, ..header }, vec![cell]),
            ("prior.sum", header, vec![PriorCellV1 { probabilities: [0.5, 0.5, 0.5, 0.0], ..cell }]),
            ("prior.probability", header, vec![PriorCellV1 { probabilities: [f64::NAN; 4], ..cell }]),
            ("prior.height_m", header, vec![PriorCellV1 { height_m: f64::INFINITY, ..cell }]),
        ];
        for (need, header, cells) in cases {
            let refusal = PriorPage::from_wire(&header, &cells).unwrap_err().to_string();
            assert!(refusal.contains(need), "{need}: {refusal}");
        }
    }
}
