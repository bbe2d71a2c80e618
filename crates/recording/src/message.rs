//! What a recording holds: public messages, how busy the machine was, and what is missing.

use contract::wire::{
    BriefV3, CommandV1, ControlV1, HeartbeatV1, MapPageV1, MapPatchV1, PastHeaderV1, PolicyCellV1,
    PolicyHeaderV1, RecordV3, SeenCellV1, StateV3, TempoV1, map_page_from_wire, page_from_wire,
    patch_from_wire, policy_from_wire,
};
use contract::{
    Brief, Command, Control, Heartbeat, MapPage, MapPatch, MonotonicNs, PastPage, Policy, Refusal, State,
    Tempo,
};
use prost::Message as _;

use crate::error::MessageError;
use crate::proto::hopper as proto;
use crate::{Gap, Host, Topic};

/// One message.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "a message is made, taken, and gone")]
pub enum Message {
    /// The brief.
    Brief(Brief),
    /// The state.
    State(State),
    /// What a landing changed in the observed map.
    Patch(MapPatch),
    /// A page of the observed map.
    Page(MapPage),
    /// A command.
    Command(Command),
    /// A planner's policy.
    Policy(Policy),
    /// An order.
    Control(Control),
    /// How landings are paced.
    Tempo(Tempo),
    /// A heartbeat.
    Heartbeat(Heartbeat),
    /// Executed decisions.
    Past(PastPage),
    /// How busy the machine was.
    Host(Host),
    /// What is missing.
    Gap(Gap),
}

impl Message {
    /// Where it stands.
    #[must_use]
    pub fn topic(&self) -> Topic {
        match self {
            Message::Brief(_) => Topic::Brief,
            Message::State(_) => Topic::State,
            Message::Patch(_) => Topic::Map,
            Message::Page(_) => Topic::Snapshot,
            Message::Command(_) => Topic::Command,
            Message::Policy(_) => Topic::Policy,
            Message::Control(_) => Topic::Control,
            Message::Tempo(_) => Topic::Tempo,
            Message::Heartbeat(_) => Topic::Heartbeat,
            Message::Past(_) => Topic::Past,
            Message::Host(_) => Topic::Host,
            Message::Gap(_) => Topic::Gap,
        }
    }

    /// When it was published, if it says so.
    #[must_use]
    pub fn published(&self) -> Option<MonotonicNs> {
        match self {
            Message::State(state) => Some(state.published),
            Message::Patch(patch) => Some(patch.published),
            Message::Command(command) => Some(command.planning_ended),
            Message::Host(host) => Some(host.until),
            _ => None,
        }
    }

    /// Its protobuf.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        match self {
            Message::Brief(brief) => proto::Brief::from(&BriefV3::from(brief)).encode_to_vec(),
            Message::State(state) => proto::State::from(&StateV3::from(state)).encode_to_vec(),
            Message::Patch(patch) => {
                let mut shown = proto::MapPatch::from(&MapPatchV1::from(patch));
                shown.cells = patch.cells.iter().map(|cell| (&SeenCellV1::from(cell)).into()).collect();
                shown.encode_to_vec()
            }
            Message::Page(page) => {
                let mut shown = proto::MapPage::from(&MapPageV1::from(page));
                shown.cells = page.cells.iter().map(|cell| (&SeenCellV1::from(cell)).into()).collect();
                shown.encode_to_vec()
            }
            Message::Command(command) => proto::Command::from(&CommandV1::from(command)).encode_to_vec(),
            Message::Policy(policy) => {
                let mut shown = proto::Policy::from(&PolicyHeaderV1::from(policy));
                shown.cells = policy.cells.iter().map(|cell| (&PolicyCellV1::from(cell)).into()).collect();
                shown.encode_to_vec()
            }
            Message::Control(control) => proto::Control::from(&ControlV1::from(control)).encode_to_vec(),
            Message::Tempo(tempo) => proto::Tempo::from(&TempoV1::from(tempo)).encode_to_vec(),
            Message::Heartbeat(beat) => proto::Heartbeat::from(&HeartbeatV1::from(beat)).encode_to_vec(),
            Message::Past(page) => {
                let mut shown = proto::Past::from(&PastHeaderV1::from(page));
                shown.records = page.records.iter().map(|record| (&RecordV3::from(record)).into()).collect();
                shown.encode_to_vec()
            }
            Message::Host(host) => proto::Host::from(host).encode_to_vec(),
            Message::Gap(gap) => proto::Gap::from(gap).encode_to_vec(),
        }
    }

    /// The message of a topic's bytes; `None` for what is drawn for viewers.
    ///
    /// # Errors
    /// If they are no protobuf of its schema, or a field is out of range.
    pub fn decode(topic: Topic, bytes: &[u8]) -> Result<Option<Self>, MessageError> {
        Ok(Some(match topic {
            Topic::Brief => {
                let wire = BriefV3::try_from(&proto::Brief::decode(bytes)?)?;
                Message::Brief((&wire).try_into()?)
            }
            Topic::State => {
                let wire = StateV3::try_from(&proto::State::decode(bytes)?)?;
                Message::State((&wire).try_into()?)
            }
            Topic::Map => {
                let shown = proto::MapPatch::decode(bytes)?;
                let cells = list::<_, SeenCellV1>(&shown.cells)?;
                Message::Patch(patch_from_wire(&MapPatchV1::try_from(&shown)?, &cells)?)
            }
            Topic::Snapshot => {
                let shown = proto::MapPage::decode(bytes)?;
                let cells = list::<_, SeenCellV1>(&shown.cells)?;
                Message::Page(map_page_from_wire(&MapPageV1::try_from(&shown)?, &cells)?)
            }
            Topic::Command => {
                let wire = CommandV1::try_from(&proto::Command::decode(bytes)?)?;
                Message::Command((&wire).try_into()?)
            }
            Topic::Policy => {
                let shown = proto::Policy::decode(bytes)?;
                let cells = list::<_, PolicyCellV1>(&shown.cells)?;
                Message::Policy(policy_from_wire(&PolicyHeaderV1::try_from(&shown)?, &cells)?)
            }
            Topic::Control => {
                let wire = ControlV1::try_from(&proto::Control::decode(bytes)?)?;
                Message::Control((&wire).try_into()?)
            }
            Topic::Tempo => {
                let wire = TempoV1::try_from(&proto::Tempo::decode(bytes)?)?;
                Message::Tempo((&wire).try_into()?)
            }
            Topic::Heartbeat => {
                let wire = HeartbeatV1::try_from(&proto::Heartbeat::decode(bytes)?)?;
                Message::Heartbeat((&wire).try_into()?)
            }
            Topic::Past => {
                let shown = proto::Past::decode(bytes)?;
                let records = list::<_, RecordV3>(&shown.records)?;
                Message::Past(page_from_wire(&PastHeaderV1::try_from(&shown)?, &records)?)
            }
            Topic::Host => Message::Host((&proto::Host::decode(bytes)?).try_into()?),
            Topic::Gap => Message::Gap((&proto::Gap::decode(bytes)?).try_into()?),
            Topic::ViewMap | Topic::ViewPose | Topic::ViewScene | Topic::ViewLog => return Ok(None),
        }))
    }
}

fn list<'a, P, W: TryFrom<&'a P, Error = Refusal>>(shown: &'a [P]) -> Result<Vec<W>, Refusal> {
    shown.iter().map(W::try_from).collect()
}

impl From<&Host> for proto::Host {
    fn from(host: &Host) -> Self {
        let Host { since, until, busy, load_1min, cores } = *host;
        Self { since_ns: since.0, until_ns: until.0, busy, load_1min, cores }
    }
}

impl TryFrom<&proto::Host> for Host {
    type Error = Refusal;

    fn try_from(shown: &proto::Host) -> Result<Self, Refusal> {
        let proto::Host { since_ns, until_ns, busy, load_1min, cores } = *shown;
        if !(0.0..=1.0).contains(&busy) {
            return Err(Refusal::malformed("Host.busy", "0 to 1", busy));
        }
        if !(0.0..=1.0e6).contains(&load_1min) {
            return Err(Refusal::malformed("Host.load_1min", "0 to 1000000", load_1min));
        }
        Ok(Self { since: MonotonicNs(since_ns), until: MonotonicNs(until_ns), busy, load_1min, cores })
    }
}

impl From<&Gap> for proto::Gap {
    fn from(gap: &Gap) -> Self {
        let Gap { topic, from, through, counted } = gap.clone();
        Self { topic, from, through, counted }
    }
}

impl TryFrom<&proto::Gap> for Gap {
    type Error = Refusal;

    fn try_from(shown: &proto::Gap) -> Result<Self, Refusal> {
        let proto::Gap { topic, from, through, counted } = shown.clone();
        if through < from {
            return Err(Refusal::malformed("Gap.through", &format!("at least {from}"), through));
        }
        Ok(Self { topic, from, through, counted })
    }
}
