//! How a hop moves the hopper: the law of its scatter, its flight through the air, what it costs in steps.
//!
//! Home of the motion model of Sakamoto & Kunii 2023 (P23), section IV, and of what its predecessor on known
//! ground, Sakamoto & Kubota 2022 (P22), has beyond it: launches at any angle, collisions, the vertical hop. Truth and belief use the very same
//! forms; what differs is the ground they are given. Parameters are always arguments, so this crate
//! holds no constant of any paper. Randomness is a pure function of (seed, domain, robot, decision).

pub mod collision;
pub mod draw;
pub mod flight;
pub mod landing;
pub mod launch;
pub mod step_count;
pub mod transition;
pub mod vertical;

pub use collision::{Profile, collision_m};
pub use draw::{Domain, Draw};
pub use flight::{arc_height_m, flight, launch_velocity_mps, position_m};
pub use landing::landing;
pub use launch::Launch;
pub use step_count::steps;
pub use transition::{Transition, soil_motion, transition, transitions};
pub use vertical::vertical_transition;
