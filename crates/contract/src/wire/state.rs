//! `hop/state`.

use bytemuck::Zeroable;

use crate::Role;
use crate::fixed_payload;

use super::declaration::wire;
use super::{LeaderV1, OutcomeV1, PoseV1};
use crate::codec::{
    ACTION_BITS, ANY, COUNTED, MOMENTS, ROBOT, RUN, STEPS, TREASURE_BITS, by_hand, part, tag,
};
use crate::message::{Message, PublishSubscribe};
use crate::{Collected, Decision, Digest, Leader, MonotonicNs, Origin, Pose, State, Status, Vetoed};

wire! {
    /// The state at one decision.
    pub struct StateV4 = "hop.State.v4", 352 bytes, refused as "state" {
        /// Run it belongs to.
        run: [u64; 2] = RUN,
        /// Decision that is due.
        decision: u64 = COUNTED,
        /// Steps so far, in the paper's count.
        steps: u64 = STEPS,
        /// Goals visited so far.
        visits: u64 = COUNTED,
        /// Hopper at rest, monotonic nanoseconds.
        landed_ns: u64 = ANY,
        /// Message published, monotonic nanoseconds.
        published_ns: u64 = ANY,
        /// Robot that took the last decision.
        robot: u32 = ROBOT,
        /// How the mission stands.
        status: u32 = tag(Status::code, Status::from_code),
        /// Treasures collected, one bit each.
        collected: u32 = TREASURE_BITS,
        /// Actions vetoed at this decision, one bit each.
        vetoed: u32 = ACTION_BITS,
        /// Who chose the last action.
        last_origin: u32 = tag(Origin::code, Origin::from_code),
        /// Actions vetoed before the last action, one bit each.
        last_vetoed: u32 = ACTION_BITS,
        /// Who commands.
        leader: LeaderV1 = part::<Leader>(),
        /// Where the hopper is.
        pose: PoseV1 = part::<Pose>(),
        /// Last outcome; all zero at decision 0.
        last: OutcomeV1 = by_hand("as `hop.Outcome.v1`; not read at decision 0"),
        /// Chained SHA-256 of everything executed.
        digest: [u8; 32] = ANY,
        /// Digest before the last decision; all zero at decision 0.
        previous: [u8; 32] = ANY,
        /// Moments of the last decision, monotonic nanoseconds.
        last_timing_ns: [u64; 8] = MOMENTS,
    }
    of State {
        run,
        robot,
        decision: Decision(decision),
        steps,
        visits,
        status,
        leader,
        pose,
        collected: Collected(collected),
        vetoed: Vetoed(vetoed),
        last,
        last_origin,
        last_vetoed: Vetoed(last_vetoed),
        previous: Digest(previous),
        digest: Digest(digest),
        landed: MonotonicNs(landed_ns),
        published: MonotonicNs(published_ns),
        last_timing: last_timing_ns,
    }
    to_wire {
        let last = &last.as_ref().map_or_else(OutcomeV1::zeroed, OutcomeV1::from);
    }
    from_wire(wire) {
        let last = if decision == 0 { None } else { Some((&last).try_into()?) };
    }
}

fixed_payload!(State => StateV4);

/// Wakes perception.
impl Message for State {
    const SERVICE: PublishSubscribe = PublishSubscribe {
        max_subscribers: 24,
        buffer: 64,
        event: true,
        ..PublishSubscribe::new("hop/state", &[Role::HopperSim])
    };
}
