//! The sensor of a rover that covers ground: the cells up to so many columns and rows away.

use contract::{Brief, Pose, Square};

use super::{Sensor, indices};

impl Sensor for Square {
    fn around(&self, brief: &Brief, pose: Pose) -> Vec<usize> {
        let (at, range) = (pose.cell, self.range_cells as i32);
        indices(brief, |cell| (cell.x - at.x).abs() <= range && (cell.y - at.y).abs() <= range)
    }
}
