//! `hop/prior`.

use super::declaration::wire;
use super::{CELL_SIZE, GRID_SIDE, HOP_CELLS, cells_at_most, grid_from_wire};
use crate::codec::{ANY, LENGTH, RUN, by_hand};
use crate::limits::PRIOR_PAGE_CELLS;
use crate::message::{Request, RequestResponse};
use crate::{Grid, PriorCell, PriorPage, PriorRequest, Role, SpeedPrior, fixed_payload, slice_payload};

wire! {
    /// Asks for the prior from an index on.
    pub struct PriorRequestV1 = "hop.PriorRequest.v1", 24 bytes, refused as "prior" {
        /// Run whose prior is wanted.
        run: [u64; 2] = RUN,
        /// First index wanted; beyond the grid there is nothing.
        from: u32 = ANY,
        reserved: u32,
    }
    of PriorRequest { run, from }
}

wire! {
    /// Which run's prior follows, its lattice, and where on it; the payload is its cells.
    pub struct PriorPageV1 = "hop.PriorPage.v1", 40 bytes, refused as "prior" {
        /// Run it belongs to.
        run: [u64; 2] = RUN,
        /// Edge of a cell, metres.
        cell_size_m: f64 = CELL_SIZE => "prior.grid",
        /// Columns.
        width: u32 = GRID_SIDE => "prior.grid",
        /// Rows.
        height: u32 = GRID_SIDE => "prior.grid",
        /// Cells that one hop spans.
        hop_cells: u32 = HOP_CELLS => "prior.grid",
        /// Index of the first cell; beyond the grid there is none.
        from: u32 = ANY,
    }
    of PriorPage { run, grid, from, cells }
    to_wire {
        let Grid { width, height, cell_size_m, hop_cells } = grid;
    }
    from_wire(wire) {
        let grid = grid_from_wire("prior.grid", [width, height], cell_size_m, hop_cells)?;
        let most = PRIOR_PAGE_CELLS.min(grid.cells().saturating_sub(from as usize));
        cells_at_most("prior.cells", most, cells)?;
        let cells = cells.iter().map(PriorCell::try_from).collect::<Result<_, _>>()?;
    }
    /// The page of a copied answer.
    ///
    /// # Errors
    /// If the lattice is out of bounds, there are too many cells, the probabilities of one do not add up, or its height
    /// is out of range.
    pub fn prior_page_from_wire(cells: &[PriorCellV1]);
}

wire! {
    /// What is known of one cell.
    pub struct PriorCellV1 = "hop.PriorCell.v1", 40 bytes, refused as "prior" {
        /// Probabilities of 0, 50, 150 and 200 m/Sol.
        probabilities: [f64; 4] = by_hand("each 0 to 1, and 1 in all"),
        /// Height at the middle of the cell, metres.
        height_m: f64 = LENGTH,
    }
    of PriorCell { speeds, height_m }
    to_wire {
        let probabilities = &speeds.probabilities();
    }
    from_wire(wire) {
        let speeds = SpeedPrior::new(probabilities)?;
    }
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
