//! The sensor of a hopper: a disc that grows with the height.

use contract::{Brief, GradientSource, Pose, SensorParameters};

use super::{Sensor, indices, is_inside};

impl Sensor for SensorParameters {
    fn around(&self, brief: &Brief, pose: Pose) -> Vec<usize> {
        let grid = brief.grid;
        let radius_m = (self.gain * (pose.height_m + self.offset_m))
            .max(self.radius_min_m)
            .min(self.radius_max_m)
            .max(f64::from(grid.hop_cells) * grid.cell_size_m);
        let is_here = is_inside(brief, pose.cell);
        indices(brief, |cell| {
            let (x_m, y_m) = (
                f64::from(cell.x - pose.cell.x) * grid.cell_size_m,
                f64::from(cell.y - pose.cell.y) * grid.cell_size_m,
            );
            is_here && x_m * x_m + y_m * y_m <= radius_m * radius_m * (1.0 + 1e-12)
        })
    }

    fn gradient(&self) -> Option<GradientSource> {
        Some(self.gradient)
    }
}
