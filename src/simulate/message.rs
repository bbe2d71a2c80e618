//! What travels between simulated processes, by topic.

use std::rc::Rc;

use contract::service::{self, Topic as Service};
use contract::{
    Brief, Command, Heartbeat, Incarnation, MapPage, MapPatch, MapRequest, PastPage, PastRequest, Policy,
    Refusal, RobotId, Role, State, TruthPage, TruthRequest,
};
use serde::Serialize;

/// Where a message belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Topic {
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
    /// `hop/rN/policy`.
    Policy,
    /// `hop/past`, requests.
    Asked,
    /// `hop/past`, answers.
    Answered,
    /// `truth/terrain`, requests.
    TruthAsked,
    /// `truth/terrain`, answers.
    TruthAnswered,
    /// `hop/rN/snapshot`, requests.
    MapAsked,
    /// `hop/rN/snapshot`, answers.
    MapAnswered,
}

/// A message; what is large is shared.
#[derive(Clone, Debug)]
pub enum Message {
    /// The brief.
    Brief(Rc<Brief>),
    /// The state.
    State(Rc<State>),
    /// What a landing changed in the observed map.
    Map(Rc<MapPatch>),
    /// A command, or what was to pass for one.
    Command(Rc<Result<Command, Refusal>>),
    /// A sign of life.
    Heartbeat(Rc<Heartbeat>),
    /// What a planner would do elsewhere.
    Policy(Rc<Policy>),
    /// A request for the past with its number and who asks.
    Asked(PastRequest, u64, Incarnation),
    /// The answer to the request of this number.
    Answered(Rc<PastPage>, u64),
    /// A request for the truth.
    TruthAsked(TruthRequest, u64, Incarnation),
    /// Its answer.
    TruthAnswered(Rc<TruthPage>, u64),
    /// A request for the map.
    MapAsked(MapRequest, u64, Incarnation),
    /// Its answer.
    MapAnswered(Rc<MapPage>, u64),
}

impl Topic {
    /// Every topic.
    pub const ALL: [Topic; 12] = [
        Topic::Brief,
        Topic::State,
        Topic::Map,
        Topic::Command,
        Topic::Heartbeat,
        Topic::Policy,
        Topic::Asked,
        Topic::Answered,
        Topic::TruthAsked,
        Topic::TruthAnswered,
        Topic::MapAsked,
        Topic::MapAnswered,
    ];

    /// The name under which faults of the topic are counted.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Topic::Brief => "brief",
            Topic::State => "state",
            Topic::Map => "map",
            Topic::Command => "command",
            Topic::Heartbeat => "heartbeat",
            Topic::Policy => "policy",
            Topic::Asked => "asked",
            Topic::Answered => "answered",
            Topic::TruthAsked => "truth_asked",
            Topic::TruthAnswered => "truth_answered",
            Topic::MapAsked => "map_asked",
            Topic::MapAnswered => "map_answered",
        }
    }

    /// Its quality of service; request and response have none of their own.
    fn service(self) -> Option<Service> {
        let robot = RobotId(0);
        match self {
            Topic::Brief => Some(service::brief()),
            Topic::State => Some(service::state(robot)),
            Topic::Map => Some(service::map(robot)),
            Topic::Command => Some(service::command(robot)),
            Topic::Heartbeat => Some(service::heartbeat()),
            Topic::Policy => Some(service::policy(robot)),
            Topic::Asked
            | Topic::Answered
            | Topic::TruthAsked
            | Topic::TruthAnswered
            | Topic::MapAsked
            | Topic::MapAnswered => None,
        }
    }

    /// Messages a reader's queue holds before the oldest gives way; per writer on the real middleware,
    /// per reader here, which is the harder case.
    #[must_use]
    pub fn buffer(self) -> usize {
        self.service().map_or(service::past().max_clients, |service| service.buffer)
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
            Topic::Brief => role != Role::HopperSim,
            Topic::State => role != Role::HopperSim,
            Topic::Map => matches!(role, Role::Planner | Role::Monitor),
            Topic::Command | Topic::Policy | Topic::Asked | Topic::TruthAsked => role == Role::HopperSim,
            Topic::MapAsked => role == Role::Perception,
            Topic::Heartbeat => true,
            Topic::Answered | Topic::TruthAnswered | Topic::MapAnswered => false,
        }
    }

    /// Whether its arrival wakes a process of `role`, as the shells have it.
    #[must_use]
    pub fn wakes(self, role: Role) -> bool {
        match self {
            Topic::State => role == Role::Perception,
            Topic::Map => role == Role::Planner,
            Topic::Command | Topic::Asked | Topic::TruthAsked => role == Role::HopperSim,
            Topic::MapAsked => role == Role::Perception,
            Topic::Answered | Topic::TruthAnswered | Topic::MapAnswered => true,
            Topic::Brief | Topic::Heartbeat | Topic::Policy => false,
        }
    }
}

impl Message {
    /// Where it belongs.
    #[must_use]
    pub fn topic(&self) -> Topic {
        match self {
            Message::Brief(_) => Topic::Brief,
            Message::State(_) => Topic::State,
            Message::Map(_) => Topic::Map,
            Message::Command(_) => Topic::Command,
            Message::Heartbeat(_) => Topic::Heartbeat,
            Message::Policy(_) => Topic::Policy,
            Message::Asked(..) => Topic::Asked,
            Message::Answered(..) => Topic::Answered,
            Message::TruthAsked(..) => Topic::TruthAsked,
            Message::TruthAnswered(..) => Topic::TruthAnswered,
            Message::MapAsked(..) => Topic::MapAsked,
            Message::MapAnswered(..) => Topic::MapAnswered,
        }
    }
}
