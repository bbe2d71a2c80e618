//! Which cells a sensor sees: the closed disc of radius gain · (h + offset), P23 section IV.

use contract::{Cell, Grid, Pose, SensorParameters};

/// Sensing radius in metres at height `height_m` above the datum, clamped to the sensor's range.
#[must_use]
pub fn radius_m(sensor: &SensorParameters, height_m: f64) -> f64 {
    (sensor.gain * (height_m + sensor.offset_m)).clamp(sensor.radius_min_m, sensor.radius_max_m)
}

/// The cells of `grid` whose centres lie within the closed disc around `pose`, in index order. A pose
/// outside the grid sees nothing.
pub fn disc(grid: Grid, sensor: &SensorParameters, pose: Pose) -> impl Iterator<Item = Cell> {
    let radius_cells = radius_m(sensor, pose.height_m) / grid.cell_size_m;
    let reach = if grid.contains(pose.cell) { radius_cells.floor() as i32 } else { -1 };
    let centre = pose.cell;
    (-reach..=reach)
        .flat_map(move |dy| (-reach..=reach).map(move |dx| (dx, dy)))
        .filter(move |&(dx, dy)| f64::from(dx * dx + dy * dy) <= radius_cells * radius_cells)
        .map(move |(dx, dy)| Cell::new(centre.x + dx, centre.y + dy))
        .filter(move |&cell| grid.contains(cell))
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::GradientSource;

    fn sensor() -> SensorParameters {
        SensorParameters {
            gain: 2.0,
            offset_m: 1.0,
            radius_min_m: 1.0,
            radius_max_m: 12.0,
            gradient: GradientSource::Measured,
        }
    }

    fn seen(x: i32, y: i32, height_m: f64) -> usize {
        let grid = Grid::new(20, 20, 1.0, 1).unwrap();
        disc(grid, &sensor(), Pose { cell: Cell::new(x, y), height_m }).count()
    }

    #[test]
    fn the_radius_grows_by_two_metres_a_metre_and_is_clamped() {
        assert_eq!(radius_m(&sensor(), 0.0), 2.0);
        assert_eq!(radius_m(&sensor(), 1.5), 5.0);
        assert_eq!(radius_m(&sensor(), -4139.0), 1.0);
        assert_eq!(radius_m(&sensor(), 4139.0), 12.0);
    }

    #[test]
    fn a_disc_of_two_metres_is_closed_and_holds_thirteen_cells() {
        assert_eq!(seen(10, 10, 0.0), 13);
        assert_eq!(seen(10, 10, -0.01), 9, "just below two metres the four far cells are out of sight");
        assert_eq!(seen(0, 0, 0.0), 6, "a corner sees a quarter of the disc");
        assert_eq!(seen(-1, 5, 0.0), 0, "outside the map there is nothing to see");
    }
}
