//! `hop/rN/state`.

use bytemuck::{Pod, Zeroable};

use crate::Role;
use crate::fixed_payload;

use super::{
    LeaderV1, OutcomeV1, PoseV1, Wire, collected, counted, robot_from_wire, run_from_wire, run_to_wire,
    steps, tag, timing_from_wire, timing_to_wire, vetoed,
};
use crate::message::{Message, PublishSubscribe};
use crate::{Decision, Digest, MonotonicNs, Origin, Refusal, State, Status};

/// The state at one decision.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct StateV4 {
    pub run: [u64; 2],
    pub decision: u64,
    /// Steps so far, in the paper's count.
    pub steps: u64,
    /// Goals visited so far.
    pub visits: u64,
    /// Hopper at rest, monotonic nanoseconds.
    pub landed_ns: u64,
    /// Message published, monotonic nanoseconds.
    pub published_ns: u64,
    pub robot: u32,
    /// [`Status::code`].
    pub status: u32,
    /// Treasures collected, one bit each.
    pub collected: u32,
    /// Actions vetoed at this decision, one bit each.
    pub vetoed: u32,
    /// Who chose the last action: [`Origin::code`].
    pub last_origin: u32,
    /// Actions vetoed before it, one bit each.
    pub last_vetoed: u32,
    pub leader: LeaderV1,
    /// Where the hopper is.
    pub pose: PoseV1,
    /// Last outcome; all zero at decision 0.
    pub last: OutcomeV1,
    /// Chained SHA-256.
    pub digest: [u8; 32],
    /// The digest before the last decision; all zero at decision 0.
    pub previous: [u8; 32],
    /// Moments of the last decision, monotonic nanoseconds.
    pub last_timing_ns: [u64; 8],
}

const _: () = assert!(size_of::<StateV4>() == 352);

impl Wire for StateV4 {
    const NAME: &'static str = "hop.State.v4";
}

impl From<&State> for StateV4 {
    fn from(state: &State) -> Self {
        Self {
            run: run_to_wire(state.run),
            decision: state.decision.0,
            steps: state.steps,
            visits: state.visits,
            landed_ns: state.landed.0,
            published_ns: state.published.0,
            robot: u32::from(state.robot.0),
            status: state.status.code(),
            collected: state.collected.0,
            vetoed: state.vetoed.0,
            last_origin: state.last_origin.code(),
            last_vetoed: state.last_vetoed.0,
            leader: (&state.leader).into(),
            pose: (&state.pose).into(),
            last: state.last.as_ref().map_or_else(OutcomeV1::zeroed, OutcomeV1::from),
            digest: state.digest.0,
            previous: state.previous.0,
            last_timing_ns: timing_to_wire(&state.last_timing),
        }
    }
}

impl TryFrom<&StateV4> for State {
    type Error = Refusal;

    fn try_from(wire: &StateV4) -> Result<Self, Refusal> {
        Ok(Self {
            run: run_from_wire(wire.run),
            robot: robot_from_wire(wire.robot)?,
            decision: Decision(counted("state.decision", wire.decision)?),
            steps: steps("state.steps", wire.steps)?,
            visits: counted("state.visits", wire.visits)?,
            status: tag("state.status", wire.status, Status::from_code)?,
            leader: (&wire.leader).try_into()?,
            pose: (&wire.pose).try_into()?,
            collected: collected("state.collected", wire.collected)?,
            vetoed: vetoed("state.vetoed", wire.vetoed)?,
            last: if wire.decision == 0 { None } else { Some((&wire.last).try_into()?) },
            last_origin: tag("state.last_origin", wire.last_origin, Origin::from_code)?,
            last_vetoed: vetoed("state.last_vetoed", wire.last_vetoed)?,
            digest: Digest(wire.digest),
            previous: Digest(wire.previous),
            landed: MonotonicNs(wire.landed_ns),
            published: MonotonicNs(wire.published_ns),
            last_timing: timing_from_wire(wire.last_timing_ns),
        })
    }
}

fixed_payload!(State => StateV4);

/// Wakes perception.
impl Message for State {
    const SERVICE: PublishSubscribe = PublishSubscribe {
        max_subscribers: 24,
        buffer: 64,
        event: true,
        ..PublishSubscribe::new("hop/rN/state", &[Role::HopperSim])
    };
}
