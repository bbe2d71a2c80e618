//! What a robot sees of the ground around it.

mod view;

use std::num::NonZeroU8;

use super::kind::kinds;
use crate::Grid;

pub use view::View;

kinds! {
    /// What a robot sees of the ground around it.
    pub enum Sensor, each SensorKind, block of 8, refused as "robot.sensor" {
        disc => Disc(SensorParameters) = 1, "A disc that grows with the height.";
        square => Square(Square) = 2, "The cells at most so many columns and rows away.";
        track => Track(Track) = 3, "The cells that it drives over.";
        camera => Camera(Camera) = 4, "The cells whose middle is near its way: what a camera shows that looks down in flight.";
        erring_camera => ErringCamera(ErringCamera) = 5, "As a camera, but what it reads of a cell's speed may be wrong: partial observation (Folsom et al. 2021, eqs 13 to 16).";
    }
}

/// What can be asked of any sensor.
pub trait SensorKind {
    /// What it sees, as `hopper scenario check` says it; `None` where its name says enough.
    fn in_words(&self) -> Option<String> {
        None
    }

    /// What it shows around a robot that is `height_m` above the datum, if it shows more than what is on the way.
    fn around(&self, _grid: &Grid, _height_m: f64) -> Option<View> {
        None
    }

    /// What it reports of a cell around it beside the ground, the middle of the cell so far away; see
    /// [`crate::Ground::reported`]. A sensor that reports nothing does so at every distance.
    fn reports(&self, _distance_m: f64) -> Option<NonZeroU8> {
        None
    }

    /// How far it sees to each side of a way in flight, metres, if it is a camera.
    fn view_m(&self) -> Option<f64> {
        None
    }

    /// How likely it reads the true speed of a cell, if it may err.
    fn accuracy(&self) -> Option<f64> {
        None
    }
}
