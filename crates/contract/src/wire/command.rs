//! `hop/rN/command`.

use bytemuck::{Pod, Zeroable};

use crate::Role;
use crate::fixed_payload;

use super::{Wire, flag, name_from_wire, robot_from_wire, run_from_wire, run_to_wire, tag};
use crate::limits::DECISIONS_MAX;
use crate::message::{Message, PublishSubscribe};
use crate::{Action, Command, Decision, Digest, Incarnation, MonotonicNs, Name, Refusal, Term};

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct CommandV3 {
    pub run: [u64; 2],
    pub decision: u64,
    /// Term it speaks for, at least 1.
    pub term: u64,
    /// Life of the planner, not zero.
    pub incarnation: u64,
    /// Fingerprint of the map it was decided on.
    pub observation: u64,
    /// Work done, in the planner's own units.
    pub work: u64,
    /// Pose folded into the map, monotonic nanoseconds.
    pub sensed_ns: u64,
    /// Map published, monotonic nanoseconds.
    pub map_published_ns: u64,
    /// Planning began, monotonic nanoseconds.
    pub planning_started_ns: u64,
    /// Planning ended, monotonic nanoseconds; not before it began.
    pub planning_ended_ns: u64,
    pub robot: u32,
    /// [`Action::code`].
    pub action: u32,
    /// Process of the planner.
    pub pid: u32,
    /// 1 if a budget cut the work short.
    pub cut: u32,
    /// Algorithm, zero-padded ASCII, not empty.
    pub planner: [u8; Name::BYTES],
    /// Digest of the state that it answers.
    pub digest: [u8; 32],
    /// Fingerprint of the route that is announced; 0 for none.
    pub route: u64,
}

const _: () = assert!(size_of::<CommandV3>() == 176);

impl Wire for CommandV3 {
    const NAME: &'static str = "hop.Command.v3";
}

impl From<&Command> for CommandV3 {
    fn from(command: &Command) -> Self {
        Self {
            run: run_to_wire(command.run),
            decision: command.decision.0,
            term: command.term.0,
            incarnation: command.incarnation.0,
            observation: command.observation,
            work: command.work,
            sensed_ns: command.sensed.0,
            map_published_ns: command.map_published.0,
            planning_started_ns: command.planning_started.0,
            planning_ended_ns: command.planning_ended.0,
            robot: u32::from(command.robot.0),
            action: command.action.code(),
            pid: command.pid,
            cut: u32::from(command.cut),
            planner: command.planner.bytes(),
            digest: command.digest.0,
            route: command.action.route(),
        }
    }
}

impl TryFrom<&CommandV3> for Command {
    type Error = Refusal;

    fn try_from(wire: &CommandV3) -> Result<Self, Refusal> {
        if wire.decision > DECISIONS_MAX {
            return Err(Refusal::malformed(
                "command.decision",
                &format!("at most {DECISIONS_MAX}"),
                wire.decision,
            ));
        }
        if wire.term == 0 || wire.term > DECISIONS_MAX {
            return Err(Refusal::malformed("command.term", &format!("1 to {DECISIONS_MAX}"), wire.term));
        }
        if wire.incarnation == 0 {
            return Err(Refusal::malformed("command.incarnation", "not zero", 0));
        }
        if wire.planning_ended_ns < wire.planning_started_ns {
            return Err(Refusal::malformed(
                "command.planning_ended_ns",
                &format!("at least planning_started_ns = {}", wire.planning_started_ns),
                wire.planning_ended_ns,
            ));
        }
        let planner = name_from_wire("command.planner", wire.planner)?;
        if planner == Name::NONE {
            return Err(Refusal::malformed("command.planner", "a name", "nothing"));
        }
        Ok(Self {
            run: run_from_wire(wire.run),
            robot: robot_from_wire(wire.robot)?,
            decision: Decision(wire.decision),
            digest: Digest(wire.digest),
            term: Term(wire.term),
            action: tag("command.action", wire.action, |code| Action::with_route(code, wire.route))?,
            observation: wire.observation,
            planner,
            incarnation: Incarnation(wire.incarnation),
            pid: wire.pid,
            work: wire.work,
            cut: flag("command.cut", wire.cut)?,
            sensed: MonotonicNs(wire.sensed_ns),
            map_published: MonotonicNs(wire.map_published_ns),
            planning_started: MonotonicNs(wire.planning_started_ns),
            planning_ended: MonotonicNs(wire.planning_ended_ns),
        })
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
