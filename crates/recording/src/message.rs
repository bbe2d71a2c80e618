//! The messages of a recording, and their protobuf encoding.

use contract::wire::{
    BriefV10, CommandV3, ControlV1, HeartbeatV2, MapPageV2, MapPatchV2, PastHeaderV1, PolicyCellV1,
    PolicyHeaderV1, RecordV5, RobotV1, SeenCellV4, StateV4, TempoV1, brief_from_wire, map_page_from_wire,
    page_from_wire, patch_from_wire, policy_from_wire,
};
use contract::{
    Brief, Command, Control, Heartbeat, MapPage, MapPatch, MonotonicNs, Pacing, PastPage, Policy, Refusal,
    State,
};
use prost::Message as _;

use crate::earlier_brief;
use crate::error::MessageError;
use crate::proto::hopper as proto;
use crate::{Channel, MachineLoad, SequenceGap};

/// One message of a recording: a public message, the load of the machine, or a gap.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "messages are short-lived")]
pub enum RecordedMessage {
    /// What the mission is; recorded once a run.
    Brief(Brief),
    /// State of the mission after a decision.
    State(State),
    /// Cells of the observed map that a landing changed.
    Patch(MapPatch),
    /// A page of the observed map, answered by perception.
    Page(MapPage),
    /// A planner's command for the decision that is due.
    Command(Command),
    /// A planner's policy, for display.
    Policy(Policy),
    /// An order of the monitor, such as pause.
    Control(Control),
    /// How hopper-sim paces landings.
    Pacing(Pacing),
    /// A sign of life of a process.
    Heartbeat(Heartbeat),
    /// A page of executed decisions, answered by hopper-sim.
    Past(PastPage),
    /// Load of the machine; made by the recorder.
    Host(MachineLoad),
    /// Messages that did not reach the recorder; made by it.
    Gap(SequenceGap),
}

impl RecordedMessage {
    /// Channel it is recorded on.
    #[must_use]
    pub fn topic(&self) -> Channel {
        match self {
            RecordedMessage::Brief(_) => Channel::Brief,
            RecordedMessage::State(_) => Channel::State,
            RecordedMessage::Patch(_) => Channel::Map,
            RecordedMessage::Page(_) => Channel::Snapshot,
            RecordedMessage::Command(_) => Channel::Command,
            RecordedMessage::Policy(_) => Channel::Policy,
            RecordedMessage::Control(_) => Channel::Control,
            RecordedMessage::Pacing(_) => Channel::Pacing,
            RecordedMessage::Heartbeat(_) => Channel::Heartbeat,
            RecordedMessage::Past(_) => Channel::Past,
            RecordedMessage::Host(_) => Channel::Host,
            RecordedMessage::Gap(_) => Channel::Gap,
        }
    }

    /// When it was published; `None` if the message has no such time.
    #[must_use]
    pub fn published(&self) -> Option<MonotonicNs> {
        match self {
            RecordedMessage::State(state) => Some(state.published),
            RecordedMessage::Patch(patch) => Some(patch.published),
            RecordedMessage::Command(command) => Some(command.planning_ended),
            RecordedMessage::Host(host) => Some(host.until),
            _ => None,
        }
    }

    /// Its protobuf encoding.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        match self {
            RecordedMessage::Brief(brief) => {
                let mut message_proto = proto::Brief::from(&BriefV10::from(brief));
                message_proto.robots =
                    brief.robots.iter().map(|robot| (&RobotV1::from(robot)).into()).collect();
                message_proto.encode_to_vec()
            }
            RecordedMessage::State(state) => proto::State::from(&StateV4::from(state)).encode_to_vec(),
            RecordedMessage::Patch(patch) => {
                let mut message_proto = proto::MapPatch::from(&MapPatchV2::from(patch));
                message_proto.cells =
                    patch.cells.iter().map(|cell| (&SeenCellV4::from(cell)).into()).collect();
                message_proto.encode_to_vec()
            }
            RecordedMessage::Page(page) => {
                let mut message_proto = proto::MapPage::from(&MapPageV2::from(page));
                message_proto.cells =
                    page.cells.iter().map(|cell| (&SeenCellV4::from(cell)).into()).collect();
                message_proto.encode_to_vec()
            }
            RecordedMessage::Command(command) => {
                proto::Command::from(&CommandV3::from(command)).encode_to_vec()
            }
            RecordedMessage::Policy(policy) => {
                let mut message_proto = proto::Policy::from(&PolicyHeaderV1::from(policy));
                message_proto.cells =
                    policy.cells.iter().map(|cell| (&PolicyCellV1::from(cell)).into()).collect();
                message_proto.encode_to_vec()
            }
            RecordedMessage::Control(control) => {
                proto::Control::from(&ControlV1::from(control)).encode_to_vec()
            }
            RecordedMessage::Pacing(pacing) => proto::Tempo::from(&TempoV1::from(pacing)).encode_to_vec(),
            RecordedMessage::Heartbeat(beat) => {
                proto::Heartbeat::from(&HeartbeatV2::from(beat)).encode_to_vec()
            }
            RecordedMessage::Past(page) => {
                let mut message_proto = proto::Past::from(&PastHeaderV1::from(page));
                message_proto.records =
                    page.records.iter().map(|record| (&RecordV5::from(record)).into()).collect();
                message_proto.encode_to_vec()
            }
            RecordedMessage::Host(host) => proto::Host::from(host).encode_to_vec(),
            RecordedMessage::Gap(gap) => proto::Gap::from(gap).encode_to_vec(),
        }
    }

    /// Decodes a message of `channel`; `None` for the channels made for viewers.
    ///
    /// # Errors
    /// If the bytes are not protobuf of the channel's schema, or a field is out of range.
    pub fn decode(topic: Channel, bytes: &[u8]) -> Result<Option<Self>, MessageError> {
        Ok(Some(match topic {
            Channel::Brief => {
                let message_proto = proto::Brief::decode(bytes)?;
                if message_proto.robots.is_empty() {
                    return Ok(Some(RecordedMessage::Brief(earlier_brief::read(&message_proto)?)));
                }
                let robots = list::<_, RobotV1>(&message_proto.robots)?;
                RecordedMessage::Brief(brief_from_wire(&BriefV10::try_from(&message_proto)?, &robots)?)
            }
            Channel::State => {
                let wire = StateV4::try_from(&proto::State::decode(bytes)?)?;
                RecordedMessage::State((&wire).try_into()?)
            }
            Channel::Map => {
                let message_proto = proto::MapPatch::decode(bytes)?;
                let cells = list::<_, SeenCellV4>(&message_proto.cells)?;
                RecordedMessage::Patch(patch_from_wire(&MapPatchV2::try_from(&message_proto)?, &cells)?)
            }
            Channel::Snapshot => {
                let message_proto = proto::MapPage::decode(bytes)?;
                let cells = list::<_, SeenCellV4>(&message_proto.cells)?;
                RecordedMessage::Page(map_page_from_wire(&MapPageV2::try_from(&message_proto)?, &cells)?)
            }
            Channel::Command => {
                let wire = CommandV3::try_from(&proto::Command::decode(bytes)?)?;
                RecordedMessage::Command((&wire).try_into()?)
            }
            Channel::Policy => {
                let message_proto = proto::Policy::decode(bytes)?;
                let cells = list::<_, PolicyCellV1>(&message_proto.cells)?;
                RecordedMessage::Policy(policy_from_wire(&PolicyHeaderV1::try_from(&message_proto)?, &cells)?)
            }
            Channel::Control => {
                let wire = ControlV1::try_from(&proto::Control::decode(bytes)?)?;
                RecordedMessage::Control((&wire).try_into()?)
            }
            Channel::Pacing => {
                let wire = TempoV1::try_from(&proto::Tempo::decode(bytes)?)?;
                RecordedMessage::Pacing((&wire).try_into()?)
            }
            Channel::Heartbeat => {
                let wire = HeartbeatV2::try_from(&proto::Heartbeat::decode(bytes)?)?;
                RecordedMessage::Heartbeat((&wire).try_into()?)
            }
            Channel::Past => {
                let message_proto = proto::Past::decode(bytes)?;
                let records = list::<_, RecordV5>(&message_proto.records)?;
                RecordedMessage::Past(page_from_wire(&PastHeaderV1::try_from(&message_proto)?, &records)?)
            }
            Channel::Host => RecordedMessage::Host((&proto::Host::decode(bytes)?).try_into()?),
            Channel::Gap => RecordedMessage::Gap((&proto::Gap::decode(bytes)?).try_into()?),
            Channel::ViewPlan
            | Channel::ViewRoute
            | Channel::ViewRobots
            | Channel::ViewTransforms
            | Channel::ViewLog
            | Channel::ViewLayer(_) => return Ok(None),
        }))
    }
}

fn list<'a, P, W: TryFrom<&'a P, Error = Refusal>>(message_proto: &'a [P]) -> Result<Vec<W>, Refusal> {
    message_proto.iter().map(W::try_from).collect()
}

impl From<&MachineLoad> for proto::Host {
    fn from(host: &MachineLoad) -> Self {
        let MachineLoad { since, until, busy, load_1min, cores } = *host;
        Self { since_ns: since.0, until_ns: until.0, busy, load_1min, cores }
    }
}

impl TryFrom<&proto::Host> for MachineLoad {
    type Error = Refusal;

    fn try_from(message_proto: &proto::Host) -> Result<Self, Refusal> {
        let proto::Host { since_ns, until_ns, busy, load_1min, cores } = *message_proto;
        if !(0.0..=1.0).contains(&busy) {
            return Err(Refusal::malformed("Host.busy", "0 to 1", busy));
        }
        if !(0.0..=1.0e6).contains(&load_1min) {
            return Err(Refusal::malformed("Host.load_1min", "0 to 1000000", load_1min));
        }
        Ok(Self { since: MonotonicNs(since_ns), until: MonotonicNs(until_ns), busy, load_1min, cores })
    }
}

impl From<&SequenceGap> for proto::Gap {
    fn from(gap: &SequenceGap) -> Self {
        let SequenceGap { topic, from, through, counted } = gap.clone();
        Self { topic, from, through, counted }
    }
}

impl TryFrom<&proto::Gap> for SequenceGap {
    type Error = Refusal;

    fn try_from(message_proto: &proto::Gap) -> Result<Self, Refusal> {
        let proto::Gap { topic, from, through, counted } = message_proto.clone();
        if through < from {
            return Err(Refusal::malformed("Gap.through", &format!("at least {from}"), through));
        }
        Ok(Self { topic, from, through, counted })
    }
}
