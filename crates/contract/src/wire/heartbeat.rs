//! `hop/heartbeat`.

use crate::fixed_payload;

use super::declaration::wire;
use crate::codec::{ANY, COUNTED, NAME, NOT_ZERO, RUN, narrow, tag};
use crate::message::{Message, PublishSubscribe};
use crate::{Decision, Heartbeat, Incarnation, Name, RobotSet, Role, Status};

wire! {
    /// A process is alive.
    pub struct HeartbeatV2 = "hop.Heartbeat.v2", 120 bytes, refused as "heartbeat" {
        /// Run last seen; zero for none.
        run: [u64; 2] = RUN,
        /// Life of the process; 0 stands for none.
        incarnation: u64 = NOT_ZERO,
        /// Beats of this life.
        counter: u64 = ANY,
        /// Decision of the last state seen.
        decision: u64 = COUNTED,
        /// Part the process plays.
        role: u32 = tag(Role::code, Role::from_code),
        /// Status of the mission last seen.
        status: u32 = tag(Status::code, Status::from_code),
        /// Process, for people.
        pid: u32 = ANY,
        /// Robots that a planner plans for, or that still act, one bit each: bit 0 for robot 0.
        robots: u32 = narrow(0, u16::MAX),
        /// Version of the build, by which one too old to check is known.
        version: [u8; Name::BYTES] = NAME,
        /// Algorithm of a planner.
        planner: [u8; Name::BYTES] = NAME,
    }
    of Heartbeat {
        role,
        incarnation: Incarnation(incarnation),
        pid,
        version,
        planner,
        counter,
        run,
        decision: Decision(decision),
        status,
        robots: RobotSet(robots),
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
