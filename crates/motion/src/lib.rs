//! The motion of a hop: where it lands, how it flies, and what it costs in steps.
//!
//! The crate implements the motion model of Sakamoto & Kunii 2023 (P23), section IV, and from its predecessor on known
//! ground, Sakamoto & Kubota 2022 (P22), launches at any angle, collisions and the vertical hop. Simulator and planners
//! use the same functions and differ only in the ground they pass. Parameters are always arguments, so the crate holds no
//! constant of any paper. Random numbers are a pure function of (seed, domain, robot, decision).

#![warn(clippy::disallowed_methods)]

pub mod collision;
pub mod draw;
pub mod flight;
pub mod landing;
pub mod launch;
pub mod step_count;
pub mod transition;
pub mod vertical;

pub use collision::{GroundProfile, collision_m};
pub use draw::{Domain, Draw};
pub use flight::{arc_height_m, flight, launch_velocity_mps, position_m};
pub use landing::landing;
pub use launch::Launch;
pub use step_count::steps;
pub use transition::{Transition, soil_motion, transition, transitions};
pub use vertical::vertical_transition;
