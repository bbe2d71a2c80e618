//! The motion of a hop: where it lands, how it flies, and what it costs in steps.
//!
//! The crate implements the motion model of Sakamoto & Kunii 2023 (P23), section IV, and from its predecessor on known
//! ground, Sakamoto & Kubota 2022 (P22), launches at any angle, collisions and the vertical hop. Simulator and planners
//! use the same functions and differ only in the ground they pass. Parameters are arguments; the one constant of a paper is
//! [`VERTICAL_DEG`], the 80° of P22. Random numbers are a pure function of (seed, domain, robot, decision).
//!
//! ```
//! use contract::{Grid, MotionParameters, Soil, SoilMotion};
//!
//! let soil = |intended, stuck, sideways, flights| SoilMotion { intended, stuck, sideways, flights };
//! let parameters = MotionParameters {
//!     hard: soil(0.9, 0.0, 0.05, 1),
//!     sand: soil(0.7, 0.1, 0.1, 2),
//!     slope_limit_rad: 30_f64.to_radians(),
//!     launch_angle_rad: 45_f64.to_radians(),
//!     gravity_mps2: 3.72,
//!     vertical: false,
//!     table: 0,
//! };
//! let grid = Grid::new(20, 20, 1.0, 1)?;
//! let flight = motion::flight(&parameters, &grid, Soil::Hard, 0.0);
//! assert!((flight.apex_height_m - 0.25).abs() < 1e-12, "a quarter of the distance, on the flat at 45°");
//! # Ok::<(), contract::grid::GridError>(())
//! ```

#![warn(clippy::disallowed_methods)]

pub mod clearance;
pub mod collision;
pub mod draw;
pub mod flight;
pub mod landing;
pub mod launch;
pub mod offer;
pub mod slope_class;
pub mod step_count;
pub mod transition;
pub mod vertical;

pub use clearance::{clears, design_launch, launch_over};
pub use collision::{GroundProfile, collision_m};
pub use draw::{Domain, Draw};
pub use flight::{arc_height_m, flight, launch_velocity_mps, position_m};
pub use landing::{landing, table_landing};
pub use launch::Launch;
pub use offer::{Offer, VERTICAL_DEG, VERTICAL_RAD, checked, offers, vertical_flight, vertical_launch};
pub use slope_class::slope_classes;
pub use step_count::steps;
pub use transition::{Transition, soil_motion, transition, transitions};
pub use vertical::vertical_transition;
