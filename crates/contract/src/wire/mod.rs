//! What crosses shared memory.
//!
//! Every type is `#[repr(C)]`, made of integers and floats only, without padding (`bytemuck::Pod`
//! proves all three at compile time), and has its size asserted. iceoryx2 compares only name, size
//! and alignment when a service is opened, so **a changed layout takes a new version in the name**.
//!
//! A reader copies first, then validates: the writer could still write after sending. Each type
//! converts `From<&Domain>`; the way back is `TryFrom`, which refuses with a [`Refusal`].
//!
//! A field without a line of its own means what the field of that name means in the domain type. A run is two
//! halves, the high one first; `reserved` is written as 0 and not read.

#![allow(missing_docs, reason = "a field means what it means in the domain type, which says so")]

mod brief;
mod command;
mod control;
mod ground;
mod heartbeat;
mod map;
mod past;
mod policy;
mod prior;
mod route;
mod state;
mod team;
mod truth;

pub use brief::{BriefV9, DesignV1, SoilMotionV1};
pub use command::CommandV3;
pub use control::{ControlV1, TempoV1};
pub use ground::GroundV2;
pub use heartbeat::HeartbeatV2;
pub use map::{MapPageV2, MapPatchV2, MapRequestV1, SeenCellV3, map_page_from_wire, patch_from_wire};
pub use past::{PastHeaderV1, PastRequestV1, RecordV4, page_from_wire};
pub use policy::{PolicyCellV1, PolicyHeaderV1, policy_from_wire};
pub use prior::{PriorCellV1, PriorPageV1, PriorRequestV1, prior_page_from_wire};
pub use route::{
    AnnouncementV1, RoutePageV1, RouteRequestV1, WaypointV1, announcement_from_wire, route_page_from_wire,
};
pub use state::StateV4;
pub use team::{MemberV5, TeamHeaderV1, team_from_wire};
pub use truth::{TruthPageV1, TruthRequestV1, truth_page_from_wire};

use bytemuck::{Pod, Zeroable};

use crate::limits::{DECISIONS_MAX, GRADIENT_MAX, LENGTH_MAX_M, STEPS_MAX, TREASURES_MAX};
use crate::message::Visitor;
pub use crate::message::Wire;
use crate::{
    Action, Branch, Cell, Collected, Flight, Grid, Incarnation, Leader, MonotonicNs, Name, Outcome, Pose,
    Refusal, RobotId, RunId, Term, Timing, Vetoed,
};
use crate::{
    Announcement, Brief, Command, Control, Heartbeat, MapPatch, MapRequest, Pacing, PastRequest, Policy,
    PriorRequest, RouteRequest, State, Team, TruthRequest,
};

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
}

/// A lattice within bounds.
pub(crate) fn grid_from_wire(
    field: &str,
    [width, height]: [u32; 2],
    cell_size_m: f64,
    hop_cells: u32,
) -> Result<Grid, Refusal> {
    Grid::new(width, height, cell_size_m, hop_cells)
        .map_err(|error| Refusal::malformed(field, "a grid within bounds", error))
}

/// Refuses more than `most` cells.
pub(crate) fn at_most<C>(field: &str, most: usize, cells: &[C]) -> Result<(), Refusal> {
    if cells.len() <= most {
        Ok(())
    } else {
        Err(Refusal::malformed(field, &format!("at most {most} cells"), cells.len()))
    }
}

/// The run nonce: high half, then low half.
pub(crate) fn run_to_wire(run: RunId) -> [u64; 2] {
    [(run.0 >> 64) as u64, run.0 as u64]
}

pub(crate) fn run_from_wire(halves: [u64; 2]) -> RunId {
    RunId(u128::from(halves[0]) << 64 | u128::from(halves[1]))
}

pub(crate) fn robot_from_wire(robot: u32) -> Result<RobotId, Refusal> {
    u16::try_from(robot).map(RobotId).map_err(|_| Refusal::WrongRobot { robots: u16::MAX, got: robot })
}

pub(crate) fn name_from_wire(field: &str, bytes: [u8; Name::BYTES]) -> Result<Name, Refusal> {
    Name::from_bytes(bytes).map_err(|error| Refusal::malformed(field, "printable ASCII", error.got))
}

/// A float within `min..=max`; NaN is never within.
pub(crate) fn float(field: &str, value: f64, min: f64, max: f64) -> Result<f64, Refusal> {
    if (min..=max).contains(&value) {
        Ok(value)
    } else {
        Err(Refusal::malformed(field, &format!("{min} to {max}"), value))
    }
}

pub(crate) fn length(field: &str, value_m: f64) -> Result<f64, Refusal> {
    float(field, value_m, -LENGTH_MAX_M, LENGTH_MAX_M)
}

pub(crate) fn gradient(field: &str, value: [f64; 2]) -> Result<[f64; 2], Refusal> {
    for component in value {
        float(field, component, -GRADIENT_MAX, GRADIENT_MAX)?;
    }
    Ok(value)
}

/// A tag that `decode` knows.
pub(crate) fn tag<T>(field: &str, code: u32, decode: impl Fn(u32) -> Option<T>) -> Result<T, Refusal> {
    decode(code).ok_or_else(|| Refusal::malformed(field, "a known tag", code))
}

/// A decision or term that leaves room to count on.
pub(crate) fn counted(field: &str, value: u64) -> Result<u64, Refusal> {
    if value <= DECISIONS_MAX {
        Ok(value)
    } else {
        Err(Refusal::malformed(field, &format!("at most {DECISIONS_MAX}"), value))
    }
}

/// Steps that a run can come to.
pub(crate) fn steps(field: &str, value: u64) -> Result<u64, Refusal> {
    if value <= STEPS_MAX {
        Ok(value)
    } else {
        Err(Refusal::malformed(field, &format!("at most {STEPS_MAX}"), value))
    }
}

/// A mark for each treasure collected.
pub(crate) fn collected(field: &str, marks: u32) -> Result<Collected, Refusal> {
    if marks >> TREASURES_MAX == 0 {
        Ok(Collected(marks))
    } else {
        Err(Refusal::malformed(field, &format!("at most {TREASURES_MAX} marks"), format!("{marks:#b}")))
    }
}

/// A mark for each vetoed action.
pub(crate) fn vetoed(field: &str, marks: u32) -> Result<Vetoed, Refusal> {
    if marks >> Action::CODES == 0 {
        Ok(Vetoed(marks))
    } else {
        Err(Refusal::malformed(field, &format!("at most {} marks", Action::CODES), format!("{marks:#b}")))
    }
}

/// Treasures as a list of fixed length, the rest zero, with how many there are.
pub(crate) fn treasures_to_wire(treasures: &[Cell]) -> (u32, [[i32; 2]; TREASURES_MAX]) {
    assert!(treasures.len() <= TREASURES_MAX, "at most {TREASURES_MAX} treasures, got {}", treasures.len());
    let mut cells = [[0; 2]; TREASURES_MAX];
    for (wire, treasure) in cells.iter_mut().zip(treasures) {
        *wire = cell_to_wire(*treasure);
    }
    (treasures.len() as u32, cells)
}

/// Treasures on `grid`, each on a cell of its own and in index order.
pub(crate) fn treasures_from_wire(
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
        let cell = cell_from_wire(field, *cell)?;
        let index = grid.index(cell);
        if index.is_none() || index <= last {
            return Err(Refusal::malformed(field, "cells on the grid in index order, each once", cell));
        }
        last = index;
        treasures.push(cell);
    }
    Ok(treasures)
}

/// 0 or 1.
pub(crate) fn flag(field: &str, code: u32) -> Result<bool, Refusal> {
    tag(field, code, |code| match code {
        0 => Some(false),
        1 => Some(true),
        _ => None,
    })
}

/// A cell as (x, y).
pub(crate) fn cell_from_wire(field: &str, [x, y]: [i32; 2]) -> Result<Cell, Refusal> {
    const FAR: i32 = 1 << 20;
    if (-FAR..=FAR).contains(&x) && (-FAR..=FAR).contains(&y) {
        Ok(Cell::new(x, y))
    } else {
        Err(Refusal::malformed(field, "a cell on or next to the grid", Cell::new(x, y)))
    }
}

pub(crate) fn cell_to_wire(cell: Cell) -> [i32; 2] {
    [cell.x, cell.y]
}

pub(crate) fn timing_to_wire(timing: &Timing) -> [u64; 8] {
    timing.moments().map(|moment| moment.0)
}

pub(crate) fn timing_from_wire(moments: [u64; 8]) -> Timing {
    Timing::from_moments(moments.map(MonotonicNs))
}

/// Outcome part of a message.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct OutcomeV1 {
    /// [`Branch::code`]; 0 where there is no outcome yet.
    pub branch: u32,
    pub flights: u32,
    /// Departure (x, y), cells.
    pub from: [i32; 2],
    /// Landing (x, y), cells.
    pub to: [i32; 2],
    /// Launch speed, m/s.
    pub launch_speed_mps: f64,
    /// Launch angle, radians.
    pub launch_angle_rad: f64,
    /// Range of one flight, metres.
    pub range_m: f64,
    /// Rise from launch to landing, metres.
    pub rise_m: f64,
    /// Apex above the launch, metres.
    pub apex_height_m: f64,
    /// Time of one flight, seconds.
    pub flight_time_s: f64,
}

impl From<&Outcome> for OutcomeV1 {
    fn from(outcome: &Outcome) -> Self {
        let flight = &outcome.flight;
        Self {
            branch: outcome.branch.code(),
            flights: flight.flights,
            from: cell_to_wire(outcome.from),
            to: cell_to_wire(outcome.to),
            launch_speed_mps: flight.launch_speed_mps,
            launch_angle_rad: flight.launch_angle_rad,
            range_m: flight.range_m,
            rise_m: flight.rise_m,
            apex_height_m: flight.apex_height_m,
            flight_time_s: flight.flight_time_s,
        }
    }
}

impl TryFrom<&OutcomeV1> for Outcome {
    type Error = Refusal;

    fn try_from(wire: &OutcomeV1) -> Result<Self, Refusal> {
        Ok(Self {
            branch: tag("outcome.branch", wire.branch, Branch::from_code)?,
            from: cell_from_wire("outcome.from", wire.from)?,
            to: cell_from_wire("outcome.to", wire.to)?,
            flight: Flight {
                launch_speed_mps: float("flight.launch_speed_mps", wire.launch_speed_mps, 0.0, 1.0e5)?,
                launch_angle_rad: float("flight.launch_angle_rad", wire.launch_angle_rad, 0.0, 1.6)?,
                range_m: length("flight.range_m", wire.range_m)?,
                rise_m: length("flight.rise_m", wire.rise_m)?,
                apex_height_m: length("flight.apex_height_m", wire.apex_height_m)?,
                flight_time_s: float("flight.flight_time_s", wire.flight_time_s, 0.0, 1.0e6)?,
                flights: if wire.flights <= 2 {
                    wire.flights
                } else {
                    return Err(Refusal::malformed("flight.flights", "at most 2", wire.flights));
                },
            },
        })
    }
}

/// Who commands, as part of a message.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct LeaderV1 {
    pub term: u64,
    /// Life of the planner.
    pub incarnation: u64,
    /// Process of the planner.
    pub pid: u32,
    pub reserved: u32,
    /// Algorithm, zero-padded ASCII.
    pub planner: [u8; Name::BYTES],
}

impl From<&Leader> for LeaderV1 {
    fn from(leader: &Leader) -> Self {
        Self {
            term: leader.term.0,
            incarnation: leader.incarnation.0,
            pid: leader.pid,
            reserved: 0,
            planner: leader.planner.bytes(),
        }
    }
}

impl TryFrom<&LeaderV1> for Leader {
    type Error = Refusal;

    fn try_from(wire: &LeaderV1) -> Result<Self, Refusal> {
        Ok(Self {
            term: Term(counted("leader.term", wire.term)?),
            incarnation: Incarnation(wire.incarnation),
            pid: wire.pid,
            planner: name_from_wire("leader.planner", wire.planner)?,
        })
    }
}

/// A pose as part of a message.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PoseV1 {
    /// Cell (x, y).
    pub cell: [i32; 2],
    /// Height above the datum, metres.
    pub height_m: f64,
}

impl From<&Pose> for PoseV1 {
    fn from(pose: &Pose) -> Self {
        Self { cell: cell_to_wire(pose.cell), height_m: pose.height_m }
    }
}

impl TryFrom<&PoseV1> for Pose {
    type Error = Refusal;

    fn try_from(wire: &PoseV1) -> Result<Self, Refusal> {
        Ok(Self {
            cell: cell_from_wire("pose.cell", wire.cell)?,
            height_m: length("pose.height_m", wire.height_m)?,
        })
    }
}

const _: () = assert!(size_of::<OutcomeV1>() == 72);
const _: () = assert!(size_of::<LeaderV1>() == 56);
const _: () = assert!(size_of::<PoseV1>() == 16);
