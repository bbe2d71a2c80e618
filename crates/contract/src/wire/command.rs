//! `hop/rN/command`.

use crate::Role;
use crate::fixed_payload;

use super::action_from_wire;
use super::declaration::wire;
use crate::codec::{ANY, COUNTED, FLAG, GIVEN_NAME, NOT_ZERO, ROBOT, RUN, by_hand, whole};
use crate::limits::DECISIONS_MAX;
use crate::message::{Message, PublishSubscribe};
use crate::{Command, Decision, Digest, Incarnation, MonotonicNs, Name, Refusal, Term};

wire! {
    /// What a planner tells a robot to do.
    pub struct CommandV3 = "hop.Command.v3", 176 bytes, refused as "command" {
        /// Run that is meant.
        run: [u64; 2] = RUN,
        /// Decision that it answers.
        decision: u64 = COUNTED,
        /// Term it speaks for; 0 is nobody's.
        term: u64 = whole(1, DECISIONS_MAX),
        /// Life of the planner; 0 stands for no planner.
        incarnation: u64 = NOT_ZERO,
        /// Fingerprint of the map it was decided on.
        observation: u64 = ANY,
        /// Work done, in the planner's own units.
        work: u64 = ANY,
        /// Pose folded into the map, monotonic nanoseconds.
        sensed_ns: u64 = ANY,
        /// Map published, monotonic nanoseconds.
        map_published_ns: u64 = ANY,
        /// Planning began, monotonic nanoseconds.
        planning_started_ns: u64 = ANY,
        /// Planning ended, monotonic nanoseconds: the time that it took is their difference.
        planning_ended_ns: u64 = by_hand("at least `planning_started_ns`"),
        /// Robot that is meant.
        robot: u32 = ROBOT,
        /// Action to execute: [`Action::code`](crate::Action::code).
        action: u32 = by_hand("0 to 12, or 13 with a `route`"),
        /// Process of the planner, for people; 0 in lockstep.
        pid: u32 = ANY,
        /// 1 if a budget cut the work short.
        cut: u32 = FLAG,
        /// Algorithm of the planner; journals and tables are sorted by it.
        planner: [u8; Name::BYTES] = GIVEN_NAME,
        /// Digest of the state that it answers.
        digest: [u8; 32] = ANY,
        /// Fingerprint of the route that is announced; 0 for none.
        route: u64 = by_hand("not zero with `action` 13, else 0"),
    }
    of Command {
        run,
        robot,
        decision: Decision(decision),
        digest: Digest(digest),
        term: Term(term),
        action,
        observation,
        planner,
        incarnation: Incarnation(incarnation),
        pid,
        work,
        cut,
        sensed: MonotonicNs(sensed_ns),
        map_published: MonotonicNs(map_published_ns),
        planning_started: MonotonicNs(planning_started_ns),
        planning_ended: MonotonicNs(planning_ended_ns),
    }
    to_wire {
        let (action, route) = (&action.code(), &action.route());
    }
    from_wire(wire) {
        if planning_ended_ns < planning_started_ns {
            let need = format!("at least planning_started_ns = {planning_started_ns}");
            return Err(Refusal::malformed("command.planning_ended_ns", &need, planning_ended_ns));
        }
        let action = action_from_wire("command.action", action, route)?;
    }
}

fixed_payload!(Command => CommandV3);

/// Wakes hopper-sim, the only reader that acts on it. The budget allows for the leader and one that stands by.
impl Message for Command {
    const SERVICE: PublishSubscribe = PublishSubscribe {
        max_publishers: 8,
        expected_publishers: 2,
        history: 0,
        buffer: 16,
        event: true,
        ..PublishSubscribe::new("hop/rN/command", &[Role::Planner])
    };
}
