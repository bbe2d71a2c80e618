//! The total order among equals: north, east, south, west.

use contract::Direction;

/// The first direction in the order of [`Direction::ALL`] whose value lies within `tolerance` of the
/// best; `None` if none has a value.
pub(crate) fn first_best(values: [Option<f64>; 4], tolerance: f64) -> Option<Direction> {
    let best = values.iter().flatten().copied().reduce(f64::max)?;
    Direction::ALL
        .into_iter()
        .find(|&direction| values[direction as usize].is_some_and(|value| value >= best - tolerance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equals_are_taken_in_the_order_north_east_south_west() {
        assert_eq!(first_best([Some(1.0); 4], 0.0), Some(Direction::North));
        assert_eq!(first_best([None, Some(1.0), Some(1.0), None], 0.0), Some(Direction::East));
        assert_eq!(first_best([Some(1.0), Some(1.5), Some(2.0), Some(2.0)], 0.5), Some(Direction::East));
        assert_eq!(first_best([None; 4], 0.0), None);
    }
}
