//! `hop/heartbeat`.

use bytemuck::{Pod, Zeroable};

use crate::fixed_payload;

use super::{Wire, counted, name_from_wire, run_from_wire, run_to_wire, tag};
use crate::message::{Message, PublishSubscribe};
use crate::{Decision, Heartbeat, Incarnation, Name, Refusal, RobotSet, Role, Status};

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct HeartbeatV2 {
    /// Run last seen, high half first; zero for none.
    pub run: [u64; 2],
    /// Life of the process, not zero.
    pub incarnation: u64,
    /// Beats of this life.
    pub counter: u64,
    pub decision: u64,
    /// [`Role::code`].
    pub role: u32,
    /// [`Status::code`] last seen.
    pub status: u32,
    pub pid: u32,
    /// One bit each: bit 0 for robot 0.
    pub robots: u32,
    /// Version of the build, zero-padded ASCII.
    pub version: [u8; Name::BYTES],
    /// Algorithm of a planner, zero-padded ASCII.
    pub planner: [u8; Name::BYTES],
}

const _: () = assert!(size_of::<HeartbeatV2>() == 120);

impl Wire for HeartbeatV2 {
    const NAME: &'static str = "hop.Heartbeat.v2";
}

impl From<&Heartbeat> for HeartbeatV2 {
    fn from(beat: &Heartbeat) -> Self {
        Self {
            run: run_to_wire(beat.run),
            incarnation: beat.incarnation.0,
            counter: beat.counter,
            decision: beat.decision.0,
            role: beat.role.code(),
            status: beat.status.code(),
            pid: beat.pid,
            robots: beat.robots.0.into(),
            version: beat.version.bytes(),
            planner: beat.planner.bytes(),
        }
    }
}

impl TryFrom<&HeartbeatV2> for Heartbeat {
    type Error = Refusal;

    fn try_from(wire: &HeartbeatV2) -> Result<Self, Refusal> {
        if wire.incarnation == 0 {
            return Err(Refusal::malformed("heartbeat.incarnation", "not zero", 0));
        }
        Ok(Self {
            role: tag("heartbeat.role", wire.role, Role::from_code)?,
            incarnation: Incarnation(wire.incarnation),
            pid: wire.pid,
            version: name_from_wire("heartbeat.version", wire.version)?,
            planner: name_from_wire("heartbeat.planner", wire.planner)?,
            counter: wire.counter,
            run: run_from_wire(wire.run),
            decision: Decision(counted("heartbeat.decision", wire.decision)?),
            status: tag("heartbeat.status", wire.status, Status::from_code)?,
            robots: u16::try_from(wire.robots)
                .map(RobotSet)
                .map_err(|_| Refusal::malformed("heartbeat.robots", "at most 65535", wire.robots))?,
        })
    }
}

fixed_payload!(Heartbeat => HeartbeatV2);

/// Written by every process; the budget allows for four and a stand-by.
impl Message for Heartbeat {
    const SERVICE: PublishSubscribe = PublishSubscribe {
        max_publishers: 24,
        expected_publishers: 5,
        max_subscribers: 24,
        buffer: 16,
        ..PublishSubscribe::new("hop/heartbeat", &Role::ALL)
    };
}
