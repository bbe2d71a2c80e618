//! `hop/rN/map` and `hop/rN/snapshot`.

use bytemuck::{Pod, Zeroable};

use crate::Role;
use crate::{fixed_payload, slice_payload};

use super::ground::{soil_code, soil_from_code};
use super::{
    Wire, at_most, counted, flag, gradient, grid_from_wire, length, robot_from_wire, run_from_wire,
    run_to_wire, treasures_from_wire, treasures_to_wire,
};
use crate::limits::{MAP_PAGE_CELLS, MAP_PATCH_CELLS, PATCHES_MAX, TREASURES_MAX};
use crate::message::{Capacity, Message, PublishSubscribe, Request, RequestResponse};
use crate::{Decision, Digest, Ground, MapPage, MapPatch, MapRequest, MonotonicNs, Refusal, SeenCell};

/// A patch: what a landing changed in the map, or a part of that; the payload is its cells.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MapPatchV2 {
    pub run: [u64; 2],
    /// Decision of the landing.
    pub through: u64,
    /// Place in the run's stream of patches, from 1.
    pub sequence: u64,
    /// Fingerprint of the map that it goes on.
    pub before: u64,
    /// Fingerprint of the map with its cells.
    pub after: u64,
    /// Pose folded in, monotonic nanoseconds.
    pub sensed_ns: u64,
    /// Published, monotonic nanoseconds.
    pub published_ns: u64,
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    pub width: u32,
    pub height: u32,
    /// Cells that one hop spans.
    pub hop_cells: u32,
    pub robot: u32,
    /// Seen cells of the map with its cells.
    pub seen_cells: u32,
    /// Parts of the same landing that follow.
    pub more: u32,
    /// Treasures seen and not yet collected.
    pub treasure_count: u32,
    pub reserved: u32,
    /// Digest of the state whose pose was folded in last.
    pub digest: [u8; 32],
    /// Their cells (x, y) in index order; zero beyond the count.
    pub treasures: [[i32; 2]; TREASURES_MAX],
}

/// Asks for the map from an index on.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct MapRequestV1 {
    pub run: [u64; 2],
    /// Fingerprint of what the asker has.
    pub observation: u64,
    pub from: u32,
    pub robot: u32,
}

/// A page of the map; the payload is its seen cells.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MapPageV2 {
    pub run: [u64; 2],
    /// Last decision folded in.
    pub through: u64,
    /// Last patch published.
    pub sequence: u64,
    /// Fingerprint of the whole map.
    pub observation: u64,
    /// Pose folded in, monotonic nanoseconds.
    pub sensed_ns: u64,
    /// Last patch published, monotonic nanoseconds.
    pub published_ns: u64,
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    pub width: u32,
    pub height: u32,
    /// Cells that one hop spans.
    pub hop_cells: u32,
    pub robot: u32,
    /// First index of the stretch.
    pub from: u32,
    /// First index after the stretch.
    pub next: u32,
    /// Treasures seen and not yet collected.
    pub treasure_count: u32,
    pub reserved: u32,
    /// Digest of the state whose pose was folded in last.
    pub digest: [u8; 32],
    /// Their cells (x, y) in index order; zero beyond the count.
    pub treasures: [[i32; 2]; TREASURES_MAX],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SeenCellV3 {
    /// Height above the datum, metres.
    pub height_m: f64,
    /// Gradient (∂h/∂x, ∂h/∂y), metres per metre.
    pub gradient: [f64; 2],
    pub index: u32,
    /// How often rovers have entered it.
    pub visits: u16,
    /// As in [`super::GroundV2`]: 1 hard, 2 sand, plus 16 for each speed up to the cell's.
    pub soil: u8,
    /// 1 where a robot can stand.
    pub passable: u8,
}

const _: () = assert!(size_of::<MapPatchV2>() == 264);
const _: () = assert!(size_of::<MapRequestV1>() == 32);
const _: () = assert!(size_of::<MapPageV2>() == 256);
const _: () = assert!(size_of::<SeenCellV3>() == 32);

impl Wire for MapPatchV2 {
    const NAME: &'static str = "hop.MapPatch.v2";
}

impl Wire for MapRequestV1 {
    const NAME: &'static str = "hop.MapRequest.v1";
}

impl Wire for MapPageV2 {
    const NAME: &'static str = "hop.MapPage.v2";
}

impl Wire for SeenCellV3 {
    const NAME: &'static str = "hop.SeenCell.v3";
}

impl From<&SeenCell> for SeenCellV3 {
    #[inline]
    fn from(cell: &SeenCell) -> Self {
        Self {
            height_m: cell.ground.height_m,
            gradient: cell.ground.gradient,
            index: cell.index,
            soil: soil_code(&cell.ground) as u8,
            visits: cell.visits,
            passable: u8::from(cell.ground.passable),
        }
    }
}

impl TryFrom<&SeenCellV3> for SeenCell {
    type Error = Refusal;

    #[inline]
    fn try_from(wire: &SeenCellV3) -> Result<Self, Refusal> {
        let (soil, speed, reading) = soil_from_code("cell.soil", wire.soil.into())?;
        let ground = Ground {
            height_m: length("cell.height_m", wire.height_m)?,
            gradient: gradient("cell.gradient", wire.gradient)?,
            soil,
            passable: flag("cell.passable", wire.passable.into())?,
            speed,
            reading,
        };
        Ok(Self { index: wire.index, visits: wire.visits, ground })
    }
}

impl From<&MapPatch> for MapPatchV2 {
    fn from(patch: &MapPatch) -> Self {
        let (treasure_count, treasures) = treasures_to_wire(&patch.treasures);
        Self {
            run: run_to_wire(patch.run),
            through: patch.through.0,
            digest: patch.digest.0,
            sequence: patch.sequence,
            before: patch.before,
            after: patch.after,
            sensed_ns: patch.sensed.0,
            published_ns: patch.published.0,
            cell_size_m: patch.grid.cell_size_m,
            width: patch.grid.width,
            height: patch.grid.height,
            hop_cells: patch.grid.hop_cells,
            robot: u32::from(patch.robot.0),
            seen_cells: patch.seen_cells,
            more: patch.more,
            treasure_count,
            reserved: 0,
            treasures,
        }
    }
}

impl From<&MapPage> for MapPageV2 {
    fn from(page: &MapPage) -> Self {
        let (treasure_count, treasures) = treasures_to_wire(&page.treasures);
        Self {
            run: run_to_wire(page.run),
            through: page.through.0,
            digest: page.digest.0,
            sequence: page.sequence,
            observation: page.observation,
            sensed_ns: page.sensed.0,
            published_ns: page.published.0,
            cell_size_m: page.grid.cell_size_m,
            width: page.grid.width,
            height: page.grid.height,
            hop_cells: page.grid.hop_cells,
            robot: u32::from(page.robot.0),
            from: page.from,
            next: page.next,
            treasure_count,
            reserved: 0,
            treasures,
        }
    }
}

impl From<&MapRequest> for MapRequestV1 {
    fn from(request: &MapRequest) -> Self {
        Self {
            run: run_to_wire(request.run),
            observation: request.observation,
            from: request.from,
            robot: u32::from(request.robot.0),
        }
    }
}

impl TryFrom<&MapRequestV1> for MapRequest {
    type Error = Refusal;

    fn try_from(wire: &MapRequestV1) -> Result<Self, Refusal> {
        Ok(Self {
            run: run_from_wire(wire.run),
            robot: robot_from_wire(wire.robot)?,
            from: wire.from,
            observation: wire.observation,
        })
    }
}

/// The patch of a copied message.
///
/// # Errors
/// If the lattice or a number is out of range, there are too many cells, or one is out of range, off the
/// lattice or out of order.
pub fn patch_from_wire(header: &MapPatchV2, cells: &[SeenCellV3]) -> Result<MapPatch, Refusal> {
    let size = [header.width, header.height];
    let grid = grid_from_wire("map.grid", size, header.cell_size_m, header.hop_cells)?;
    let whole = grid.cells() as u32;
    if header.seen_cells > whole {
        let need = format!("at most {whole}");
        return Err(Refusal::malformed("map.seen_cells", &need, header.seen_cells));
    }
    if header.more > whole {
        return Err(Refusal::malformed("map.more", &format!("at most {whole}"), header.more));
    }
    Ok(MapPatch {
        run: run_from_wire(header.run),
        robot: robot_from_wire(header.robot)?,
        through: through(header.through)?,
        digest: Digest(header.digest),
        more: header.more,
        sequence: sequence(header.sequence)?,
        before: header.before,
        after: header.after,
        sensed: MonotonicNs(header.sensed_ns),
        published: MonotonicNs(header.published_ns),
        grid,
        seen_cells: header.seen_cells,
        treasures: treasures_from_wire("map.treasures", &grid, header.treasure_count, &header.treasures)?,
        cells: seen_cells(cells, MAP_PATCH_CELLS, 0, whole)?,
    })
}

/// The page of a copied answer.
///
/// # Errors
/// As [`patch_from_wire`], and if the stretch is none or a cell lies outside of it.
pub fn map_page_from_wire(header: &MapPageV2, cells: &[SeenCellV3]) -> Result<MapPage, Refusal> {
    let size = [header.width, header.height];
    let grid = grid_from_wire("map.grid", size, header.cell_size_m, header.hop_cells)?;
    let whole = grid.cells() as u32;
    let (from, next) = (header.from, header.next);
    if from > next || next > whole {
        let got = format!("{from} to {next}");
        return Err(Refusal::malformed("map.next", &format!("a stretch within 0 to {whole}"), got));
    }
    Ok(MapPage {
        run: run_from_wire(header.run),
        robot: robot_from_wire(header.robot)?,
        through: through(header.through)?,
        digest: Digest(header.digest),
        sequence: sequence(header.sequence)?,
        observation: header.observation,
        sensed: MonotonicNs(header.sensed_ns),
        published: MonotonicNs(header.published_ns),
        grid,
        from,
        next,
        treasures: treasures_from_wire("map.treasures", &grid, header.treasure_count, &header.treasures)?,
        cells: seen_cells(cells, MAP_PAGE_CELLS, from, next)?,
    })
}

fn through(decision: u64) -> Result<Decision, Refusal> {
    counted("map.through", decision).map(Decision)
}

fn sequence(sequence: u64) -> Result<u64, Refusal> {
    if sequence <= PATCHES_MAX {
        Ok(sequence)
    } else {
        Err(Refusal::malformed("map.sequence", &format!("at most {PATCHES_MAX}"), sequence))
    }
}

/// At most `most` cells with indices from `from` on and below `next`, in order.
fn seen_cells(cells: &[SeenCellV3], most: usize, from: u32, next: u32) -> Result<Vec<SeenCell>, Refusal> {
    at_most("map.cells", most, cells)?;
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

slice_payload!(MapPatch => MapPatchV2, SeenCellV3, cells, patch_from_wire);

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
        ..PublishSubscribe::new("hop/rN/map", &[Role::Perception])
    };
}

fixed_payload!(MapRequest => MapRequestV1);

slice_payload!(MapPage => MapPageV2, SeenCellV3, cells, map_page_from_wire);

/// The map for whoever has missed a patch.
impl Request for MapRequest {
    type Response = MapPage;
    const SERVICE: RequestResponse = RequestResponse {
        name: "hop/rN/snapshot",
        server: Role::Perception,
        max_clients: 24,
        page: MAP_PAGE_CELLS,
    };
}
