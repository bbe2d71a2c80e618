//! The Monte Carlo world in other sizes, for the table of scalability.

use std::sync::Arc;

use routing::{Goal, Trip};
use rover::{Belief, Lattice, Point, Surface, Truth};

use crate::{World, monte_carlo};

/// The Monte Carlo world of a seed on `side` x `side` cells: each cell is that of the original at its place.
///
/// # Panics
/// If the side is 0 or beyond the limits of a lattice.
#[must_use]
pub fn monte_carlo_of(side: usize, seed: u64) -> World {
    let original = monte_carlo(seed);
    let fine = original.prior.surface().lattice();
    let lattice = Lattice::new(side, side).expect("a side within the limits");
    let scale = fine.width() as f64 / side as f64;
    let source = |cell: usize| {
        let at = lattice.centre(cell);
        fine.cell(Point::new(at.x_m * scale, at.y_m * scale))
    };
    let sources: Vec<usize> = (0..lattice.cells()).map(source).collect();
    let scaled = |point: Point| Point::new(point.x_m / scale, point.y_m / scale);
    let goal = original.trip.goal;
    World {
        prior: Belief::new(
            Arc::new(Surface::flat(lattice)),
            sources.iter().map(|cell| original.prior.cells()[*cell]).collect(),
        )
        .expect("a distribution for each cell"),
        truth: Truth { speeds: sources.iter().map(|cell| original.truth.speeds[*cell]).collect() },
        trip: Trip {
            start: scaled(original.trip.start),
            goal: Goal { at: scaled(goal.at), radius_m: (goal.radius_m / scale).min(goal.radius_m) },
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_original_size_is_the_original() {
        let (scaled, original) = (monte_carlo_of(200, 3), monte_carlo(3));
        assert_eq!(
            (scaled.prior, scaled.truth, scaled.trip),
            (original.prior, original.truth, original.trip)
        );
    }

    #[test]
    fn other_sizes_have_the_same_shares_of_impassable_ground() {
        let share = |side: usize| {
            let world = monte_carlo_of(side, 3);
            let closed = world.prior.cells().iter().filter(|cell| cell.mean_m_per_sol() == 0.0).count();
            closed as f64 / world.prior.cells().len() as f64
        };
        for side in [20, 821] {
            assert!((share(side) - share(200)).abs() < 0.02, "{side}: {}", share(side));
        }
    }
}
