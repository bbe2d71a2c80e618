//! A helicopter that looks at the ground ahead of a rover.
//!
//! The model is that of Folsom et al. 2021, as for [`rover`]: a camera sees a disc of ground below, a flight ends when its budget
//! of metres is used up, and what was seen is known exactly, unless a [`Sensor`] says how well.

#![warn(clippy::disallowed_methods)]

mod camera;
mod flight;
mod sensor;
mod sighting;
mod swath;

pub use camera::Camera;
pub use flight::{BUDGET_M, length_m, observe, scout, swaths, within_budget};
pub use sensor::{Estimate, Sensor, SensorError, combined_as_printed};
pub use sighting::Sighting;
pub use swath::{AreaCounts, RowSums, Swath};
