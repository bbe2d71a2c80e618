//! The vocabulary that Hopper's processes share.
//!
//! Two layers, never mixed. The *domain* types in this crate's modules are what engines compute
//! with: plain structs in the field's own terms, SI units last in each name. The *wire* types in
//! [`wire`] are what crosses shared memory: integers and floats only, so that no byte pattern a
//! rogue process writes can be undefined behaviour. The only way from wire to domain is `TryFrom`,
//! which refuses with a named reason.
//!
//! The modules here are the words that all others use: a cell, an action, an outcome, who speaks. [`mission`] is what is to
//! be done, [`protocol`] what processes tell each other meanwhile, [`map`] what is known of the ground; each knows those
//! before it. [`message`] says what a message is.
//!
//! ```
//! use contract::{Cell, Direction, Grid};
//!
//! // 20 × 20 cells of half a metre; a hop crosses two of them.
//! let grid = Grid::new(20, 20, 0.5, 2)?;
//! assert_eq!(grid.hop(Cell::new(3, 4), Direction::North), Cell::new(3, 6));
//! assert_eq!(grid.hop_distance_m(), 1.0);
//! # Ok::<(), contract::grid::GridError>(())
//! ```
//!
//! No I/O, no clock, no middleware in here.

#![warn(clippy::disallowed_methods)]

pub mod action;
pub mod block;
pub(crate) mod codec;
pub mod digest;
pub mod field;
pub mod grid;
pub mod ground;
pub mod identity;
pub mod limits;
pub mod map;
pub mod message;
pub mod mission;
pub mod motion_model;
pub mod name;
pub mod origin;
pub mod outcome;
pub mod profile;
pub mod protocol;
pub mod range;
pub mod refusal;
pub mod robot_set;
pub mod spelling;
pub mod timing;
pub mod treasure;
pub mod waypoint;
pub mod wire;

pub use action::{Action, Direction};
pub use digest::Digest;
pub use grid::{Cell, Grid};
pub use ground::{DriveSpeed, Ground, Soil};
pub use identity::{Decision, Incarnation, Leader, RobotId, Role, RouteId, RunId, Term};
pub use map::observed_map::ObservedMap;
pub use map::patch::{MapPage, MapPatch, MapRequest, SeenCell};
pub use map::prior::{Prior, PriorCell, PriorPage, PriorRequest, SpeedPrior};
pub use map::truth::{Truth, TruthPage, TruthRequest};
pub use message::{Message, Payload, Request};
pub use mission::account::Account;
pub use mission::body::*;
pub use mission::brief::{Brief, Guard, Limits, Payoff, Priors, Weights};
pub use mission::goal::*;
pub use mission::leg::Leg;
pub use mission::motion_table::{MotionRow, MotionTable, TableLanding, TablePage, TableRequest};
pub use mission::pace::Pace;
pub use mission::reading::{DistanceNorm, Reading, UnseenGround};
pub use mission::robot::{Placement, Robot, Robots};
pub use mission::sampling::Sampling;
pub use mission::sensor::*;
pub use motion_model::MotionModel;
pub use name::Name;
pub use origin::{Origin, Vetoed};
pub use outcome::{Branch, Flight, Outcome, Status};
pub use profile::Profile;
pub use protocol::command::Command;
pub use protocol::control::{Control, Order, Pacing};
pub use protocol::detail::{Detail, DetailId, DetailPage, DetailRequest, PathPoint};
pub use protocol::heartbeat::Heartbeat;
pub use protocol::missing_peer::MissingPeer;
pub use protocol::past::{PastPage, PastRequest};
pub use protocol::peer_table::PeerTable;
pub use protocol::policy::{Policy, PolicyCell};
pub use protocol::record::Record;
pub use protocol::route::{Announcement, Route, RoutePage, RouteRequest, Routes};
pub use protocol::state::{Pose, State};
pub use protocol::team::{Member, Standing, Team, Travel};
pub use range::Range;
pub use refusal::{Refusal, RefusalCounts};
pub use robot_set::RobotSet;
pub use timing::{MonotonicNs, Stage, Timing};
pub use treasure::Collected;
pub use waypoint::Waypoint;
