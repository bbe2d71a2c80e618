//! Request, header and record of `hop/past`.

use bytemuck::{Pod, Zeroable};

use crate::Role;
use crate::{fixed_payload, slice_payload};

use super::{
    LeaderV1, OutcomeV1, PoseV1, Wire, collected, counted, flag, robot_from_wire, run_from_wire, run_to_wire,
    steps, tag, timing_from_wire, timing_to_wire, vetoed,
};
use crate::limits::{DECISIONS_MAX, PAST_PAGE_RECORDS};
use crate::message::{Request, RequestResponse};
use crate::{Action, Decision, Digest, Origin, PastPage, PastRequest, Record, Refusal, Status};

/// Asks for records from a decision on.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct PastRequestV1 {
    pub run: [u64; 2],
    pub from: u64,
    pub robot: u32,
    pub reserved: u32,
}

/// Header of a page; the payload is its records.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct PastHeaderV1 {
    pub run: [u64; 2],
    /// Decision of the first record.
    pub from: u64,
    pub robot: u32,
    pub reserved: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct RecordV4 {
    pub decision: u64,
    /// Fingerprint of the map it was decided on.
    pub observation: u64,
    /// Work the planner did.
    pub work: u64,
    /// Steps afterwards.
    pub steps: u64,
    /// Goals visited so far.
    pub visits: u64,
    pub robot: u32,
    /// [`Action::code`].
    pub action: u32,
    /// 1 if a budget cut the work short.
    pub cut: u32,
    /// [`Status::code`] afterwards.
    pub status: u32,
    /// Treasures collected, one bit each.
    pub collected: u32,
    /// Who chose the action: [`Origin::code`].
    pub origin: u32,
    /// Actions vetoed before it, one bit each.
    pub vetoed: u32,
    pub reserved: u32,
    pub leader: LeaderV1,
    /// What became of it.
    pub outcome: OutcomeV1,
    /// Pose afterwards.
    pub pose: PoseV1,
    /// Moments, monotonic nanoseconds.
    pub timing_ns: [u64; 8],
    /// Digest before.
    pub previous: [u8; 32],
    /// Digest after.
    pub digest: [u8; 32],
    /// Fingerprint of the route that was announced; 0 for none.
    pub route: u64,
}

const _: () = assert!(size_of::<PastRequestV1>() == 32);
const _: () = assert!(size_of::<PastHeaderV1>() == 32);
const _: () = assert!(size_of::<RecordV4>() == 352);

impl Wire for PastRequestV1 {
    const NAME: &'static str = "hop.PastRequest.v1";
}

impl Wire for PastHeaderV1 {
    const NAME: &'static str = "hop.PastHeader.v1";
}

impl Wire for RecordV4 {
    const NAME: &'static str = "hop.Record.v4";
}

impl From<&PastRequest> for PastRequestV1 {
    fn from(request: &PastRequest) -> Self {
        Self {
            run: run_to_wire(request.run),
            from: request.from.0,
            robot: u32::from(request.robot.0),
            reserved: 0,
        }
    }
}

impl TryFrom<&PastRequestV1> for PastRequest {
    type Error = Refusal;

    fn try_from(wire: &PastRequestV1) -> Result<Self, Refusal> {
        if wire.from > DECISIONS_MAX {
            return Err(Refusal::malformed("past.from", &format!("at most {DECISIONS_MAX}"), wire.from));
        }
        Ok(Self {
            run: run_from_wire(wire.run),
            robot: robot_from_wire(wire.robot)?,
            from: Decision(wire.from),
        })
    }
}

impl From<&PastPage> for PastHeaderV1 {
    fn from(page: &PastPage) -> Self {
        Self { run: run_to_wire(page.run), from: page.from.0, robot: u32::from(page.robot.0), reserved: 0 }
    }
}

impl From<&Record> for RecordV4 {
    fn from(record: &Record) -> Self {
        Self {
            decision: record.decision.0,
            observation: record.observation,
            work: record.work,
            steps: record.steps,
            visits: record.visits,
            robot: u32::from(record.robot.0),
            action: record.action.code(),
            cut: u32::from(record.cut),
            status: record.status.code(),
            collected: record.collected.0,
            origin: record.origin.code(),
            vetoed: record.vetoed.0,
            reserved: 0,
            leader: (&record.leader).into(),
            outcome: (&record.outcome).into(),
            pose: (&record.pose).into(),
            timing_ns: timing_to_wire(&record.timing),
            previous: record.previous.0,
            digest: record.digest.0,
            route: record.action.route(),
        }
    }
}

impl TryFrom<&RecordV4> for Record {
    type Error = Refusal;

    fn try_from(wire: &RecordV4) -> Result<Self, Refusal> {
        Ok(Self {
            robot: robot_from_wire(wire.robot)?,
            decision: Decision(counted("record.decision", wire.decision)?),
            leader: (&wire.leader).try_into()?,
            action: tag("record.action", wire.action, |code| Action::with_route(code, wire.route))?,
            origin: tag("record.origin", wire.origin, Origin::from_code)?,
            vetoed: vetoed("record.vetoed", wire.vetoed)?,
            observation: wire.observation,
            work: wire.work,
            cut: flag("record.cut", wire.cut)?,
            outcome: (&wire.outcome).try_into()?,
            pose: (&wire.pose).try_into()?,
            collected: collected("record.collected", wire.collected)?,
            steps: steps("record.steps", wire.steps)?,
            visits: counted("record.visits", wire.visits)?,
            status: tag("record.status", wire.status, Status::from_code)?,
            timing: timing_from_wire(wire.timing_ns),
            previous: Digest(wire.previous),
            digest: Digest(wire.digest),
        })
    }
}

/// The page of a copied answer.
///
/// # Errors
/// If it is too long, a record is malformed, or its decisions are not consecutive.
pub fn page_from_wire(header: &PastHeaderV1, records: &[RecordV4]) -> Result<PastPage, Refusal> {
    if records.len() > PAST_PAGE_RECORDS {
        return Err(Refusal::malformed(
            "past.records",
            &format!("at most {PAST_PAGE_RECORDS}"),
            records.len(),
        ));
    }
    let from = counted("past.from", header.from)?;
    let records = records.iter().map(Record::try_from).collect::<Result<Vec<_>, _>>()?;
    for (record, due) in records.iter().zip(from..) {
        if record.decision.0 != due {
            return Err(Refusal::malformed("past.decision", &due.to_string(), record.decision));
        }
    }
    Ok(PastPage {
        run: run_from_wire(header.run),
        robot: robot_from_wire(header.robot)?,
        from: Decision(from),
        records,
    })
}

fixed_payload!(PastRequest => PastRequestV1);

slice_payload!(PastPage => PastHeaderV1, RecordV4, records, page_from_wire);

/// The journal's public projection.
impl Request for PastRequest {
    type Response = PastPage;
    const SERVICE: RequestResponse = RequestResponse {
        name: "hop/past",
        server: Role::HopperSim,
        max_clients: 16,
        page: PAST_PAGE_RECORDS,
    };
}
