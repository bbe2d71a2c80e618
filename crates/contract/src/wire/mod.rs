//! What crosses shared memory.
//!
//! Every type is `#[repr(C)]`, made of integers and floats only, without padding (`bytemuck::Pod`
//! proves all three at compile time), and has its size asserted. iceoryx2 compares only name, size
//! and alignment when a service is opened, so **a changed layout takes a new version in the name**.
//!
//! A reader copies first, then validates: the writer could still write after sending. Each type
//! converts `From<&Domain>`; the way back is `TryFrom`, which refuses with a [`Refusal`].
//!
//! All of this follows from one declaration a field, by the macro `wire!` of `declaration.rs`: its reason, its type, and
//! its range by a codec of `codec/`. `docs/messages.md` lists them. A field `reserved` is written as 0 and not read.

mod brief;
mod command;
mod control;
mod declaration;
mod detail;
mod ground;
mod heartbeat;
mod map;
mod past;
mod policy;
mod prior;
mod robot;
mod route;
mod state;
mod table;
mod team;
#[cfg(test)]
mod tests;
mod truth;

pub use brief::{BriefV10, brief_from_wire};
pub use command::CommandV3;
pub use control::{ControlV1, TempoV1};
pub use detail::{DetailPageV1, DetailRequestV1, PathPointV1, detail_page_from_wire};
pub use ground::{GroundV2, seen_soil, soil_of_seen};
pub use heartbeat::HeartbeatV2;
pub use map::{MapPageV2, MapPatchV2, MapRequestV1, SeenCellV4, map_page_from_wire, patch_from_wire};
pub use past::{PastHeaderV1, PastRequestV1, RecordV5, page_from_wire};
pub use policy::{PolicyCellV1, PolicyHeaderV1, policy_from_wire};
pub use prior::{PriorCellV1, PriorPageV1, PriorRequestV1, prior_page_from_wire};
pub use robot::RobotV1;
pub use route::{
    AnnouncementV1, RoutePageV1, RouteRequestV1, WaypointV1, announcement_from_wire, route_page_from_wire,
};
pub use state::StateV4;
pub use table::{MotionRowV1, TablePageV1, TableRequestV1, table_page_from_wire};
pub use team::{MemberV6, TeamHeaderV1, team_from_wire};
pub use truth::{TruthPageV1, TruthRequestV1, truth_page_from_wire};

use crate::codec::{
    ANY, ByHand, CELL, COUNTED, Codec, Float, LENGTH, NAME, Whole, at_most, by_hand, float, joint, tag,
    unknown_tag, whole,
};
pub use crate::field::Field;
use crate::limits::{CELL_SIZE_MIN_M, GRID_SIDE_MAX, LENGTH_MAX_M, TREASURES_MAX};
use crate::message::Visitor;
pub use crate::message::Wire;
use crate::{
    Action, Announcement, Branch, Brief, Cell, Command, Control, DetailRequest, Flight, Grid, Heartbeat,
    Incarnation, Leader, MapPatch, MapRequest, Name, Outcome, Pacing, PastRequest, Policy, Pose,
    PriorRequest, Refusal, RouteRequest, State, TableRequest, Team, Term, TruthRequest,
};
use declaration::wire;

/// Shows `visitor` every message and request: the one list of them.
pub fn visit(visitor: &mut impl Visitor) {
    visitor.message::<Brief>();
    visitor.message::<Heartbeat>();
    visitor.message::<State>();
    visitor.message::<Team>();
    visitor.message::<Command>();
    visitor.message::<Announcement>();
    visitor.message::<Control>();
    visitor.message::<Pacing>();
    visitor.message::<MapPatch>();
    visitor.message::<Policy>();
    visitor.request::<PastRequest>();
    visitor.request::<TruthRequest>();
    visitor.request::<MapRequest>();
    visitor.request::<PriorRequest>();
    visitor.request::<RouteRequest>();
    visitor.request::<DetailRequest>();
    visitor.request::<TableRequest>();
}

/// A side of a lattice, cells.
const GRID_SIDE: ByHand<(Whole, &str)> = joint(whole(1, GRID_SIDE_MAX as u64), "at most 2^20 cells in all");

/// The edge of a cell of a lattice, metres.
const CELL_SIZE: ByHand<(Float, &str)> = joint(float(CELL_SIZE_MIN_M, LENGTH_MAX_M), "no hopper is smaller");

/// The cells that one hop spans on a lattice.
const HOP_CELLS: ByHand<(Whole, &str)> =
    joint(whole(1, GRID_SIDE_MAX as u64), "a hop stays on the largest grid");

/// How many treasures there are in a list of fixed length.
const TREASURE_COUNT: ByHand<(Whole, &str)> =
    joint(at_most(TREASURES_MAX as u64), "the number of `treasures`");

/// Treasures in a list of fixed length.
const TREASURES: ByHand<&str> = by_hand("cells on the grid in index order, each once");

/// A lattice within bounds.
fn grid_from_wire(
    field: &str,
    [width, height]: [u32; 2],
    cell_size_m: f64,
    hop_cells: u32,
) -> Result<Grid, Refusal> {
    Grid::new(width, height, cell_size_m, hop_cells)
        .map_err(|error| Refusal::malformed(field, "a grid within bounds", error))
}

/// Refuses more than `most` cells.
fn cells_at_most<C>(field: &str, most: usize, cells: &[C]) -> Result<(), Refusal> {
    if cells.len() <= most {
        Ok(())
    } else {
        Err(Refusal::malformed(field, &format!("at most {most} cells"), cells.len()))
    }
}

/// An action with the route that it announces; 0 for none.
fn action_from_wire(field: &str, action: u32, route: u64) -> Result<Action, Refusal> {
    Action::with_route(action, route).ok_or_else(|| unknown_tag(field, action))
}

/// Treasures as a list of fixed length, the rest zero, with how many there are.
fn treasures_to_wire(treasures: &[Cell]) -> (u32, [[i32; 2]; TREASURES_MAX]) {
    assert!(treasures.len() <= TREASURES_MAX, "at most {TREASURES_MAX} treasures, got {}", treasures.len());
    let mut cells = [[0; 2]; TREASURES_MAX];
    for (wire, treasure) in cells.iter_mut().zip(treasures) {
        *wire = CELL.to_wire(treasure);
    }
    (treasures.len() as u32, cells)
}

/// Treasures on `grid`, each on a cell of its own and in index order.
fn treasures_from_wire(
    field: &str,
    grid: &Grid,
    count: u32,
    cells: &[[i32; 2]; TREASURES_MAX],
) -> Result<Vec<Cell>, Refusal> {
    let Some(cells) = cells.get(..count as usize) else {
        return Err(Refusal::malformed(field, &format!("at most {TREASURES_MAX} treasures"), count));
    };
    let mut treasures = Vec::with_capacity(cells.len());
    let mut last = None;
    for cell in cells {
        let cell = CELL.from_wire(field, *cell)?;
        let index = grid.index(cell);
        if index.is_none() || index <= last {
            return Err(Refusal::malformed(field, "cells on the grid in index order, each once", cell));
        }
        last = index;
        treasures.push(cell);
    }
    Ok(treasures)
}

wire! {
    /// What became of an action, as part of a message.
    pub struct OutcomeV1 = "hop.Outcome.v1", 72 bytes, refused as "outcome" {
        /// What happened; 0, and not read, where there is no outcome yet.
        branch: u32 = tag(Branch::code, Branch::from_code),
        /// Flights: none if it stayed, one a hop, or two half hops on sand.
        flights: u32 = at_most(2) => "flight.flights",
        /// Departure (x, y), cells.
        from: [i32; 2] = CELL,
        /// Landing (x, y), cells; next to the grid if it left the map.
        to: [i32; 2] = CELL,
        /// Launch speed, m/s; the upper end is more than the escape speed of any planet.
        launch_speed_mps: f64 = float(0.0, 1.0e5) => "flight.launch_speed_mps",
        /// Launch angle above the horizontal, radians; a little more than π/2, to allow for rounding.
        launch_angle_rad: f64 = float(0.0, 1.6) => "flight.launch_angle_rad",
        /// Range of one flight, metres.
        range_m: f64 = LENGTH => "flight.range_m",
        /// Rise from launch to landing, metres.
        rise_m: f64 = LENGTH => "flight.rise_m",
        /// Apex above the launch, metres.
        apex_height_m: f64 = LENGTH => "flight.apex_height_m",
        /// Time of one flight or drive, seconds; 11 days at most.
        flight_time_s: f64 = float(0.0, 1.0e6) => "flight.flight_time_s",
    }
    of Outcome {
        branch,
        from,
        to,
        flight: Flight {
            launch_speed_mps, launch_angle_rad, range_m, rise_m, apex_height_m, flight_time_s, flights,
        },
    }
}

wire! {
    /// Who commands, as part of a message.
    pub struct LeaderV1 = "hop.Leader.v1", 56 bytes, refused as "leader" {
        /// Term it commands under; the next planner takes the next, so it leaves room to count on.
        term: u64 = COUNTED,
        /// Life of the planner; 0 for none.
        incarnation: u64 = ANY,
        /// Process of the planner, for people; 0 in lockstep.
        pid: u32 = ANY,
        reserved: u32,
        /// Algorithm of the planner.
        planner: [u8; Name::BYTES] = NAME,
    }
    of Leader { term: Term(term), incarnation: Incarnation(incarnation), pid, planner }
}

wire! {
    /// Where a robot is, as part of a message.
    pub struct PoseV1 = "hop.Pose.v1", 16 bytes, refused as "pose" {
        /// Cell (x, y); next to the grid once it has left the map.
        cell: [i32; 2] = CELL,
        /// Height of the ground above the datum, metres.
        height_m: f64 = LENGTH,
    }
    of Pose { cell, height_m }
}
