//! `hop/map` and `hop/snapshot`.

use std::num::NonZeroU8;

use crate::Role;
use crate::{fixed_payload, slice_payload};

use super::declaration::wire;
use super::ground::SEEN_SOIL;
use super::{
    CELL_SIZE, GRID_SIDE, HOP_CELLS, TREASURE_COUNT, TREASURES, cells_at_most, grid_from_wire,
    treasures_from_wire, treasures_to_wire,
};
use crate::codec::{ANY, COUNTED, GRADIENT, LENGTH, ROBOT, RUN, at_most, by_hand};
use crate::limits::{MAP_PAGE_CELLS, MAP_PATCH_CELLS, PATCHES_MAX, TREASURES_MAX};
use crate::message::{Capacity, Message, PublishSubscribe, Request, RequestResponse};
use crate::{Decision, Digest, Grid, Ground, MapPage, MapPatch, MapRequest, MonotonicNs, Refusal, SeenCell};

wire! {
    /// A patch: what a landing changed in the map, or a part of that; the payload is its cells.
    pub struct MapPatchV2 = "hop.MapPatch.v2", 264 bytes, refused as "map" {
        /// Run it belongs to.
        run: [u64; 2] = RUN,
        /// Decision of the landing.
        through: u64 = COUNTED,
        /// Place in the run's stream of patches, from 1, by which a gap is seen.
        sequence: u64 = at_most(PATCHES_MAX),
        /// Fingerprint of the map that it goes on.
        before: u64 = ANY,
        /// Fingerprint of the map with its cells.
        after: u64 = ANY,
        /// Pose folded in, monotonic nanoseconds.
        sensed_ns: u64 = ANY,
        /// Published, monotonic nanoseconds.
        published_ns: u64 = ANY,
        /// Edge of a cell, metres.
        cell_size_m: f64 = CELL_SIZE => "map.grid",
        /// Columns.
        width: u32 = GRID_SIDE => "map.grid",
        /// Rows.
        height: u32 = GRID_SIDE => "map.grid",
        /// Cells that one hop spans.
        hop_cells: u32 = HOP_CELLS => "map.grid",
        /// Robot whose sensor it is.
        robot: u32 = ROBOT,
        /// Seen cells of the map with its cells.
        seen_cells: u32 = by_hand("at most the cells of the grid"),
        /// Parts of the same landing that follow.
        more: u32 = by_hand("at most the cells of the grid"),
        /// Treasures seen and not yet collected.
        treasure_count: u32 = TREASURE_COUNT => "map.treasures",
        reserved: u32,
        /// Digest of the state whose pose was folded in last.
        digest: [u8; 32] = ANY,
        /// Cells (x, y) of these treasures; zero beyond their number.
        treasures: [[i32; 2]; TREASURES_MAX] = TREASURES,
    }
    of MapPatch {
        run,
        robot,
        through: Decision(through),
        digest: Digest(digest),
        more,
        sequence,
        before,
        after,
        sensed: MonotonicNs(sensed_ns),
        published: MonotonicNs(published_ns),
        grid,
        seen_cells,
        treasures,
        cells,
    }
    to_wire {
        let Grid { width, height, cell_size_m, hop_cells } = grid;
        let (treasure_count, treasures) = &treasures_to_wire(treasures);
    }
    from_wire(wire) {
        let grid = grid_from_wire("map.grid", [width, height], cell_size_m, hop_cells)?;
        let whole = grid.cells() as u32;
        for (field, number) in [("map.seen_cells", seen_cells), ("map.more", more)] {
            if number > whole {
                return Err(Refusal::malformed(field, &format!("at most {whole}"), number));
            }
        }
        let treasures = treasures_from_wire("map.treasures", &grid, treasure_count, &treasures)?;
        let cells = seen_cells_from_wire(cells, MAP_PATCH_CELLS, 0, whole)?;
    }
    /// The patch of a copied message.
    ///
    /// # Errors
    /// If the lattice or a number is out of range, there are too many cells, or one is out of range, off the
    /// lattice or out of order.
    pub fn patch_from_wire(cells: &[SeenCellV4]);
}

wire! {
    /// Asks for the map from an index on.
    pub struct MapRequestV1 = "hop.MapRequest.v1", 32 bytes, refused as "map_request" {
        /// Run whose map is wanted.
        run: [u64; 2] = RUN,
        /// Fingerprint of what the asker has: it gets no cells of the same map.
        observation: u64 = ANY,
        /// First index wanted; beyond the map there is nothing.
        from: u32 = ANY,
        /// Robot that is meant.
        robot: u32 = ROBOT,
    }
    of MapRequest { run, robot, from, observation }
}

wire! {
    /// A page of the map; the payload is its seen cells.
    pub struct MapPageV2 = "hop.MapPage.v2", 256 bytes, refused as "map" {
        /// Run it belongs to.
        run: [u64; 2] = RUN,
        /// Last decision folded in.
        through: u64 = COUNTED,
        /// Last patch published: the next one goes on this map.
        sequence: u64 = at_most(PATCHES_MAX),
        /// Fingerprint of the whole map.
        observation: u64 = ANY,
        /// Pose folded in, monotonic nanoseconds.
        sensed_ns: u64 = ANY,
        /// Last patch published, monotonic nanoseconds.
        published_ns: u64 = ANY,
        /// Edge of a cell, metres.
        cell_size_m: f64 = CELL_SIZE => "map.grid",
        /// Columns.
        width: u32 = GRID_SIDE => "map.grid",
        /// Rows.
        height: u32 = GRID_SIDE => "map.grid",
        /// Cells that one hop spans.
        hop_cells: u32 = HOP_CELLS => "map.grid",
        /// Robot whose sensor it is.
        robot: u32 = ROBOT,
        /// First index of the stretch.
        from: u32 = by_hand("at most `next`"),
        /// First index after the stretch.
        next: u32 = by_hand("at most the cells of the grid"),
        /// Treasures seen and not yet collected.
        treasure_count: u32 = TREASURE_COUNT => "map.treasures",
        reserved: u32,
        /// Digest of the state whose pose was folded in last.
        digest: [u8; 32] = ANY,
        /// Cells (x, y) of these treasures; zero beyond their number.
        treasures: [[i32; 2]; TREASURES_MAX] = TREASURES,
    }
    of MapPage {
        run,
        robot,
        through: Decision(through),
        digest: Digest(digest),
        sequence,
        observation,
        sensed: MonotonicNs(sensed_ns),
        published: MonotonicNs(published_ns),
        grid,
        from,
        next,
        treasures,
        cells,
    }
    to_wire {
        let Grid { width, height, cell_size_m, hop_cells } = grid;
        let (treasure_count, treasures) = &treasures_to_wire(treasures);
    }
    from_wire(wire) {
        let grid = grid_from_wire("map.grid", [width, height], cell_size_m, hop_cells)?;
        let whole = grid.cells() as u32;
        if from > next || next > whole {
            let got = format!("{from} to {next}");
            return Err(Refusal::malformed("map.next", &format!("a stretch within 0 to {whole}"), got));
        }
        let treasures = treasures_from_wire("map.treasures", &grid, treasure_count, &treasures)?;
        let cells = seen_cells_from_wire(cells, MAP_PAGE_CELLS, from, next)?;
    }
    /// The page of a copied answer.
    ///
    /// # Errors
    /// As [`patch_from_wire`], and if the stretch is none or a cell lies outside of it.
    pub fn map_page_from_wire(cells: &[SeenCellV4]);
}

wire! {
    /// What is known of a seen cell.
    pub struct SeenCellV4 = "hop.SeenCell.v4", 32 bytes, refused as "cell" {
        /// Height above the datum, metres.
        height_m: f64 = LENGTH,
        /// Gradient (∂h/∂x, ∂h/∂y), metres per metre.
        gradient: [f64; 2] = GRADIENT,
        /// Row-major index, which orders the cells of a message.
        index: u32 = by_hand("within the stretch, in order"),
        /// How often rovers have entered it.
        visits: u16 = ANY,
        /// Soil, speed and reading, as in `hop.Ground.v2`; where no robot can stand, with the other lowest bit.
        soil: u8 = SEEN_SOIL,
        /// What sensors report of it beside its ground; 0 if nothing.
        reported: u8 = ANY,
    }
    of SeenCell {
        index,
        visits,
        ground: Ground { height_m, gradient, soil, passable, speed, reading, reported },
    }
    to_wire {
        let soil = &(*soil, *speed, *reading, *passable);
        let reported = &reported.map_or(0, NonZeroU8::get);
    }
    from_wire(wire) {
        let (soil, speed, reading, passable) = soil;
        let reported = NonZeroU8::new(reported);
    }
}

/// At most `most` cells with indices from `from` on and below `next`, in order.
fn seen_cells_from_wire(
    cells: &[SeenCellV4],
    most: usize,
    from: u32,
    next: u32,
) -> Result<Vec<SeenCell>, Refusal> {
    cells_at_most("map.cells", most, cells)?;
    // Into room made beforehand: collecting results would grow the vector again and again.
    let mut seen = Vec::with_capacity(cells.len());
    let mut least = from;
    for wire in cells {
        if !(least..next).contains(&wire.index) {
            let need = format!("{least} to {} in order", next.saturating_sub(1));
            return Err(Refusal::malformed("cell.index", &need, wire.index));
        }
        least = wire.index + 1;
        seen.push(SeenCell::try_from(wire)?);
    }
    Ok(seen)
}

slice_payload!(MapPatch => MapPatchV2, SeenCellV4, cells, patch_from_wire);

/// Wakes planners. A late reader asks for the map ([`MapRequest`]), and so does every reader after a landing of
/// more patches than the buffer holds: one that reveals more than 16,384 cells, which no sensor of the built-in
/// scenarios can.
impl Message for MapPatch {
    const SERVICE: PublishSubscribe = PublishSubscribe {
        max_subscribers: 24,
        history: 0,
        buffer: 16,
        event: true,
        capacity: Capacity::Cells(MAP_PATCH_CELLS),
        ..PublishSubscribe::new("hop/map", &[Role::Perception])
    };
}

fixed_payload!(MapRequest => MapRequestV1);

slice_payload!(MapPage => MapPageV2, SeenCellV4, cells, map_page_from_wire);

/// The map for whoever has missed a patch.
impl Request for MapRequest {
    type Response = MapPage;
    const SERVICE: RequestResponse = RequestResponse {
        name: "hop/snapshot",
        server: Role::Perception,
        max_clients: 24,
        page: MAP_PAGE_CELLS,
    };
}
