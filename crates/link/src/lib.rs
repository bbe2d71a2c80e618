//! The engines of the link to the ground: what is sent, and when.
//!
//! [`Downlink`] takes the messages of a mission and makes packets of them, within a [`Budget`] of bits a second of
//! mission time. What does not fit waits, or a newer message takes its place: a state is replaced by the next one, a
//! cell of the map by what is known of it later. So what waits is bounded, however fast the mission is, and nobody
//! waits for the link.
//!
//! [`GroundMap`] puts the map together again from patches of which some were lost.
//!
//! [`DownlinkPorts`] reads the messages, against the ports of any host.
//!
//! No I/O, no clock.

#![warn(clippy::disallowed_methods)]

mod budget;
mod clock;
mod downlink;
mod ground_map;
mod history;
mod map_sender;
mod ports;
mod shares;

pub use budget::{Budget, Passes, duration};
pub use clock::MissionClock;
pub use downlink::{Downlink, Input, Requests, Settings, Tally};
pub use ground_map::{Gap, GroundMap};
pub use ports::DownlinkPorts;
