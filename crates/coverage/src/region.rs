//! How rovers share the ground (P19 section 2.3).

use contract::Cell;

/// Number of the start, of one or more, that is nearest to `cell` as the crow flies, since obstacles are not known
/// beforehand. The lowest number wins a tie.
#[must_use]
pub fn nearest_start(starts: impl IntoIterator<Item = Cell>, cell: Cell) -> usize {
    let mut nearest = (i32::MAX, 0);
    for (robot, start) in starts.into_iter().enumerate() {
        let (dx, dy) = (start.x - cell.x, start.y - cell.y);
        nearest = nearest.min((dx * dx + dy * dy, robot));
    }
    nearest.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_start_owns_a_cell_and_the_lowest_number_wins_a_tie() {
        let starts = [(0, 0), (4, 0), (4, 0)].map(|(x, y)| Cell::new(x, y));
        assert_eq!(nearest_start(starts, Cell::new(1, 3)), 0);
        assert_eq!(nearest_start(starts, Cell::new(2, 3)), 0);
        assert_eq!(nearest_start(starts, Cell::new(3, 3)), 1);
    }
}
