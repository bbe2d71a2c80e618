//! What a robot is: how it gets about, and what anyone may know of that.

use super::kind::kinds;
use crate::{Action, Direction};

kinds! {
    /// What a robot is, with what its actions depend on.
    pub enum Body, each BodyKind, block of 16, refused as "robot.body" {
        hopper => Hopper(Hopper) = 1, "Hops to one of four cells at a time.";
        rover => Rover(Rover) = 2, "Drives to one of the four neighbouring cells at a time.";
        driver => Driver(Driver) = 3, "Drives from point to point, as fast as the ground lets it.";
        helicopter => Helicopter(Helicopter) = 4, "Flies from point to point, above all others.";
    }
}

/// What can be asked of any body.
pub trait BodyKind {
    /// What people call it.
    fn word(&self) -> &'static str;

    /// What `hopper scenario check` says of its parameters and the heading at the start, behind where it starts and what it shall do;
    /// empty for nothing.
    fn in_words(&self, heading: Direction) -> String {
        let _ = heading;
        String::new()
    }

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
