//! Turns recorded missions into bags of ROS 2.
//!
//! [`Mission`] gathers a run of a recording, [`convert`] writes it as a rosbag2 MCAP file with the `metadata.yaml` that
//! belongs to it. Messages are the standard ones of ROS 2, in CDR ([`cdr`]); each is declared once, and its definition for
//! readers without ROS follows from the declaration ([`message`]).
//!
//! Frames follow REP-103 and REP-105: `map` has x east, y north, z up in metres from the south-western corner of cell (0, 0)
//! and the datum; `robot_N/odom` lies in it unmoved, since a mission knows its places exactly; `robot_N/base_link` is the
//! robot.
//!
//! No I/O, no clock: times are those of the recording, bytes go to a writer that the caller opened.

#![warn(clippy::disallowed_methods)]

mod bag;
pub mod cdr;
mod clock;
mod conversion;
mod diagnostics;
mod error;
mod grid_map;
mod landing;
mod map_follower;
pub mod message;
mod mission;
mod occupancy;
mod pose;
mod qos;
mod seen_box;
mod thinning;
mod way;

pub use bag::{Bag, BagSummary};
pub use clock::Clock;
pub use conversion::{Conversion, Converted, convert};
pub use error::Ros2Error;
pub use landing::Landing;
pub use mission::Mission;
pub use qos::Qos;
