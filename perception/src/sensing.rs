//! Which cells a robot sees from where it is.

use std::num::NonZeroU8;

use contract::{Cell, Grid, Pose, Sensor};

/// Indices of the cells that a robot with `sensor` sees from `pose`, whatever it sees on its way there.
pub fn around(grid: Grid, sensor: Sensor, pose: Pose) -> impl Iterator<Item = usize> {
    cells(grid, sensor, pose).filter_map(move |cell| grid.index(cell))
}

/// What `sensor` reports of these cells, with their indices.
pub fn reports(grid: Grid, sensor: Sensor, pose: Pose) -> impl Iterator<Item = (usize, NonZeroU8)> {
    let reports = sensor.reports(0.0).is_some();
    let seen = reports.then(|| cells(grid, sensor, pose)).into_iter().flatten();
    seen.filter_map(move |cell| {
        let distance_m = cell.distance_cells(pose.cell) * grid.cell_size_m;
        Some((grid.index(cell)?, sensor.reports(distance_m)?))
    })
}

fn cells(grid: Grid, sensor: Sensor, pose: Pose) -> impl Iterator<Item = Cell> {
    let view = sensor.around(&grid, pose.height_m);
    view.into_iter().flat_map(move |view| view.cells(grid, pose.cell))
}
