//! The parabola of any launch against closed form and against numerical integration.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use motion::Launch;
use proptest::prelude::*;

const MARS_MPS2: f64 = 3.72;

#[track_caller]
fn close(got: f64, need: f64, within: f64) {
    assert!((got - need).abs() <= within * need.abs().max(1.0), "need {need}, got {got}");
}

/// The paper's hop: 1.0 m far at 45° on the flat.
fn paper(angle_deg: f64) -> Launch {
    Launch::reaching(1.0, FRAC_PI_4, MARS_MPS2).at(angle_deg.to_radians())
}

/// Fourth-order Runge–Kutta of ẍ = 0, z̈ = −g, until the hopper is `distance_m` along.
fn integrated_m(launch: &Launch, distance_m: f64) -> f64 {
    let steps = 2_000;
    let step_s = launch.time_s(distance_m) / f64::from(steps);
    let mut state = [0.0, launch.speed_mps * launch.angle_rad.sin()];
    let slope = |[_, up_mps]: [f64; 2]| [up_mps, -launch.gravity_mps2];
    let moved = |[z, v]: [f64; 2], [dz, dv]: [f64; 2], by: f64| [z + dz * by, v + dv * by];
    for _ in 0..steps {
        let first = slope(state);
        let second = slope(moved(state, first, step_s / 2.0));
        let third = slope(moved(state, second, step_s / 2.0));
        let fourth = slope(moved(state, third, step_s));
        let sum = |n: usize| (first[n] + 2.0 * second[n] + 2.0 * third[n] + fourth[n]) / 6.0;
        state = moved(state, [sum(0), sum(1)], step_s);
    }
    state[0]
}

/// P-PARABOLA: A launch at any angle follows the parabola of the closed form and of numerical
/// integration; the paper's printed parabola is the one at 45°.
///
/// The numbers that P22 prints, and those that follow from them at 80°.
#[test]
fn the_papers_hops_have_their_published_reach_and_apex() {
    let flat = paper(45.0);
    close(flat.flat_range_m(), 1.0, 1e-12);
    close(flat.apex_height_m(), 0.25, 1e-12);
    close(flat.apex_distance_m(), 0.5, 1e-12);
    let steep = paper(80.0);
    close(steep.apex_height_m(), 0.5 * 80f64.to_radians().sin().powi(2), 1e-12);
    close(steep.apex_height_m(), 0.485, 1e-3);
    close(steep.flat_range_m(), 160f64.to_radians().sin(), 1e-12);
}

/// P-PARABOLA.
#[test]
fn the_printed_parabola_is_the_general_one_at_45_degrees_and_at_no_other() {
    let printed = |launch: &Launch, d: f64| {
        let alpha = launch.apex_height_m();
        -(d - 2.0 * alpha).powi(2) / (4.0 * alpha) + alpha
    };
    for n in 0..=20 {
        let d = f64::from(n) / 20.0;
        close(paper(45.0).height_m(d), printed(&paper(45.0), d), 1e-12);
    }
    let steep = paper(80.0);
    let apex_m = steep.apex_distance_m();
    assert!((steep.height_m(apex_m) - printed(&steep, apex_m)).abs() > 0.2, "1.9 m far, if taken literally");
}

#[test]
fn the_apex_is_the_highest_point_and_the_flat_range_is_level() {
    for angle_deg in [5.0, 30.0, 45.0, 60.0, 80.0, 89.0] {
        let launch = paper(angle_deg);
        let (apex_m, top_m) = (launch.apex_distance_m(), launch.apex_height_m());
        close(launch.height_m(apex_m), top_m, 1e-12);
        for n in 1..40 {
            let aside_m = apex_m * f64::from(n) / 40.0;
            assert!(launch.height_m(apex_m - aside_m) < top_m && launch.height_m(apex_m + aside_m) < top_m);
            close(launch.height_m(apex_m - aside_m), launch.height_m(apex_m + aside_m), 1e-9);
        }
        close(launch.height_m(launch.flat_range_m()), 0.0, 1e-9);
    }
}

#[test]
fn energy_is_kept_along_the_arc() {
    let launch = paper(63.0);
    let energy = |speed_squared: f64, height_m: f64| 0.5 * speed_squared + MARS_MPS2 * height_m;
    let level_mps = launch.speed_mps * launch.angle_rad.cos();
    for n in 0..=20 {
        let distance_m = launch.flat_range_m() * f64::from(n) / 20.0;
        let up_mps = launch.speed_mps * launch.angle_rad.sin() - MARS_MPS2 * launch.time_s(distance_m);
        let got = energy(level_mps.powi(2) + up_mps.powi(2), launch.height_m(distance_m));
        close(got, energy(launch.speed_mps.powi(2), 0.0), 1e-12);
    }
}

#[test]
fn a_landing_higher_than_the_apex_is_never_reached() {
    let launch = paper(80.0);
    assert_eq!(launch.landing_distance_m(launch.apex_height_m() + 1e-9), None);
    close(launch.landing_distance_m(0.0).unwrap(), launch.flat_range_m(), 1e-12);
    assert!(launch.landing_distance_m(0.25).unwrap() > launch.apex_distance_m(), "on the way down");
}

#[test]
#[should_panic(expected = "a launch needs speed and gravity above 0")]
fn a_launch_straight_up_is_refused() {
    let _ = Launch::reaching(1.0, FRAC_PI_2, MARS_MPS2);
}

proptest! {
    /// P-PARABOLA.
    #[test]
    fn every_arc_is_that_of_numerical_integration(
        angle_rad in 0.05..1.5f64, speed_mps in 0.2..6.0f64, gravity_mps2 in 0.1..12.0f64, share in 0.0..1.5f64,
    ) {
        let launch = Launch { speed_mps, angle_rad, gravity_mps2 };
        let distance_m = launch.flat_range_m() * share;
        let (got, need) = (launch.height_m(distance_m), integrated_m(&launch, distance_m));
        prop_assert!((got - need).abs() <= 1e-8 * launch.apex_height_m().max(1.0), "need {need}, got {got}");
    }

    #[test]
    fn a_landing_distance_is_where_the_arc_has_that_height(
        angle_rad in 0.05..1.5f64, speed_mps in 0.2..6.0f64, share in -3.0..1.0f64,
    ) {
        let launch = Launch { speed_mps, angle_rad, gravity_mps2: MARS_MPS2 };
        let rise_m = launch.apex_height_m() * share;
        let distance_m = launch.landing_distance_m(rise_m).unwrap();
        prop_assert!((launch.height_m(distance_m) - rise_m).abs() <= 1e-9 * launch.apex_height_m().max(1.0));
        prop_assert!(distance_m >= launch.apex_distance_m());
    }
}
