//! Where messages stand in a recording.

use contract::message::{Message as _, Request as _};
use contract::{
    Brief, Command, Control, Heartbeat, MapPatch, MapRequest, PastRequest, Policy, RobotId, State, Tempo,
};

use crate::proto;

/// The robot of a mission; recordings are of one.
pub const ROBOT: RobotId = RobotId(0);

/// A topic of a recording. The first are public messages under the names of their services, then what the
/// recorder adds, then what is drawn from them for viewers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Topic {
    /// `hop/brief`.
    Brief,
    /// `hop/rN/state`.
    State,
    /// `hop/rN/map`: patches.
    Map,
    /// `hop/rN/snapshot`: pages that the recorder asked for.
    Snapshot,
    /// `hop/rN/command`.
    Command,
    /// `hop/rN/policy`.
    Policy,
    /// `hop/rN/control`.
    Control,
    /// `hop/rN/tempo`.
    Tempo,
    /// `hop/heartbeat`.
    Heartbeat,
    /// `hop/past`: records that the recorder asked for.
    Past,
    /// `recorder/host`.
    Host,
    /// `recorder/gap`.
    Gap,
    /// `view/map`: the observed map, a `foxglove.Grid`.
    ViewMap,
    /// `view/pose`: a `foxglove.PoseInFrame`.
    ViewPose,
    /// `view/scene`: goal, treasures and hops, a `foxglove.SceneUpdate`.
    ViewScene,
    /// `view/log`: what happened, a `foxglove.Log`.
    ViewLog,
}

impl Topic {
    /// Every topic, in the order of their channels.
    pub const ALL: [Topic; 16] = [
        Topic::Brief,
        Topic::State,
        Topic::Map,
        Topic::Snapshot,
        Topic::Command,
        Topic::Policy,
        Topic::Control,
        Topic::Tempo,
        Topic::Heartbeat,
        Topic::Past,
        Topic::Host,
        Topic::Gap,
        Topic::ViewMap,
        Topic::ViewPose,
        Topic::ViewScene,
        Topic::ViewLog,
    ];

    /// Its name: that of the service, where it is one.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Topic::Brief => Brief::SERVICE.name_of(ROBOT),
            Topic::State => State::SERVICE.name_of(ROBOT),
            Topic::Map => MapPatch::SERVICE.name_of(ROBOT),
            Topic::Snapshot => MapRequest::SERVICE.name_of(ROBOT),
            Topic::Command => Command::SERVICE.name_of(ROBOT),
            Topic::Policy => Policy::SERVICE.name_of(ROBOT),
            Topic::Control => Control::SERVICE.name_of(ROBOT),
            Topic::Tempo => Tempo::SERVICE.name_of(ROBOT),
            Topic::Heartbeat => Heartbeat::SERVICE.name_of(ROBOT),
            Topic::Past => PastRequest::SERVICE.name_of(ROBOT),
            Topic::Host => "recorder/host".into(),
            Topic::Gap => "recorder/gap".into(),
            Topic::ViewMap => "view/map".into(),
            Topic::ViewPose => "view/pose".into(),
            Topic::ViewScene => "view/scene".into(),
            Topic::ViewLog => "view/log".into(),
        }
    }

    /// The topic of a name.
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }

    /// Name of its schema.
    #[must_use]
    pub fn schema(self) -> &'static str {
        match self {
            Topic::Brief => "hopper.Brief",
            Topic::State => "hopper.State",
            Topic::Map => "hopper.MapPatch",
            Topic::Snapshot => "hopper.MapPage",
            Topic::Command => "hopper.Command",
            Topic::Policy => "hopper.Policy",
            Topic::Control => "hopper.Control",
            Topic::Tempo => "hopper.Tempo",
            Topic::Heartbeat => "hopper.Heartbeat",
            Topic::Past => "hopper.Past",
            Topic::Host => "hopper.Host",
            Topic::Gap => "hopper.Gap",
            Topic::ViewMap => "foxglove.Grid",
            Topic::ViewPose => "foxglove.PoseInFrame",
            Topic::ViewScene => "foxglove.SceneUpdate",
            Topic::ViewLog => "foxglove.Log",
        }
    }

    /// Descriptors of its schema.
    #[must_use]
    pub fn descriptors(self) -> &'static [u8] {
        if self.is_view() { proto::FOXGLOVE } else { proto::HOPPER }
    }

    /// Whether it is drawn from others, for viewers.
    #[must_use]
    pub fn is_view(self) -> bool {
        self >= Topic::ViewMap
    }
}
