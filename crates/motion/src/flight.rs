//! The ballistic flight of a hop: launch, arc, apex and time under the body's gravity.
//!
//! A flight of horizontal distance d that ends Δh above its launch follows
//! z(x) = x tan η − g x² / (2 v² cos² η), hence at launch angle η its speed is
//! v² = g d² / (2 cos² η (d tan η − Δh)) (general form of P22 section III; on the flat at 45°, d = 1 m:
//! v² = g d, apex d/4 = 0.25 m).
//!
//! A hopper can only land coming down. At the design angle the apex lies before the landing as long as
//! Δh ≤ d tan η / 2. A steeper rise is flown at tan η = 2 Δh / d, the flattest launch whose arc reaches the landing at
//! its apex. So the angle is continuous in Δh, the speed is finite, and d tan η > Δh always holds.
//!
//! Where a hop on a soil takes n flights (two half hops on sand), each covers d/n and rises Δh/n: the same arc at 1/n of
//! its size.

use contract::{Direction, Flight, Grid, MotionParameters, Soil};
use nalgebra::Vector3;

use crate::soil_motion;

/// The flight of a hop over `grid`'s hop distance from `soil` to a landing `rise_m` higher, metres
/// (negative for a lower one). The fields describe one of its `flights`.
///
/// # Panics
/// If the rise is not finite, or a parameter is out of range: gravity above 0, a launch angle between 0 and π/2, at
/// least one flight. Briefs are checked where they enter a process.
#[must_use]
pub fn flight(parameters: &MotionParameters, grid: &Grid, soil: Soil, rise_m: f64) -> Flight {
    let gravity_mps2 = parameters.gravity_mps2;
    let flights = soil_motion(parameters, soil).flights;
    let design_tangent = libm::tan(parameters.launch_angle_rad);
    assert!(rise_m.is_finite(), "a landing needs a finite height, got a rise of {rise_m} m");
    assert!(gravity_mps2 > 0.0, "gravity needs to be above 0, got {gravity_mps2} m/s²");
    assert!(
        design_tangent > 0.0 && parameters.launch_angle_rad < std::f64::consts::FRAC_PI_2,
        "a launch angle needs to lie between 0 and π/2, got {}",
        parameters.launch_angle_rad
    );
    assert!(flights >= 1, "a hop needs at least one flight, got {flights}");

    let range_m = grid.hop_distance_m() / f64::from(flights);
    let rise_m = rise_m / f64::from(flights);
    let steep = 2.0 * rise_m > range_m * design_tangent;
    let (launch_angle_rad, tangent) = if steep {
        let tangent = 2.0 * rise_m / range_m;
        (libm::atan(tangent), tangent)
    } else {
        (parameters.launch_angle_rad, design_tangent)
    };
    // With cos² η = 1 / (1 + tan² η) the vertical is no special case.
    let speed_squared =
        gravity_mps2 * range_m * range_m * (1.0 + tangent * tangent) / (2.0 * (range_m * tangent - rise_m));
    let launch_speed_mps = speed_squared.sqrt();
    let horizontal_speed_mps = launch_speed_mps / (1.0 + tangent * tangent).sqrt();
    let vertical_speed_mps = horizontal_speed_mps * tangent;
    Flight {
        launch_speed_mps,
        launch_angle_rad,
        range_m,
        rise_m,
        apex_height_m: vertical_speed_mps * vertical_speed_mps / (2.0 * gravity_mps2),
        flight_time_s: range_m / horizontal_speed_mps,
        flights,
    }
}

/// Height of the arc above the first launch at `distance_m` along the ground, metres, over all flights of the hop.
/// Distances beyond the hop's ends count as the ends.
#[must_use]
pub fn arc_height_m(flight: &Flight, distance_m: f64) -> f64 {
    if flight.flights == 0 {
        return 0.0;
    }
    let hop_m = flight.range_m * f64::from(flight.flights);
    let distance_m = distance_m.clamp(0.0, hop_m);
    let flown = (distance_m / flight.range_m).floor().min(f64::from(flight.flights - 1));
    let x = distance_m - flown * flight.range_m;
    // z(range) = rise determines the curvature, so gravity and speed are not needed.
    let drop = flight.range_m * libm::tan(flight.launch_angle_rad) - flight.rise_m;
    let share = x / flight.range_m;
    flown * flight.rise_m + x * libm::tan(flight.launch_angle_rad) - drop * share * share
}

/// Velocity at each launch of a hop towards `direction`: (east, north, up), m/s.
#[must_use]
pub fn launch_velocity_mps(flight: &Flight, direction: Direction) -> Vector3<f64> {
    let (east, north) = direction.step();
    let level = libm::cos(flight.launch_angle_rad);
    let towards =
        Vector3::new(f64::from(east) * level, f64::from(north) * level, libm::sin(flight.launch_angle_rad));
    towards * flight.launch_speed_mps
}

/// Position of the hopper `time_s` after the first launch, relative to the departure: (east, north, up), metres. Flights
/// follow each other without a pause; before the launch and after the landing the hopper stands still.
#[must_use]
pub fn position_m(flight: &Flight, direction: Direction, time_s: f64) -> Vector3<f64> {
    let share =
        if flight.flights == 0 || flight.flight_time_s <= 0.0 { 0.0 } else { time_s / flight.flight_time_s };
    let distance_m = flight.range_m * share.clamp(0.0, f64::from(flight.flights));
    let (east, north) = direction.step();
    Vector3::new(
        f64::from(east) * distance_m,
        f64::from(north) * distance_m,
        arc_height_m(flight, distance_m),
    )
}
