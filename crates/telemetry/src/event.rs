//! Events: what people on the ground want to know first.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};
use contract::field::Meaning;
use contract::message::Wire;
use contract::wire::Field;
use contract::{Decision, Name, Refusal, RobotId, Status, fixed_payload};
use serde::Serialize;

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum EventKind {
    /// The link has begun to send.
    LinkStarted,
    /// The first state of a run came.
    MissionFound,
    /// The guard has vetoed an action; the value has a bit for each action vetoed at this decision.
    Vetoed,
    /// Another planner commands; the name is that of its algorithm, the value its term.
    LeaderChanged,
    /// The mission is over; the value is its status.
    MissionEnded,
    /// A treasure was collected; the value is how many are.
    Collected,
    /// The journal has lost decisions: those from this one on are flown again.
    PastLost,
}

/// How much it matters; the subtype of the packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Good to know.
    Informative,
    /// Look when there is time.
    Low,
    /// Look soon.
    Medium,
    /// Look now.
    High,
}

impl Severity {
    /// The subtype of service 5 that reports it.
    #[must_use]
    pub fn subtype(self) -> u8 {
        self as u8 + 1
    }
}

impl EventKind {
    /// Every kind, in the order of their codes.
    pub const ALL: [EventKind; 7] = [
        EventKind::LinkStarted,
        EventKind::MissionFound,
        EventKind::Vetoed,
        EventKind::LeaderChanged,
        EventKind::MissionEnded,
        EventKind::Collected,
        EventKind::PastLost,
    ];

    /// The code in a packet.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32 + 1
    }

    /// The kind of a code, if there is one.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }

    /// How much it matters.
    #[must_use]
    pub fn severity(self) -> Severity {
        match self {
            EventKind::LinkStarted
            | EventKind::MissionFound
            | EventKind::MissionEnded
            | EventKind::Collected => Severity::Informative,
            EventKind::Vetoed => Severity::Low,
            EventKind::LeaderChanged => Severity::Medium,
            EventKind::PastLost => Severity::High,
        }
    }
}

/// Something happened.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Event {
    /// What.
    pub kind: EventKind,
    /// Robot that it is about; robot 0 where it is about none.
    pub robot: RobotId,
    /// The decision that was due then.
    pub decision: Decision,
    /// More about it, as its kind says.
    pub value: u64,
    /// Who it is about, if anybody.
    pub name: Name,
}

impl Event {
    /// An event without value and name.
    #[must_use]
    pub fn new(kind: EventKind, robot: RobotId, decision: Decision) -> Self {
        Self { kind, robot, decision, value: 0, name: Name::NONE }
    }

    /// The mission has ended before `decision`.
    #[must_use]
    pub fn mission_ended(decision: Decision, status: Status) -> Self {
        Self { value: status.code().into(), ..Self::new(EventKind::MissionEnded, RobotId(0), decision) }
    }
}

/// The wire form of an [`Event`].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "the fields have their words below")]
pub struct EventV1 {
    pub event: u32,
    pub robot: u32,
    pub decision: u64,
    pub value: u64,
    pub name: [u8; Name::BYTES],
}

impl Wire for EventV1 {
    const NAME: &'static str = "link.Event.v1";

    fn fields() -> Vec<Field> {
        let codes = EventKind::ALL.map(|kind| (kind.code(), format!("{kind:?}")));
        let range = codes.clone().map(|(code, name)| format!("{code} {name}")).join(", ");
        vec![
            Field::of::<u32>("event", offset_of!(Self, event), range, "What happened.")
                .meaning(Meaning::Codes(codes.into())),
            Field::of::<u32>("robot", offset_of!(Self, robot), "at most 65535", "Robot that it is about."),
            Field::of::<u64>("decision", offset_of!(Self, decision), "any", "Decision that was due then."),
            Field::of::<u64>("value", offset_of!(Self, value), "any", "More about it, as its code says."),
            Field::of::<[u8; Name::BYTES]>(
                "name",
                offset_of!(Self, name),
                "a name, or zeros",
                "Who it is about.",
            )
            .meaning(Meaning::Text),
        ]
    }
}

impl From<&Event> for EventV1 {
    fn from(event: &Event) -> Self {
        Self {
            event: event.kind.code(),
            robot: event.robot.0.into(),
            decision: event.decision.0,
            value: event.value,
            name: event.name.bytes(),
        }
    }
}

impl TryFrom<&EventV1> for Event {
    type Error = Refusal;

    fn try_from(wire: &EventV1) -> Result<Self, Refusal> {
        let unknown = || Refusal::malformed("event.event", "a known code", wire.event);
        let robot = u16::try_from(wire.robot)
            .map_err(|_| Refusal::WrongRobot { robots: u16::MAX, got: wire.robot })?;
        Ok(Self {
            kind: EventKind::from_code(wire.event).ok_or_else(unknown)?,
            robot: RobotId(robot),
            decision: Decision(wire.decision),
            value: wire.value,
            name: Name::from_bytes(wire.name)
                .map_err(|error| Refusal::malformed("event.name", "a name", error.got))?,
        })
    }
}

fixed_payload!(Event => EventV1);
