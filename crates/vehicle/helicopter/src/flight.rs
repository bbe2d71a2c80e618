//! Flights along straight legs, and what the rover learns from them.

use rover::{Belief, Lattice, Point, Segment, Speed, SpeedDistribution, Truth};

use crate::sensor::Sensor;
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
    hovering.into_iter().chain(Segment::along(flight)).map(move |leg| Swath::new(lattice, leg, radius_m))
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

/// Updates what is known of the ground along a flight by a sensor that errs, which reads `readings` of the cells of the map,
/// the same whenever it looks. So a cell that is looked at again tells nothing new, and neither does one whose speed is known
/// for certain. A reading that `prior` excludes is left out.
///
/// # Panics
/// If prior or readings have fewer cells than the belief.
pub fn observe(
    belief: &mut Belief,
    prior: &Belief,
    flight: &[Point],
    radius_m: f64,
    sensor: &Sensor,
    readings: &[Speed],
) {
    let lattice = belief.surface().lattice();
    for swath in swaths(lattice, flight, radius_m) {
        for cell in swath.cells(lattice) {
            if !belief.cells()[cell].probabilities().contains(&1.0) {
                belief.set(cell, sensor.belief(prior.cells()[cell], readings[cell]));
            }
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

    /// P-SENSOR: A helicopter's camera that errs reads each cell once: a cell that it sees has the
    /// posterior of that reading, however often it looks.
    #[test]
    fn a_sensor_that_errs_gives_each_cell_seen_the_posterior_of_one_reading() {
        let lattice = Lattice::new(30, 3).unwrap();
        let even = SpeedDistribution::new([0.5, 0.0, 0.0, 0.5]).unwrap();
        let mut prior = Belief::new(Arc::new(Surface::flat(lattice)), vec![even; 90]).unwrap();
        prior.set(31, SpeedDistribution::certain(Speed::Slow));
        let mut belief = prior.clone();
        // Has been driven over.
        belief.set(35, SpeedDistribution::certain(Speed::Fast));
        let sensor = Sensor::with_accuracy(0.9).unwrap();
        let readings: Vec<Speed> =
            (0..90).map(|cell| if cell % 10 == 5 { Speed::Zero } else { Speed::Fast }).collect();
        // Back and forth, twice.
        let flight = [Point::new(5.5, 1.5), Point::new(15.5, 1.5), Point::new(5.5, 1.5)];
        for _ in 0..2 {
            observe(&mut belief, &prior, &flight, 4.0, &sensor, &readings);
        }
        let (right, wrong) = (0.9 / (0.9 + 0.1 / 3.0), (0.1 / 3.0) / (0.9 + 0.1 / 3.0));
        let mut seen = 0;
        for (cell, speeds) in belief.cells().iter().enumerate() {
            if cell == 31 || cell == 35 {
                let known = if cell == 31 { Speed::Slow } else { Speed::Fast };
                assert_eq!(*speeds, SpeedDistribution::certain(known), "no reading changes what is certain");
            } else if *speeds != even {
                seen += 1;
                let expected = if readings[cell] == Speed::Fast { right } else { wrong };
                assert!(
                    (speeds.probability(Speed::Fast) - expected).abs() < 1e-12,
                    "cell {cell}: {speeds:?}"
                );
            }
        }
        assert_eq!(
            seen,
            53 - 2,
            "19 cells of the middle row and 17 of each other, two of which were certain"
        );
    }

    /// A sensor that is always right is the one without error.
    #[test]
    fn a_sensor_of_full_accuracy_makes_what_is_seen_certain() {
        let lattice = Lattice::new(30, 3).unwrap();
        let prior = SpeedDistribution::new([0.2, 0.1, 0.3, 0.4]).unwrap();
        let belief = Belief::new(Arc::new(Surface::flat(lattice)), vec![prior; 90]).unwrap();
        let truth = Truth { speeds: (0..90).map(|cell| Speed::ALL[cell % 4]).collect() };
        let flight = [Point::new(5.5, 1.5), Point::new(15.5, 1.5)];
        let (mut exact, mut erring) = (belief.clone(), belief);
        scout(&mut exact, &truth, &flight, 4.0);
        let prior = erring.clone();
        let sensor = Sensor::with_accuracy(1.0).unwrap();
        observe(&mut erring, &prior, &flight, 4.0, &sensor, &truth.speeds);
        assert_eq!(exact, erring);
    }
}
