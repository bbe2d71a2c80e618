//! How a reader catches up with a mission, whenever it begins to listen and whatever it has missed.
//!
//! Each module follows one thing that hopper-sim or perception knows: what is published is taken as it comes, what was
//! missed is asked for until it is whole. A follower says what to ask for and when; sending is the caller's business.
//!
//! | follower | follows | asks |
//! | --- | --- | --- |
//! | [`Mission`] | brief, state, robots | nothing: they are published again |
//! | [`PastFollower`] | executed decisions | `hop/past` |
//! | [`Replica`] | the observed map | `hop/snapshot` |
//! | [`PriorFollower`] | what is known of uncertain ground beforehand | `hop/prior` |
//! | [`TableFollower`] | where hops end, as planners are to believe it | `hop/table` |
//! | [`RouteFollower`], [`MissingRoutes`] | points of routes that robots announce | `hop/routes` |
//! | [`DetailFollower`] | what the motion model tells of decisions | `hop/details` |
//! | [`TruthFollower`] | the true ground | `truth/terrain` |
//!
//! All of them wait equally long for an answer, [`ASK_AGAIN_NS`](contract::limits::ASK_AGAIN_NS), then ask again; the next
//! page is asked for at once. Readers differ in what they fold, and in three points that follow from it:
//!
//! - perception folds no record beyond its state, since a map is that of one state; monitor and recorder fold all that
//!   they get, so they have to tell late states apart ([`PastFollower::is_late`]).
//! - perception and monitor take the last decision from a state; a recorder needs the record itself, and asks for it now
//!   and then only ([`PastFollower::ask_after`]), as it would otherwise ask after each decision.
//! - a planner keeps the prior; displays take it once and keep what they make of it ([`PriorFollower::take`]).
//!
//! No I/O, no clock in here.

#![warn(clippy::disallowed_methods)]

mod details;
mod gathering;
mod missing_routes;
mod mission;
mod page_cursor;
mod past;
mod prior;
mod replica;
mod route;
mod table;
mod timeline;
mod truth;

pub use details::DetailFollower;
pub use missing_routes::MissingRoutes;
pub use mission::{Heard, Mission};
pub use past::{Link, PastFollower};
pub use prior::PriorFollower;
pub use replica::Replica;
pub use route::RouteFollower;
pub use table::TableFollower;
pub use truth::TruthFollower;
