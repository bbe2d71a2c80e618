//! What a robot is: how it gets about, and what anyone may know of that.

mod driver;
mod helicopter;
mod hopper;
mod rover;

use super::kind::kinds;
use crate::Action;

pub use driver::Driver;
pub use helicopter::Helicopter;
pub use hopper::{Hopper, MotionParameters, SoilMotion};
pub use rover::Rover;

kinds! {
    /// What a robot is, with what its actions depend on.
    pub enum Body, each BodyKind, block of 16, refused as "robot.body" {
        /// Hops to one of four cells at a time.
        Hopper(Hopper) = 1,
        /// Drives to one of the four neighbouring cells at a time.
        Rover(Rover) = 2,
        /// Drives from point to point, as fast as the ground lets it.
        Driver(Driver) = 3,
        /// Flies from point to point, above all others.
        Helicopter(Helicopter) = 4,
    }
}

/// What can be asked of any body.
pub trait BodyKind {
    /// What people call it.
    fn word(&self) -> &'static str;

    /// Whether it takes up the cell that it is on.
    fn is_on_ground(&self) -> bool {
        true
    }

    /// Whether it hops.
    fn hops(&self) -> bool {
        false
    }

    /// Whether it drives over ground whose speed is uncertain.
    fn drives(&self) -> bool {
        false
    }

    /// The action by which it goes on along its route; `None` if it goes from cell to cell and has no routes.
    fn along_route(&self) -> Option<Action> {
        None
    }
}
