//! How rovers share the ground (P19 section 2.3).

use contract::Cell;
use serde::{Deserialize, Serialize};

use crate::Rover;

/// Which ground a rover covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// All rovers cover all ground together ("path overlapping").
    #[default]
    Overlap,
    /// Each rover keeps to the cells that are nearest to its start ("environment sharing").
    Voronoi,
}

/// Number of the rover whose start is nearest to `cell` as the crow flies, since obstacles are not known beforehand. The
/// lowest number wins a tie.
#[must_use]
pub fn nearest_start(rovers: &[Rover], cell: Cell) -> usize {
    let squared = |rover: &Rover| {
        let (dx, dy) = (rover.start.cell.x - cell.x, rover.start.cell.y - cell.y);
        dx * dx + dy * dy
    };
    let mut nearest = (i32::MAX, 0);
    for (robot, rover) in rovers.iter().enumerate() {
        nearest = nearest.min((squared(rover), robot));
    }
    nearest.1
}

#[cfg(test)]
mod tests {
    use contract::Direction;

    use super::*;
    use crate::Pose;

    #[test]
    fn the_nearest_start_owns_a_cell_and_the_lowest_number_wins_a_tie() {
        let rovers = [(0, 0), (4, 0), (4, 0)]
            .map(|(x, y)| Rover::at(Pose { cell: Cell::new(x, y), heading: Direction::North }));
        assert_eq!(nearest_start(&rovers, Cell::new(1, 3)), 0);
        assert_eq!(nearest_start(&rovers, Cell::new(2, 3)), 0);
        assert_eq!(nearest_start(&rovers, Cell::new(3, 3)), 1);
    }
}
