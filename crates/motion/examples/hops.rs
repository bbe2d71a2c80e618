//! Prints the flights of one hop on other bodies, and where hops from a slope land: `cargo run --example hops`.

#![allow(clippy::print_stdout, reason = "an example shows its result")]

use contract::grid::GridError;
use contract::{Branch, Direction, Grid, Ground, MotionParameters, Soil, SoilMotion};

fn main() -> Result<(), GridError> {
    let soil = |intended, stuck, sideways, flights| SoilMotion { intended, stuck, sideways, flights };
    let on = |gravity_mps2| MotionParameters {
        hard: soil(0.9, 0.0, 0.05, 1),
        sand: soil(0.7, 0.1, 0.1, 2),
        slope_limit_rad: 30_f64.to_radians(),
        launch_angle_rad: 45_f64.to_radians(),
        gravity_mps2,
        vertical: false,
        table: 0,
    };
    let grid = Grid::new(20, 20, 1.0, 1)?;
    for (body, gravity_mps2) in [("Moon", 1.62), ("Mars", 3.72), ("Phobos", 0.0057)] {
        let flight = motion::flight(&on(gravity_mps2), &grid, Soil::Hard, 0.1);
        println!(
            "{body:6} launch {:5.2} m/s, apex {:.2} m, {:6.2} s",
            flight.launch_speed_mps, flight.apex_height_m, flight.flight_time_s
        );
    }
    // Rising 10 degrees towards the north.
    let ground = Ground { gradient: [0.0, 10_f64.to_radians().tan()], ..Ground::FLAT };
    for direction in Direction::ALL {
        let landing = motion::transition(&on(3.72), &ground, direction);
        let share = |branch| landing.probability(branch);
        println!(
            "{direction:?}: as intended {:.3}, stays {:.3}",
            share(Branch::Intended),
            share(Branch::Stayed)
        );
    }
    Ok(())
}
