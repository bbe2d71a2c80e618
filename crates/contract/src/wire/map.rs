//! Header of `hop/rN/map`; the payload is one [`super::GroundV1`] per cell.

use bytemuck::{Pod, Zeroable};

use super::{
    GroundV1, Wire, robot_from_wire, run_from_wire, run_to_wire, treasures_from_wire, treasures_to_wire,
};
use crate::limits::{DECISIONS_MAX, TREASURES_MAX};
use crate::{Cell, Decision, Grid, Ground, MonotonicNs, ObservedMap, Refusal};

/// What the map covers and when it was made.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MapHeaderV2 {
    /// Run, high half first.
    pub run: [u64; 2],
    /// Decisions folded in: 0 for none, else the last decision + 1.
    pub folded: u64,
    /// Publications of this perception process.
    pub sequence: u64,
    /// Pose folded in, monotonic nanoseconds.
    pub sensed_ns: u64,
    /// Published, monotonic nanoseconds.
    pub published_ns: u64,
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Cells that one hop spans.
    pub hop_cells: u32,
    /// Robot.
    pub robot: u32,
    /// Treasures seen and not yet collected.
    pub treasure_count: u32,
    /// Zero.
    pub reserved: u32,
    /// Their cells (x, y) in index order; zero beyond the count.
    pub treasures: [[i32; 2]; TREASURES_MAX],
}

const _: () = assert!(size_of::<MapHeaderV2>() == 208);

impl Wire for MapHeaderV2 {
    const NAME: &'static str = "hop.MapHeader.v2";
}

impl From<&ObservedMap> for MapHeaderV2 {
    fn from(map: &ObservedMap) -> Self {
        let (treasure_count, treasures) = treasures_to_wire(&map.treasures);
        Self {
            run: run_to_wire(map.run),
            folded: map.through.map_or(0, |decision| decision.0 + 1),
            sequence: map.sequence,
            sensed_ns: map.sensed.0,
            published_ns: map.published.0,
            cell_size_m: map.grid.cell_size_m,
            width: map.grid.width,
            height: map.grid.height,
            hop_cells: map.grid.hop_cells,
            robot: u32::from(map.robot.0),
            treasure_count,
            reserved: 0,
            treasures,
        }
    }
}

/// The observed map of a copied message.
///
/// # Errors
/// If the lattice, the number of cells, or any cell is out of range.
pub fn map_from_wire(header: &MapHeaderV2, cells: &[GroundV1]) -> Result<ObservedMap, Refusal> {
    let grid = Grid::new(header.width, header.height, header.cell_size_m, header.hop_cells)
        .map_err(|error| Refusal::malformed("map.grid", "a grid within bounds", error))?;
    if cells.len() != grid.cells() {
        return Err(Refusal::malformed("map.cells", &format!("{} cells", grid.cells()), cells.len()));
    }
    if header.folded > DECISIONS_MAX {
        return Err(Refusal::malformed("map.folded", &format!("at most {DECISIONS_MAX}"), header.folded));
    }
    // Into room made beforehand: collecting results would grow the vector again and again.
    let mut ground = Vec::with_capacity(cells.len());
    for cell in cells {
        ground.push(Option::<Ground>::try_from(cell)?);
    }
    let treasures = treasures_from_wire("map.treasures", &grid, header.treasure_count, &header.treasures)?;
    let unseen = |cell: &&Cell| grid.index(**cell).is_none_or(|index| ground[index].is_none());
    if let Some(cell) = treasures.iter().find(unseen) {
        return Err(Refusal::malformed("map.treasures", "seen cells", cell));
    }
    Ok(ObservedMap {
        run: run_from_wire(header.run),
        robot: robot_from_wire(header.robot)?,
        through: header.folded.checked_sub(1).map(Decision),
        sequence: header.sequence,
        sensed: MonotonicNs(header.sensed_ns),
        published: MonotonicNs(header.published_ns),
        grid,
        cells: ground,
        treasures,
    })
}
