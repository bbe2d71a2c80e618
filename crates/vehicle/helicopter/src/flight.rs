//! Flights along straight legs, and what the rover learns from them.

use rover::{Belief, Lattice, Point, Segment, SpeedDistribution, Truth};

use crate::swath::Swath;

/// How far the helicopter flies on one charge.
pub const BUDGET_M: f64 = 300.0;

/// Length of a flight, in the plane: it keeps its height above the ground, whose slopes are gentle beside that.
#[must_use]
pub fn length_m(flight: &[Point]) -> f64 {
    flight.windows(2).map(|pair| pair[0].distance_m(pair[1])).sum()
}

/// The first part of `flight`, as far as the budget reaches.
#[must_use]
pub fn within_budget(flight: &[Point], budget_m: f64) -> Vec<Point> {
    let mut cut: Vec<Point> = flight.iter().take(1).copied().collect();
    let mut left_m = budget_m;
    for pair in flight.windows(2) {
        let leg_m = pair[0].distance_m(pair[1]);
        if leg_m > left_m {
            cut.push(pair[0].towards(pair[1], left_m / leg_m));
            break;
        }
        left_m -= leg_m;
        cut.push(pair[1]);
    }
    cut
}

/// What is seen along a flight, leg by leg; above the first point alone if there is no other.
pub fn swaths(lattice: Lattice, flight: &[Point], radius_m: f64) -> impl Iterator<Item = Swath> {
    let hovering = if flight.len() == 1 { Some(Segment { from: flight[0], to: flight[0] }) } else { None };
    let legs = flight.windows(2).map(|pair| Segment { from: pair[0], to: pair[1] });
    hovering.into_iter().chain(legs).map(move |leg| Swath::new(lattice, leg, radius_m))
}

/// Makes certain what is seen along a flight, by a sensor without error.
pub fn scout(belief: &mut Belief, truth: &Truth, flight: &[Point], radius_m: f64) {
    let lattice = belief.surface().lattice();
    for swath in swaths(lattice, flight, radius_m) {
        for cell in swath.cells(lattice) {
            belief.set(cell, SpeedDistribution::certain(truth.speeds[cell]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rover::{Speed, Surface};
    use std::sync::Arc;

    #[test]
    fn a_flight_ends_where_its_budget_does() {
        let flight = [Point::new(0.0, 0.0), Point::new(200.0, 0.0), Point::new(200.0, 200.0)];
        let cut = within_budget(&flight, BUDGET_M);
        assert_eq!(cut, [flight[0], flight[1], Point::new(200.0, 100.0)]);
        assert_eq!(length_m(&cut), BUDGET_M);
        assert_eq!(within_budget(&flight, 1000.0), flight);
    }

    #[test]
    fn scouting_reveals_what_is_in_view_and_nothing_else() {
        let lattice = Lattice::new(30, 3).unwrap();
        let surface = Arc::new(Surface::flat(lattice));
        let prior = SpeedDistribution::new([0.5, 0.0, 0.0, 0.5]).unwrap();
        let mut belief = Belief::new(surface, vec![prior; 90]).unwrap();
        let truth = Truth { speeds: vec![Speed::Fast; 90] };
        scout(&mut belief, &truth, &[Point::new(5.5, 1.5), Point::new(15.5, 1.5)], 4.0);
        let known = SpeedDistribution::certain(Speed::Fast);
        for (cell, speeds) in belief.cells().iter().enumerate() {
            let (column, row) = (cell % 30, cell / 30);
            let seen = if row == 1 { (1..20).contains(&column) } else { (2..19).contains(&column) };
            assert_eq!(*speeds, if seen { known } else { prior }, "cell {column}, {row}");
        }
    }
}
