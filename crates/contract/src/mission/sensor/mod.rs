//! What a robot sees of the ground around it.

mod camera;
mod disc;
mod erring_camera;
mod square;
mod track;

use super::kind::kinds;

pub use camera::Camera;
pub use disc::{GradientSource, SensorParameters};
pub use erring_camera::ErringCamera;
pub use square::Square;
pub use track::Track;

kinds! {
    /// What a robot sees of the ground around it.
    pub enum Sensor, each SensorKind, block of 8, refused as "robot.sensor" {
        /// A disc that grows with the height.
        Disc(SensorParameters) = 1,
        /// The cells at most so many columns and rows away.
        Square(Square) = 2,
        /// The cells that it drives over.
        Track(Track) = 3,
        /// The cells whose middle is near its way: what a camera shows that looks down in flight.
        Camera(Camera) = 4,
        /// As a camera, but what it reads of a cell's speed may be wrong: partial observation (Folsom et al. 2021, eqs 13 to 16).
        ErringCamera(ErringCamera) = 5,
    }
}

/// What can be asked of any sensor.
pub trait SensorKind {
    /// How far it sees to each side of a way in flight, metres, if it is a camera.
    fn view_m(&self) -> Option<f64> {
        None
    }

    /// How likely it reads the true speed of a cell, if it may err.
    fn accuracy(&self) -> Option<f64> {
        None
    }
}
