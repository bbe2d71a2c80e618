//! What travels between simulated processes, by topic.

use std::rc::Rc;

use contract::service::{self, Topic as Service};
use contract::{
    Brief, Command, Heartbeat, Incarnation, ObservedMap, PastPage, PastRequest, Refusal, RobotId, Role,
    RunId, State,
};
use serde::Serialize;
use terrain::Terrain;

/// Where a message belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Topic {
    /// `truth/terrain`.
    Terrain,
    /// `hop/brief`.
    Brief,
    /// `hop/rN/state`.
    State,
    /// `hop/rN/map`.
    Map,
    /// `hop/rN/command`.
    Command,
    /// `hop/heartbeat`.
    Heartbeat,
    /// `hop/past`, requests.
    Asked,
    /// `hop/past`, answers.
    Answered,
}

/// A message; what is large is shared.
#[derive(Clone, Debug)]
pub enum Message {
    /// The truth.
    Terrain(RunId, Rc<Terrain>),
    /// The brief.
    Brief(Rc<Brief>),
    /// The state.
    State(Rc<State>),
    /// The observed map.
    Map(Rc<ObservedMap>),
    /// A command, or what was to pass for one.
    Command(Rc<Result<Command, Refusal>>),
    /// A sign of life.
    Heartbeat(Rc<Heartbeat>),
    /// A request for the past with its number and who asks.
    Asked(PastRequest, u64, Incarnation),
    /// The answer to the request of this number.
    Answered(Rc<PastPage>, u64),
}

impl Topic {
    /// Every topic.
    pub const ALL: [Topic; 8] = [
        Topic::Terrain,
        Topic::Brief,
        Topic::State,
        Topic::Map,
        Topic::Command,
        Topic::Heartbeat,
        Topic::Asked,
        Topic::Answered,
    ];

    /// The name under which faults of the topic are counted.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Topic::Terrain => "terrain",
            Topic::Brief => "brief",
            Topic::State => "state",
            Topic::Map => "map",
            Topic::Command => "command",
            Topic::Heartbeat => "heartbeat",
            Topic::Asked => "asked",
            Topic::Answered => "answered",
        }
    }

    /// Its quality of service; request and response have none of their own.
    fn service(self) -> Option<Service> {
        let robot = RobotId(0);
        match self {
            Topic::Terrain => Some(service::truth()),
            Topic::Brief => Some(service::brief()),
            Topic::State => Some(service::state(robot)),
            Topic::Map => Some(service::map(robot)),
            Topic::Command => Some(service::command(robot)),
            Topic::Heartbeat => Some(service::heartbeat()),
            Topic::Asked | Topic::Answered => None,
        }
    }

    /// Messages a reader's queue holds before the oldest gives way; per writer on the real middleware,
    /// per reader here, which is the harder case.
    #[must_use]
    pub fn buffer(self) -> usize {
        self.service().map_or(service::PAST_CLIENTS_MAX, |service| service.buffer)
    }

    /// Whether a late reader gets the writer's last message.
    #[must_use]
    pub fn has_history(self) -> bool {
        self.service().is_some_and(|service| service.history > 0)
    }

    /// Whether `role` reads it. An answer goes to who asked, whoever that is.
    #[must_use]
    pub fn is_read_by(self, role: Role) -> bool {
        match self {
            Topic::Terrain => role == Role::Perception,
            Topic::Brief => role != Role::HopperSim,
            Topic::State => role != Role::HopperSim,
            Topic::Map => matches!(role, Role::Planner | Role::Monitor),
            Topic::Command | Topic::Asked => role == Role::HopperSim,
            Topic::Heartbeat => true,
            Topic::Answered => false,
        }
    }

    /// Whether its arrival wakes a process of `role`, as the shells have it.
    #[must_use]
    pub fn wakes(self, role: Role) -> bool {
        match self {
            Topic::State => role == Role::Perception,
            Topic::Map => role == Role::Planner,
            Topic::Command | Topic::Asked => role == Role::HopperSim,
            Topic::Answered => true,
            Topic::Terrain | Topic::Brief | Topic::Heartbeat => false,
        }
    }
}

impl Message {
    /// Where it belongs.
    #[must_use]
    pub fn topic(&self) -> Topic {
        match self {
            Message::Terrain(..) => Topic::Terrain,
            Message::Brief(_) => Topic::Brief,
            Message::State(_) => Topic::State,
            Message::Map(_) => Topic::Map,
            Message::Command(_) => Topic::Command,
            Message::Heartbeat(_) => Topic::Heartbeat,
            Message::Asked(..) => Topic::Asked,
            Message::Answered(..) => Topic::Answered,
        }
    }
}
