//! Flights stay on the map.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;

use routing::{Goal, ScoutValue, Trip, scout_value};
use rover::{Belief, Lattice, Point, Speed, SpeedDistribution, Surface};

/// A flight that leaves the map is let pass by nobody, so its robot would stand still.
#[test]
fn a_flight_over_uncertain_ground_at_the_border_stays_on_the_map() {
    let lattice = Lattice::new(14, 14).unwrap();
    let uncertain = SpeedDistribution::new([0.25, 0.0, 0.0, 0.75]).unwrap();
    // Uncertain ground across the middle, up to both borders.
    let cell = |cell: usize| {
        if (5..9).contains(&(cell % 14)) { uncertain } else { SpeedDistribution::certain(Speed::Fast) }
    };
    let belief = Belief::new(Arc::new(Surface::flat(lattice)), (0..14 * 14).map(cell).collect()).unwrap();
    for (seed, y_m) in (0..60).map(|seed| (seed, if seed % 2 == 0 { 0.6 } else { 13.4 })) {
        let goal = Goal { at: Point::new(13.0, y_m), radius_m: 1.0 };
        let trip = Trip { start: Point::new(1.0, y_m), goal };
        let settings = ScoutValue { budget_m: 40.0, view_m: 2.5, ..ScoutValue::default() };
        let flight = scout_value(&belief, &trip, &settings, seed);
        let outside = flight.iter().find(|point| !lattice.contains(**point));
        assert_eq!(outside, None, "seed {seed}: {flight:?}");
    }
}
