//! The true ground: a grid on which some cells are obstacles.

use contract::{Cell, Direction, Grid};
use coverage::Placement;

use crate::draw::{Draw, Purpose};
use crate::error::{SetupError, WorldError};
use crate::reachable::Connections;

/// Which cells of a grid are obstacles.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    grid: Grid,
    /// By cell index.
    obstacles: Vec<bool>,
}

impl World {
    /// A world with obstacles where `obstacles` says so, by cell index.
    ///
    /// # Errors
    /// If there are not as many entries as cells.
    pub fn new(grid: Grid, obstacles: Vec<bool>) -> Result<Self, WorldError> {
        if obstacles.len() != grid.cells() {
            return Err(WorldError::Length { need: grid.cells(), got: obstacles.len() });
        }
        Ok(Self { grid, obstacles })
    }

    /// A world on which `obstacle_percent` of the cells, rounded to a whole number of them, are obstacles at random
    /// places, and all free cells are connected.
    ///
    /// Cells become obstacles in random order; a cell is passed over if without it the free cells would fall apart.
    ///
    /// # Errors
    /// If the share is none, or so large that the obstacles do not fit.
    pub fn random(grid: Grid, obstacle_percent: f64, seed: u64) -> Result<Self, WorldError> {
        if !(0.0..100.0).contains(&obstacle_percent) {
            return Err(WorldError::ObstaclePercent { got_percent: obstacle_percent });
        }
        let need = (obstacle_percent / 100.0 * grid.cells() as f64).round() as usize;
        let mut world = Self { grid, obstacles: vec![false; grid.cells()] };
        let mut draw = Draw::new(seed, Purpose::Obstacles);
        let mut order: Vec<usize> = (0..grid.cells()).collect();
        let mut connections = Connections::default();
        let mut got = 0;
        for drawn in 0..order.len() {
            if got == need {
                break;
            }
            let other = drawn + draw.below(order.len() - drawn);
            order.swap(drawn, other);
            if connections.hold_without(&grid, grid.cell(order[drawn]), |cell| world.is_free(cell)) {
                world.obstacles[order[drawn]] = true;
                got += 1;
            }
        }
        if got < need { Err(WorldError::TooManyObstacles { need, got }) } else { Ok(world) }
    }

    /// Distinct starts on free cells for `rovers` rovers, with headings, all at random.
    ///
    /// # Errors
    /// If there are fewer free cells than rovers.
    pub fn random_starts(&self, rovers: usize, seed: u64) -> Result<Vec<Placement>, SetupError> {
        let mut free: Vec<Cell> = self.grid.iter().filter(|cell| self.is_free(*cell)).collect();
        if free.len() < rovers {
            return Err(SetupError::TooFewFreeCells { need: rovers, got: free.len() });
        }
        let mut draw = Draw::new(seed, Purpose::Starts);
        let mut start = || Placement {
            cell: free.swap_remove(draw.below(free.len())),
            heading: Direction::ALL[draw.below(Direction::ALL.len())],
        };
        Ok((0..rovers).map(|_| start()).collect())
    }

    /// Shape of the ground.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Whether a rover can stand on `cell`; false outside the grid.
    #[must_use]
    pub fn is_free(&self, cell: Cell) -> bool {
        self.grid.index(cell).is_some_and(|index| !self.obstacles[index])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reachable::reachable;

    fn grid(side: u32) -> Grid {
        Grid::new(side, side, 1.0, 1).unwrap()
    }

    #[test]
    fn a_random_world_has_its_share_of_obstacles_and_connected_free_cells() {
        for (side, percent, obstacles) in [(5, 10.0, 3), (20, 10.0, 40), (20, 0.0, 0), (40, 25.0, 400)] {
            for seed in 0..20 {
                let world = World::random(grid(side), percent, seed).unwrap();
                let free: Vec<Cell> = world.grid.iter().filter(|cell| world.is_free(*cell)).collect();
                assert_eq!(free.len(), world.grid.cells() - obstacles);
                let reached = reachable(&world.grid, [free[0]], |cell| world.is_free(cell));
                assert_eq!(reached.iter().filter(|reached| **reached).count(), free.len());
            }
        }
    }

    #[test]
    fn a_seed_is_a_world_and_another_seed_another_one() {
        let world = |seed| World::random(grid(20), 10.0, seed).unwrap();
        assert_eq!(world(7), world(7));
        assert_ne!(world(7), world(8));
    }

    #[test]
    fn shares_that_cannot_be_are_refused() {
        let refused = |percent| World::random(grid(20), percent, 1).unwrap_err();
        assert_eq!(refused(-1.0), WorldError::ObstaclePercent { got_percent: -1.0 });
        assert!(matches!(refused(f64::NAN), WorldError::ObstaclePercent { .. }));
        assert!(matches!(refused(90.0), WorldError::TooManyObstacles { need: 360, .. }));
    }

    #[test]
    fn starts_are_distinct_free_cells() {
        let world = World::random(grid(5), 20.0, 1).unwrap();
        let starts = world.random_starts(16, 3).unwrap();
        for (number, start) in starts.iter().enumerate() {
            assert!(world.is_free(start.cell));
            assert!(starts[..number].iter().all(|other| other.cell != start.cell));
        }
        assert_eq!(
            world.random_starts(21, 3).unwrap_err(),
            SetupError::TooFewFreeCells { need: 21, got: 20 }
        );
    }
}
