//! Which class of a motion table a hop is of.

use contract::{Cell, Direction, Grid, Ground, MotionTable};

/// The class of the hop towards each direction from a cell with that ground, in the order of [`Direction::ALL`].
///
/// The slope along is the secant to the target, the slope across the mean of the gradients at both ends, rising to the left. Where the
/// ground of one end is not `known`, as beyond the map, the gradient at departure counts instead.
#[must_use]
pub fn slope_classes<'a>(
    grid: &Grid,
    (from, ground): (Cell, &Ground),
    known: impl Fn(Cell) -> Option<&'a Ground>,
) -> [usize; 4] {
    let is_known = known(from).is_some();
    Direction::ALL.map(|direction| {
        let target = known(grid.hop(from, direction)).filter(|_| is_known);
        let (along, across) = match target {
            Some(target) => {
                let secant = (target.height_m - ground.height_m) / grid.hop_distance_m();
                (secant, 0.5 * (rise(ground, direction.left()) + rise(target, direction.left())))
            }
            None => (rise(ground, direction), rise(ground, direction.left())),
        };
        MotionTable::index(ground.soil, bin(along), bin(across))
    })
}

/// The bin of a slope, metres per metre.
fn bin(slope: f64) -> i32 {
    libm::round(libm::atan(slope).to_degrees() / MotionTable::BIN_DEG) as i32
}

/// The gradient of the ground towards a direction, metres per metre.
fn rise(ground: &Ground, towards: Direction) -> f64 {
    let [east, north] = ground.gradient;
    match towards {
        Direction::North => north,
        Direction::East => east,
        Direction::South => -north,
        Direction::West => -east,
    }
}

#[cfg(test)]
mod tests {
    use contract::Soil;

    use super::*;

    #[test]
    fn a_slope_is_of_the_nearest_bin() {
        assert_eq!([0.0, 0.03, -0.03, 0.577, 1e9, f64::NAN].map(bin), [0, 1, -1, 12, 36, 0]);
    }

    #[test]
    fn slopes_are_those_ahead_and_to_the_left_of_the_hop() {
        let grid = Grid::new(9, 9, 1.0, 1).unwrap();
        // Rises 10° to the east.
        let slope = libm::tan(10_f64.to_radians());
        let plane: Vec<Ground> = grid
            .iter()
            .map(|cell| Ground {
                height_m: slope * f64::from(cell.x),
                gradient: [slope, 0.0],
                ..Ground::FLAT
            })
            .collect();
        let class = |along, across| MotionTable::index(Soil::Hard, along, across);
        let need = [class(0, -4), class(4, 0), class(0, 4), class(-4, 0)];
        let at = |cell| grid.index(cell).map(|index| &plane[index]);
        let from = |cell: Cell| slope_classes(&grid, (cell, at(cell).unwrap()), at);
        assert_eq!(from(Cell::new(4, 4)), need);
        assert_eq!(from(Cell::new(8, 8)), need, "at the corner the gradient counts");
        let unseen = Ground { soil: Soil::Sand, ..Ground::FLAT };
        let level = MotionTable::index(Soil::Sand, 0, 0);
        assert_eq!(slope_classes(&grid, (Cell::new(4, 4), &unseen), |_| None), [level; 4]);
    }
}
