//! The channels of a recording.

use contract::message::{Message as _, Request as _};
use contract::{
    Brief, Command, Control, Heartbeat, MapPatch, MapRequest, Pacing, PastRequest, Policy, RobotId, State,
};

use report::Layer;
use report::layers::Look;

use crate::proto;

/// Number of the first robot: what is not a robot's own goes by its name.
pub const ROBOT: RobotId = RobotId(0);

/// A channel of a recording: first the public messages under the names of their services, then what the recorder
/// adds, then what is derived from them for viewers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    /// `hop/brief`: what the mission is.
    Brief,
    /// `hop/state`: the state after each decision.
    State,
    /// `hop/map`: patches of the observed map.
    Map,
    /// `hop/snapshot`: pages that the recorder asked for.
    Snapshot,
    /// `hop/rN/command`: commands of planners; of robots but the first in channels that come with their first message.
    Command,
    /// `hop/rN/policy`: policies for display.
    Policy,
    /// `hop/control`: orders such as pause.
    Control,
    /// `hop/tempo`: how landings are paced.
    Pacing,
    /// `hop/heartbeat`: signs of life of all processes.
    Heartbeat,
    /// `hop/past`: records that the recorder asked for.
    Past,
    /// `recorder/host`: load of the machine.
    Host,
    /// `recorder/gap`: messages that did not reach the recorder.
    Gap,
    /// `view/plan`: the policy near the robot and announced routes, a `foxglove.PointCloud`.
    ViewPlan,
    /// `view/route`: the ways that robots have come, a `foxglove.PointCloud`.
    ViewRoute,
    /// `view/robots`: robots and goals, a `foxglove.PointCloud`.
    ViewRobots,
    /// `view/transforms`: the frames of the robots, `foxglove.FrameTransforms`.
    ViewTransforms,
    /// `view/log`: what happened, a `foxglove.Log`.
    ViewLog,
    /// `view/map` of the relief, else `view/NAME`: a layer of the map, a `foxglove.PointCloud`.
    ViewLayer(Layer),
}

/// Channels before those for viewers.
const PUBLIC: [Channel; 12] = [
    Channel::Brief,
    Channel::State,
    Channel::Map,
    Channel::Snapshot,
    Channel::Command,
    Channel::Policy,
    Channel::Control,
    Channel::Pacing,
    Channel::Heartbeat,
    Channel::Past,
    Channel::Host,
    Channel::Gap,
];

/// Channels for viewers that show no layer of the map.
const VIEWS: [Channel; 5] =
    [Channel::ViewPlan, Channel::ViewRoute, Channel::ViewRobots, Channel::ViewTransforms, Channel::ViewLog];

/// Whether a layer has a channel. What robots entered has none: `view/route` shows it.
const fn is_recorded(layer: Layer) -> bool {
    !matches!(layer.definition().look, Look::Entries)
}

/// Number of all channels.
const COUNT: usize = {
    let (mut count, mut layer) = (PUBLIC.len() + VIEWS.len(), 0);
    while layer < Layer::ALL.len() {
        count += is_recorded(Layer::ALL[layer]) as usize;
        layer += 1;
    }
    count
};

/// The relief stands before the other channels for viewers, and the layers with a scale after them.
const fn all() -> [Channel; COUNT] {
    let mut all = [Channel::Brief; COUNT];
    let (mut count, mut place) = (0, 0);
    while place < PUBLIC.len() {
        all[count] = PUBLIC[place];
        (count, place) = (count + 1, place + 1);
    }
    place = 0;
    while place < Layer::ALL.len() {
        if matches!(Layer::ALL[place].definition().look, Look::Relief) {
            all[count] = Channel::ViewLayer(Layer::ALL[place]);
            count += 1;
        }
        place += 1;
    }
    place = 0;
    while place < VIEWS.len() {
        all[count] = VIEWS[place];
        (count, place) = (count + 1, place + 1);
    }
    place = 0;
    while place < Layer::ALL.len() {
        if Layer::ALL[place].scale().is_some() {
            all[count] = Channel::ViewLayer(Layer::ALL[place]);
            count += 1;
        }
        place += 1;
    }
    all
}

impl Channel {
    /// Every channel, in the order of the file.
    pub const ALL: [Channel; COUNT] = all();

    /// Its place among [`Channel::ALL`]; layers without a channel are after them.
    #[must_use]
    pub fn place(self) -> usize {
        Self::ALL.iter().position(|channel| *channel == self).unwrap_or(COUNT)
    }

    /// Topic of the channel: for public messages the name of the service.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Channel::Brief => Brief::SERVICE.name_of(ROBOT),
            Channel::State => State::SERVICE.name_of(ROBOT),
            Channel::Map => MapPatch::SERVICE.name_of(ROBOT),
            Channel::Snapshot => MapRequest::SERVICE.name_of(ROBOT),
            Channel::Command => Command::SERVICE.name_of(ROBOT),
            Channel::Policy => Policy::SERVICE.name_of(ROBOT),
            Channel::Control => Control::SERVICE.name_of(ROBOT),
            Channel::Pacing => Pacing::SERVICE.name_of(ROBOT),
            Channel::Heartbeat => Heartbeat::SERVICE.name_of(ROBOT),
            Channel::Past => PastRequest::SERVICE.name_of(ROBOT),
            Channel::Host => "recorder/host".into(),
            Channel::Gap => "recorder/gap".into(),
            Channel::ViewPlan => "view/plan".into(),
            Channel::ViewRoute => "view/route".into(),
            Channel::ViewRobots => "view/robots".into(),
            Channel::ViewTransforms => "view/transforms".into(),
            Channel::ViewLog => "view/log".into(),
            Channel::ViewLayer(layer) => match layer.definition().look {
                Look::Relief => "view/map".into(),
                Look::Entries | Look::Scale(_) => format!("view/{}", layer.definition().name),
            },
        }
    }

    /// The channel with this topic; commands of any robot are [`Channel::Command`]. In recordings of earlier builds the topics of
    /// state, map, snapshot, control and pacing have the number of a robot too (P-OLD-RECORDING).
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        let found = |name: &str| Self::ALL.into_iter().find(|topic| topic.name() == name);
        let command = || Command::SERVICE.robot_of(name).map(|_| Channel::Command);
        let of_earlier_build = || found(&name.replacen("hop/r0/", "hop/", 1));
        found(name).or_else(command).or_else(of_earlier_build)
    }

    /// Full protobuf name of its messages.
    #[must_use]
    pub fn schema(self) -> &'static str {
        match self {
            Channel::Brief => "hopper.Brief",
            Channel::State => "hopper.State",
            Channel::Map => "hopper.MapPatch",
            Channel::Snapshot => "hopper.MapPage",
            Channel::Command => "hopper.Command",
            Channel::Policy => "hopper.Policy",
            Channel::Control => "hopper.Control",
            Channel::Pacing => "hopper.Tempo",
            Channel::Heartbeat => "hopper.Heartbeat",
            Channel::Past => "hopper.Past",
            Channel::Host => "hopper.Host",
            Channel::Gap => "hopper.Gap",
            Channel::ViewPlan | Channel::ViewRoute | Channel::ViewRobots | Channel::ViewLayer(_) => {
                "foxglove.PointCloud"
            }
            Channel::ViewTransforms => "foxglove.FrameTransforms",
            Channel::ViewLog => "foxglove.Log",
        }
    }

    /// Serialised file descriptor set of its schema.
    #[must_use]
    pub fn descriptors(self) -> &'static [u8] {
        if self.is_view() { proto::FOXGLOVE } else { proto::HOPPER }
    }

    /// Whether its messages are derived from others, for viewers.
    #[must_use]
    pub fn is_view(self) -> bool {
        self >= Channel::ViewPlan
    }
}
