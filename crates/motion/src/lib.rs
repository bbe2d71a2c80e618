//! How a hop moves the hopper: the law of its scatter, its flight through the air, what it costs in steps.
//!
//! Home of the motion model of Sakamoto & Kunii 2023, section IV. Truth and belief use the very same
//! forms; what differs is the ground they are given. Parameters are always arguments, so this crate
//! holds no constant of any paper. Randomness is a pure function of (seed, domain, robot, decision).

pub mod draw;
pub mod flight;
pub mod landing;
pub mod step_count;
pub mod transition;

pub use draw::{Domain, Draw};
pub use flight::{arc_height_m, flight, launch_velocity_mps, position_m};
pub use landing::landing;
pub use step_count::steps;
pub use transition::{Transition, soil_motion, transition, transitions};
