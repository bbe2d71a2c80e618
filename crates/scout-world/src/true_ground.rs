//! What a drive takes on the true ground, and what sensors see along a way.

use contract::{DriveSpeed, Grid, Ground, Sensor, Waypoint};
use helicopter::Swath;
use rover::{
    Allowance, Drive, Lattice, LatticeError, Point, Segment, Speed, Surface, SurfaceError, Truth, drive,
};

/// Ground with a true height and speed for each cell: of a square metre where robots drive, of any size where they only fly.
#[derive(Clone, Debug)]
pub struct TrueGround {
    surface: Surface,
    truth: Truth,
    cell_size_m: f64,
}

/// Why cells make no [`TrueGround`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TrueGroundError {
    /// Too many cells.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// A height that is no number.
    #[error(transparent)]
    Heights(#[from] SurfaceError),
}

impl TrueGround {
    /// The ground with these cells, in index order. A cell without a speed counts as speed 0.
    ///
    /// # Errors
    /// If the grid is too large, or a height is no number.
    ///
    /// # Panics
    /// If there are not as many cells as the grid has.
    pub fn new(grid: Grid, cells: &[Ground]) -> Result<Self, TrueGroundError> {
        assert_eq!(cells.len(), grid.cells(), "the ground needs a cell for each of its grid");
        let lattice = Lattice::new(grid.width as usize, grid.height as usize)?;
        let speeds = cells.iter().map(|ground| ground.speed.map_or(Speed::Zero, speed)).collect();
        let heights_m: Vec<f64> = cells.iter().map(|ground| ground.height_m).collect();
        Ok(Self {
            surface: Surface::from_heights(lattice, &heights_m)?,
            truth: Truth { speeds },
            cell_size_m: grid.cell_size_m,
        })
    }

    /// The cells of the ground.
    #[must_use]
    pub fn lattice(&self) -> Lattice {
        self.surface.lattice()
    }

    /// The true speed of a cell.
    ///
    /// # Panics
    /// If `cell` is not below the number of cells.
    #[must_use]
    pub fn speed(&self, cell: usize) -> Speed {
        self.truth.speeds[cell]
    }

    /// The straight drive between two points, or its first part if no more is allowed.
    #[must_use]
    pub fn drive(&self, from: Waypoint, to: Waypoint, allowance: Allowance) -> Drive {
        drive(&self.surface, &self.truth, &[point(from), point(to)], allowance)
    }

    /// The cells that a robot with `sensor` sees on the straight way between two points, rising and each once: what its camera
    /// shows, or else what it drives over. A drive ends at the border of a cell of speed 0, which is seen too. What is seen on a
    /// drive that may take only so long is [`Drive::sensed`].
    #[must_use]
    pub fn seen(&self, sensor: Sensor, from: Waypoint, to: Waypoint) -> Vec<usize> {
        let mut cells: Vec<usize> = match sensor.view_m() {
            Some(radius_m) => {
                // The lattice is in cells.
                let scaled = |at: Waypoint| Point::new(at.x_m / self.cell_size_m, at.y_m / self.cell_size_m);
                let leg = Segment { from: scaled(from), to: scaled(to) };
                Swath::new(self.lattice(), leg, radius_m / self.cell_size_m).cells(self.lattice()).collect()
            }
            None => self.drive(from, to, Allowance::UNLIMITED).sensed,
        };
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}

fn point(at: Waypoint) -> Point {
    Point::new(at.x_m, at.y_m)
}

/// A speed of the rover's model by its name in messages.
#[must_use]
pub fn speed(speed: DriveSpeed) -> Speed {
    Speed::ALL[speed as usize]
}

/// A speed by its name in messages.
#[must_use]
pub fn drive_speed(speed: Speed) -> DriveSpeed {
    DriveSpeed::ALL[speed as usize]
}

#[cfg(test)]
mod tests {
    use contract::{Camera, Track};

    use super::*;

    fn ground() -> TrueGround {
        let grid = Grid::new(6, 2, 1.0, 1).unwrap();
        let cell = |index: usize| {
            let speed = if index == 3 { DriveSpeed::Zero } else { DriveSpeed::Slow };
            Ground { speed: Some(speed), ..Ground::FLAT }
        };
        TrueGround::new(grid, &(0..12).map(cell).collect::<Vec<_>>()).unwrap()
    }

    fn at(x_m: f64) -> Waypoint {
        Waypoint { x_m, y_m: 0.5 }
    }

    #[test]
    fn a_rover_sees_its_track_with_the_cell_that_stops_it_and_a_camera_sees_beyond() {
        let ground = ground();
        assert_eq!(ground.seen(Sensor::Track(Track {}), at(0.5), at(5.5)), [0, 1, 2, 3]);
        assert_eq!(ground.seen(Sensor::Track(Track {}), at(2.5), at(0.5)), [0, 1, 2]);
        assert_eq!(
            ground.seen(Sensor::Camera(Camera { radius_m: 1.0 }), at(2.5), at(3.5)),
            [1, 2, 3, 4, 8, 9]
        );
        // A metre at 50 m/Sol.
        let allowance = Allowance { used_sol: 0.5, limit_sol: 0.52 };
        assert_eq!(ground.drive(at(0.5), at(5.5), allowance).sensed, [0, 1]);
    }

    #[test]
    fn a_camera_sees_as_far_in_metres_on_small_cells() {
        let grid = Grid::new(6, 2, 0.5, 2).unwrap();
        let ground = TrueGround::new(grid, &[Ground::FLAT; 12]).unwrap();
        let middle = |x| Waypoint::middle_of(&grid, contract::Cell::new(x, 0));
        assert_eq!(
            ground.seen(Sensor::Camera(Camera { radius_m: 0.5 }), middle(2), middle(3)),
            [1, 2, 3, 4, 8, 9]
        );
    }

    #[test]
    fn speeds_keep_their_names() {
        for (model, message) in Speed::ALL.into_iter().zip(DriveSpeed::ALL) {
            assert_eq!((speed(message), drive_speed(model)), (model, message));
        }
    }
}
