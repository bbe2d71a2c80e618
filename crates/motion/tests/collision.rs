//! The collision check of a flight, case by case.

use std::f64::consts::FRAC_PI_4;

use motion::{GroundProfile, Launch, collision_m};
use proptest::prelude::*;

fn at(angle_deg: f64) -> Launch {
    Launch::reaching(1.0, FRAC_PI_4, 3.72).at(angle_deg.to_radians())
}

#[test]
fn nothing_is_in_the_way_on_the_flat() {
    for angle_deg in [10.0, 45.0, 80.0] {
        assert_eq!(collision_m(&at(angle_deg), &GroundProfile::stepped(&[0.0, 0.0], 1.0)), None);
        assert_eq!(collision_m(&at(angle_deg), &GroundProfile::sloping(&[0.0, 0.0], 1.0)), None);
    }
}

/// P-COLLISION: A flight that touches the ground before or at its apex collides, and no other
/// flight does.
///
/// The paper's two rocks.
#[test]
fn the_low_rock_is_met_at_the_apex_and_the_tall_one_too() {
    // The arc of 45° is 0.25 m high above the border, 0.5 m away: it touches the low rock there.
    let met = collision_m(&at(45.0), &GroundProfile::stepped(&[0.0, 0.25], 1.0)).expect("it touches");
    assert!((met - 0.5).abs() < 1e-12, "{met}");
    assert!(collision_m(&at(45.0), &GroundProfile::stepped(&[0.0, 1.0], 1.0)).is_some());
    assert_eq!(
        collision_m(&at(45.0), &GroundProfile::stepped(&[0.0, 0.2499], 1.0)),
        None,
        "a hair lower is free"
    );
}

#[test]
fn what_stands_behind_the_apex_is_landed_on() {
    // With cells of 1.2 m the border lies at 0.6 m, behind the apex at 0.5 m.
    assert_eq!(collision_m(&at(45.0), &GroundProfile::stepped(&[0.0, 0.2], 1.2)), None);
    assert_eq!(
        collision_m(&at(45.0), &GroundProfile::stepped(&[0.0, 9.0], 1.2)),
        None,
        "bounced off, but falling"
    );
}

#[test]
fn the_steep_hop_has_its_apex_before_the_border() {
    let steep = at(80.0);
    assert!(steep.apex_distance_m() < 0.5);
    assert_eq!(collision_m(&steep, &GroundProfile::stepped(&[0.0, 0.25], 1.0)), None);
    assert!(
        collision_m(&steep, &GroundProfile::stepped(&[0.0, 0.25], 0.3)).is_none(),
        "0.15 m away it is 0.48 m high"
    );
    assert!(collision_m(&steep, &GroundProfile::stepped(&[0.0, 1.0], 0.3)).is_some());
}

#[test]
fn a_drop_is_never_in_the_way() {
    assert_eq!(collision_m(&at(45.0), &GroundProfile::stepped(&[1.0, 0.0], 1.0)), None);
    assert_eq!(collision_m(&at(5.0), &GroundProfile::sloping(&[0.0, -3.0], 1.0)), None);
}

#[test]
fn a_slope_is_met_once_it_is_half_as_steep_as_the_launch() {
    // On ground z = m x the arc x tan η − x²/r meets it at x = r (tan η − m): before its apex if m > tan η / 2.
    for (slope, free) in [(0.49, true), (0.51, false), (2.0, false)] {
        let ground = GroundProfile::sloping(&[0.0, slope], 1.0);
        assert_eq!(collision_m(&at(45.0), &ground).is_none(), free, "slope {slope}");
    }
}

#[test]
fn an_obstacle_between_two_cells_of_a_long_hop_is_met() {
    let long = Launch::reaching(2.0, FRAC_PI_4, 3.72);
    assert_eq!(collision_m(&long, &GroundProfile::stepped(&[0.0, 0.3, 0.0], 1.0)), None);
    let met = collision_m(&long, &GroundProfile::stepped(&[0.0, 0.4, 0.0], 1.0)).expect("z(0.5) = 0.375 m");
    assert!((met - 0.5).abs() < 1e-12, "{met}");
}

#[test]
fn heights_count_from_the_launch() {
    for shift_m in [-50.0, 0.0, 1_000.0] {
        let met =
            |rise_m: f64| collision_m(&at(45.0), &GroundProfile::stepped(&[shift_m, shift_m + rise_m], 1.0));
        assert_eq!((met(0.2).is_none(), met(0.3).is_some()), (true, true), "at {shift_m} m");
    }
}

proptest! {
    /// P-COLLISION.
    ///
    /// The claim that looking at corners is exact, against looking everywhere.
    #[test]
    fn the_corners_say_what_a_fine_sampling_says(
        heights_m in prop::collection::vec(-0.3..0.6f64, 1..4), angle_rad in 0.2..1.45f64, stepped: bool,
    ) {
        let heights_m: Vec<f64> = std::iter::once(0.0).chain(heights_m).collect();
        let launch = Launch::reaching(1.5, angle_rad, 3.72);
        let build = if stepped { GroundProfile::stepped } else { GroundProfile::sloping };
        let ground = build(&heights_m, 0.4);
        let clearance = |d: f64| launch.height_m(d) - ground.height_m(d);
        let fine = (1..=4_000).map(|n| launch.apex_distance_m() * f64::from(n) / 4_000.0);
        let least = fine.map(clearance).fold(f64::INFINITY, f64::min);
        match collision_m(&launch, &ground) {
            Some(met_m) => prop_assert!(clearance(met_m) <= 1e-9, "{met_m}"),
            None => prop_assert!(least > 0.0, "{least}"),
        }
    }
}
