//! Ties between directions go to the first of north, east, south, west.

use contract::{Action, Direction, Vetoed};

/// The first direction in the order of [`Direction::ALL`] whose value lies within `tolerance` of the
/// best; `None` if none has a value.
pub(crate) fn first_best(values: [Option<f64>; 4], tolerance: f64) -> Option<Direction> {
    let best = values.iter().flatten().copied().reduce(f64::max)?;
    Direction::ALL
        .into_iter()
        .find(|&direction| values[direction as usize].is_some_and(|value| value >= best - tolerance))
}

/// [`first_best`] among the directions that are not vetoed: a vetoed choice is removed, and the choice made again. So the
/// veto of a direction that would not have been chosen changes nothing.
pub(crate) fn first_best_allowed(
    values: [Option<f64>; 4],
    tolerance: f64,
    vetoed: Vetoed,
) -> Option<Direction> {
    let action = first_best_action(&Direction::ALL.map(Action::Hop), values, tolerance, vetoed)?;
    action.hop()
}

/// As [`first_best_allowed`], where `actions` are those towards each direction.
pub(crate) fn first_best_action(
    actions: &[Action; 4],
    mut values: [Option<f64>; 4],
    tolerance: f64,
    vetoed: Vetoed,
) -> Option<Action> {
    loop {
        let direction = first_best(values, tolerance)?;
        let action = actions[direction as usize];
        if !vetoed.has(action) {
            return Some(action);
        }
        values[direction as usize] = None;
    }
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

    #[test]
    fn the_veto_of_what_would_not_be_chosen_changes_no_choice() {
        let west = Vetoed::NONE.with(Action::Hop(Direction::West));
        let values = [Some(-0.05), Some(0.5), None, Some(1.0)];
        assert_eq!(first_best_allowed(values, 1.0, Vetoed::NONE), Some(Direction::East));
        assert_eq!(
            first_best_allowed(values, 1.0, west),
            Some(Direction::East),
            "not north, as without west"
        );
        let east = Vetoed::NONE.with(Action::Hop(Direction::East));
        assert_eq!(first_best_allowed(values, 1.0, east), Some(Direction::West));
        assert_eq!(first_best_allowed(values, 1.0, east.union(west)), Some(Direction::North));
        let all = Direction::ALL.into_iter().fold(Vetoed::NONE, |set, hop| set.with(Action::Hop(hop)));
        assert_eq!(first_best_allowed(values, 1.0, all), None);
    }
}
