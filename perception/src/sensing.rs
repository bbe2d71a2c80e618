//! Which cells a sensor sees: the closed disc of [`SensorParameters::reach_cells`], or a square of cells.

use contract::{Cell, Grid, Pose, Sensor, SensorParameters, Square};

/// The cells of `grid` whose centres lie within the closed disc around `pose`, in index order. A pose
/// outside the grid sees nothing.
pub fn disc(grid: Grid, sensor: &SensorParameters, pose: Pose) -> impl Iterator<Item = Cell> + use<> {
    let reach_cells = sensor.reach_cells(&grid, pose.height_m);
    let centre = pose.cell;
    // Clipped before it is walked: a sensor may see further than any grid is wide.
    let clip = |at: i32, side: u32| {
        let reach = if grid.contains(centre) { reach_cells as i32 } else { -1 };
        at.saturating_sub(reach).max(0)..=at.saturating_add(reach).min(side as i32 - 1)
    };
    let (columns, rows) = (clip(centre.x, grid.width), clip(centre.y, grid.height));
    rows.flat_map(move |y| columns.clone().map(move |x| Cell::new(x, y)))
        .filter(move |cell| cell.distance_cells(centre) <= reach_cells)
}

/// The cells of `grid` that a robot on `centre` sees with a sensor of square view, in index order.
pub fn square(grid: Grid, sensor: Square, centre: Cell) -> impl Iterator<Item = Cell> {
    let range = sensor.range_cells as i32;
    let clip = |at: i32, side: u32| (at - range).max(0)..=(at + range).min(side as i32 - 1);
    let (columns, rows) = (clip(centre.x, grid.width), clip(centre.y, grid.height));
    rows.flat_map(move |y| columns.clone().map(move |x| Cell::new(x, y)))
}

/// Indices of the cells that a robot with `sensor` sees from `pose`, whatever it sees on its way there.
pub fn around(grid: Grid, sensor: Sensor, pose: Pose) -> impl Iterator<Item = usize> {
    let (in_disc, in_square) = match sensor {
        Sensor::Disc(sensor) => (Some(disc(grid, &sensor, pose)), None),
        Sensor::Square(sensor) => (None, Some(square(grid, sensor, pose.cell))),
        // Those see along their way, not around a cell.
        Sensor::Track(_) | Sensor::Camera(_) | Sensor::ErringCamera(_) => (None, None),
    };
    let cells = in_disc.into_iter().flatten().chain(in_square.into_iter().flatten());
    cells.filter_map(move |cell| grid.index(cell))
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
        assert_eq!(sensor().radius_m(0.0), 2.0);
        assert_eq!(sensor().radius_m(1.5), 5.0);
        assert_eq!(sensor().radius_m(-4139.0), 1.0);
        assert_eq!(sensor().radius_m(4139.0), 12.0);
    }

    #[test]
    fn a_disc_of_two_metres_is_closed_and_holds_thirteen_cells() {
        assert_eq!(seen(10, 10, 0.0), 13);
        assert_eq!(seen(10, 10, -0.01), 9, "just below two metres the four far cells are out of sight");
        assert_eq!(seen(0, 0, 0.0), 6, "a corner sees a quarter of the disc");
        assert_eq!(seen(-1, 5, 0.0), 0, "outside the map there is nothing to see");
        let far = SensorParameters { radius_max_m: 1e6, gain: 1e6, ..sensor() };
        let pose = Pose { cell: Cell::new(3, 4), height_m: 0.0 };
        assert_eq!(disc(Grid::new(1000, 1000, 1.0, 1).unwrap(), &far, pose).count(), 1_000_000);
    }

    /// P-GUARD-REACH.
    #[test]
    fn every_landing_of_every_hop_lies_in_the_smallest_disc_whatever_the_rounding() {
        for hop_cells in 1..=12 {
            for cell_size_m in (1..=40).map(|step| f64::from(step) / 20.0) {
                let side = 2 * hop_cells + 1;
                let grid = Grid::new(side, side, cell_size_m, hop_cells).unwrap();
                let cell = Cell::new(hop_cells as i32, hop_cells as i32);
                let hop_m = grid.hop_distance_m();
                let least =
                    SensorParameters { gain: 0.0, radius_min_m: hop_m, radius_max_m: hop_m, ..sensor() };
                let seen: Vec<Cell> = disc(grid, &least, Pose { cell, height_m: 0.0 }).collect();
                for landing in contract::Direction::ALL.map(|direction| grid.hop(cell, direction)) {
                    assert!(seen.contains(&landing), "{landing}: {hop_cells} cells of {cell_size_m} m");
                }
            }
        }
    }

    #[test]
    fn a_square_of_one_cell_has_nine_cells_and_is_clipped_at_the_border() {
        let grid = Grid::new(5, 4, 1.0, 1).unwrap();
        let cells =
            |range_cells, x, y| square(grid, Square { range_cells }, Cell::new(x, y)).collect::<Vec<_>>();
        assert_eq!(cells(1, 2, 2).len(), 9);
        assert_eq!(cells(1, 0, 0), [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| Cell::new(x, y)));
        assert_eq!(cells(2, 4, 3).len(), 9);
        assert_eq!(cells(64, 2, 2).len(), 20);
    }
}
