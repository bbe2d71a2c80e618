//! Request, header and record of `hop/past`.

use crate::Role;
use crate::{fixed_payload, slice_payload};

use super::declaration::wire;
use super::{LeaderV1, OutcomeV1, PoseV1, action_from_wire};
use crate::codec::{
    ACTION_BITS, ANY, COUNTED, FLAG, MOMENTS, ROBOT, RUN, STEPS, TREASURE_BITS, by_hand, part, tag,
};
use crate::limits::PAST_PAGE_RECORDS;
use crate::message::{Request, RequestResponse};
use crate::{
    Collected, Decision, DetailId, Digest, Leader, Origin, Outcome, PastPage, PastRequest, Pose, Record,
    Refusal, Status, Vetoed,
};

wire! {
    /// Asks for records from a decision on.
    pub struct PastRequestV1 = "hop.PastRequest.v1", 32 bytes, refused as "past" {
        /// Run whose past is wanted.
        run: [u64; 2] = RUN,
        /// First decision wanted; beyond the last there is nothing.
        from: u64 = COUNTED,
        /// Robot that is meant.
        robot: u32 = ROBOT,
        reserved: u32,
    }
    of PastRequest { run, robot, from: Decision(from) }
}

wire! {
    /// Header of a page; the payload is its records.
    pub struct PastHeaderV1 = "hop.PastHeader.v1", 32 bytes, refused as "past" {
        /// Run it belongs to.
        run: [u64; 2] = RUN,
        /// Decision of the first record.
        from: u64 = COUNTED,
        /// Robot that was asked for.
        robot: u32 = ROBOT,
        reserved: u32,
    }
    of PastPage { run, robot, from: Decision(from), records }
    from_wire(wire) {
        let records = records_from_wire(from, records)?;
    }
    /// The page of a copied answer.
    ///
    /// # Errors
    /// If it is too long, a record is malformed, or its decisions are not consecutive.
    pub fn page_from_wire(records: &[RecordV5]);
}

wire! {
    /// An executed decision.
    pub struct RecordV5 = "hop.Record.v5", 384 bytes, refused as "record" {
        /// Its number.
        decision: u64 = COUNTED,
        /// Fingerprint of the map it was decided on.
        observation: u64 = ANY,
        /// Work the planner did, in its own units.
        work: u64 = ANY,
        /// Steps afterwards.
        steps: u64 = STEPS,
        /// Goals visited so far.
        visits: u64 = COUNTED,
        /// Robot that acted.
        robot: u32 = ROBOT,
        /// Action that was executed: [`Action::code`](crate::Action::code).
        action: u32 = by_hand("0 to 12, or 13 with a `route`"),
        /// 1 if a budget cut the work short.
        cut: u32 = FLAG,
        /// How the mission stands afterwards.
        status: u32 = tag(Status::code, Status::from_code),
        /// Treasures collected, one bit each.
        collected: u32 = TREASURE_BITS,
        /// Who chose the action.
        origin: u32 = tag(Origin::code, Origin::from_code),
        /// Actions vetoed before it, one bit each.
        vetoed: u32 = ACTION_BITS,
        reserved: u32,
        /// Who commanded.
        leader: LeaderV1 = part::<Leader>(),
        /// What became of it.
        outcome: OutcomeV1 = part::<Outcome>(),
        /// Pose afterwards.
        pose: PoseV1 = part::<Pose>(),
        /// Moments of the decision, monotonic nanoseconds.
        timing_ns: [u64; 8] = MOMENTS,
        /// Digest before.
        previous: [u8; 32] = ANY,
        /// Digest after.
        digest: [u8; 32] = ANY,
        /// SHA-256 over what the motion model tells beyond the outcome; zero for nothing.
        detail: [u8; 32] = ANY,
        /// Fingerprint of the route that was announced; 0 for none.
        route: u64 = by_hand("not zero with `action` 13, else 0"),
    }
    of Record {
        robot,
        decision: Decision(decision),
        leader,
        action,
        origin,
        vetoed: Vetoed(vetoed),
        observation,
        work,
        cut,
        outcome,
        pose,
        detail: DetailId(detail),
        collected: Collected(collected),
        steps,
        visits,
        status,
        timing: timing_ns,
        previous: Digest(previous),
        digest: Digest(digest),
    }
    to_wire {
        let (action, route) = (&action.code(), &action.route());
    }
    from_wire(wire) {
        let action = action_from_wire("record.action", action, route)?;
    }
}

/// Records of consecutive decisions, the first of which is `from`.
fn records_from_wire(from: u64, records: &[RecordV5]) -> Result<Vec<Record>, Refusal> {
    if records.len() > PAST_PAGE_RECORDS {
        let need = format!("at most {PAST_PAGE_RECORDS}");
        return Err(Refusal::malformed("past.records", &need, records.len()));
    }
    let records = records.iter().map(Record::try_from).collect::<Result<Vec<_>, _>>()?;
    for (record, due) in records.iter().zip(from..) {
        if record.decision.0 != due {
            return Err(Refusal::malformed("past.decision", &due.to_string(), record.decision));
        }
    }
    Ok(records)
}

fixed_payload!(PastRequest => PastRequestV1);

slice_payload!(PastPage => PastHeaderV1, RecordV5, records, page_from_wire);

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
