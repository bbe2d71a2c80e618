//! Contact dynamics of a hopping body: it flies, hits, bounces and rolls over a height field, and comes to rest.
//!
//! A sphere with inertia β m R² on ground that is bilinear between the centres of cells. Flight is exact; an impact is Coulomb's, with a
//! normal restitution that depends on the soil; rolling follows the balance of energy. Everything is a function of its arguments, in a
//! fixed order of operations, so it has the same bits on every platform.

#![warn(clippy::disallowed_methods)]
#![forbid(unsafe_code)]

mod body;
pub mod bounds;
mod flight;
mod hop;
mod impact;
mod launch;
mod noise;
mod plane;
mod roll;
mod soil;
mod surface;

pub use body::Body;
pub use hop::{End, Ending, Hop, Impact, Limits, Place};
pub use impact::impact;
pub use launch::{Aim, Known, LaunchErrors};
pub use noise::{NORMAL_MAX, Noise};
pub use plane::Plane;
pub use soil::Soil;
pub use surface::{Field, Surface};
