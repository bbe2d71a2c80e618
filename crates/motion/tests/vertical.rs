//! The vertical hop's law, case by case.

use contract::SoilMotion;
use motion::vertical_transition;
use proptest::prelude::*;

const PLAIN: SoilMotion = SoilMotion { intended: 0.7, stuck: 0.0, sideways: 0.15, flights: 1 };
const SAND: SoilMotion = SoilMotion { intended: 0.5, stuck: 0.2, sideways: 0.15, flights: 1 };

#[track_caller]
fn check(motion: &SoilMotion, rise_m: f64, apex_m: f64, need: [f64; 4]) {
    let got = vertical_transition(motion, rise_m, apex_m).expect("a rise below the apex");
    for (got, need) in [got.intended, got.stayed, got.left, got.right].into_iter().zip(need) {
        assert!((got - need).abs() < 1e-12, "need {need}, got {got}");
    }
}

/// P-VERTICAL: The vertical hop succeeds and fails according to its rise, and is not offered for a
/// rise of its apex or more.
///
/// Success and slips of 70, 15 and 15 % each lose their share Δh / h_max, which fails.
#[test]
fn success_falls_and_failure_grows_with_the_rise() {
    check(&PLAIN, 0.0, 0.5, [0.7, 0.0, 0.15, 0.15]);
    check(&PLAIN, 0.25, 0.5, [0.35, 0.5, 0.075, 0.075]);
    check(&PLAIN, 0.49, 0.5, [0.014, 0.98, 0.003, 0.003]);
}

#[test]
fn the_low_rock_is_climbed_one_time_in_three() {
    let apex_m = 0.5 * 80f64.to_radians().sin().powi(2);
    let got = vertical_transition(&PLAIN, 0.25, apex_m).expect("the low rock");
    assert!((got.intended - 0.7 * (1.0 - 0.25 / apex_m)).abs() < 1e-15);
    assert!((got.intended - 0.339).abs() < 1e-3);
}

/// P-VERTICAL.
#[test]
fn a_rise_of_the_apex_or_more_is_no_hop() {
    for rise_m in [0.5, 0.5 + 1e-12, 1.0] {
        assert_eq!(vertical_transition(&PLAIN, rise_m, 0.5), None);
    }
    assert!(vertical_transition(&PLAIN, 0.5 - 1e-12, 0.5).is_some());
}

#[test]
fn what_sand_holds_it_holds_before_the_rise_counts() {
    check(&SAND, 0.25, 0.5, [0.25, 0.6, 0.075, 0.075]);
}

proptest! {
    #[test]
    fn every_row_is_a_distribution(rise_m in -0.4999..0.4999f64, intended in 0.0..1.0f64, share in 0.0..1.0f64) {
        let sideways = (1.0 - intended) * share / 2.0;
        let stuck = 1.0 - intended - 2.0 * sideways;
        let motion = SoilMotion { intended, stuck, sideways, flights: 1 };
        let got = vertical_transition(&motion, rise_m, 0.5).expect("a rise below the apex");
        let all = [got.intended, got.stayed, got.left, got.right];
        prop_assert!(all.iter().all(|p| (0.0..=1.0).contains(p)), "{all:?}");
        prop_assert!((all.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{all:?}");
    }
}
