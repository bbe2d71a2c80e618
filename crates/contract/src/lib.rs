//! The vocabulary that Hopper's processes share.
//!
//! Two layers, never mixed. The *domain* types in this crate's modules are what engines compute
//! with: plain structs in the field's own terms, SI units last in each name. The *wire* types in
//! [`wire`] are what crosses shared memory: integers and floats only, so that no byte pattern a
//! rogue process writes can be undefined behaviour. The only way from wire to domain is `TryFrom`,
//! which refuses with a named reason.
//!
//! No I/O, no clock, no middleware in here.

#![warn(clippy::disallowed_methods)]

pub mod action;
pub mod belief;
pub mod brief;
pub mod command;
pub mod control;
pub mod digest;
pub mod grid;
pub mod ground;
pub mod heartbeat;
pub mod identity;
pub mod limits;
pub mod map;
pub mod message;
pub mod name;
pub mod origin;
pub mod outcome;
pub mod pace;
pub mod page_cursor;
pub mod past;
pub mod patch;
pub mod patrol;
pub mod payoff;
pub mod peer_table;
pub mod policy;
pub mod prior;
pub mod reading;
pub mod record;
pub mod refusal;
pub mod replica;
pub mod route;
pub mod state;
pub mod task;
pub mod team;
pub mod timeline;
pub mod timing;
pub mod treasure;
pub mod truth;
pub mod wire;

pub use action::{Action, Direction};
pub use brief::{
    Brief, GradientSource, Guard, Limits, MotionParameters, Payoff, Priors, Profile, Range, SensorParameters,
    SoilMotion, Weights,
};
pub use command::Command;
pub use control::{Control, Order, Pacing};
pub use digest::Digest;
pub use grid::{Cell, Grid};
pub use ground::{DriveSpeed, Ground, Soil};
pub use heartbeat::Heartbeat;
pub use identity::{Decision, Incarnation, Leader, RobotId, Role, RouteId, RunId, Term};
pub use map::ObservedMap;
pub use message::{Message, Payload, Request};
pub use name::Name;
pub use origin::{Origin, Vetoed};
pub use outcome::{Branch, Flight, Outcome, Status};
pub use pace::Pace;
pub use page_cursor::PageCursor;
pub use past::{PastPage, PastRequest};
pub use patch::{MapPage, MapPatch, MapRequest, SeenCell};
pub use patrol::Patrol;
pub use peer_table::PeerTable;
pub use policy::{Policy, PolicyCell};
pub use prior::{Prior, PriorGathering, PriorPage, PriorRequest, SpeedPrior};
pub use reading::{DistanceNorm, Reading};
pub use record::Record;
pub use refusal::{Refusal, RefusalCounts};
pub use replica::Replica;
pub use route::{Announcement, Route, RoutePage, RouteRequest, Routes, Waypoint};
pub use state::{Pose, State};
pub use task::{Cover, CoverMode, Scout, Task};
pub use team::{Member, Placement, Robot, RobotSet, Sensor, Standing, Team, Travel, Vehicle};
pub use timeline::Timeline;
pub use timing::{MonotonicNs, Stage, Timing};
pub use treasure::Collected;
pub use truth::{Gathering, Truth, TruthPage, TruthRequest};
