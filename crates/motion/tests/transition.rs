//! The law of scatter against hand-computed rows, and its invariants.

mod paper;

use contract::{Branch, Cell, Direction, Grid, Ground, Soil};
use motion::{Transition, landing, transition, transitions};
use paper::PARAMETERS;
use proptest::prelude::*;

fn sloped(gradient: [f64; 2], soil: Soil) -> Ground {
    Ground { height_m: 0.0, gradient, soil, passable: true, ..Ground::FLAT }
}

#[track_caller]
fn check(ground: &Ground, direction: Direction, expected: [f64; 4]) {
    let Transition { intended, stayed, left, right } = transition(&PARAMETERS, ground, direction);
    for (got, need) in [intended, stayed, left, right].into_iter().zip(expected) {
        assert!((got - need).abs() < 1e-15, "{direction} on {ground:?}: need {expected:?}, got {got}");
    }
}

/// The gradient of a slope of `limits` slope limits.
fn rise(limits: f64) -> f64 {
    libm::tan(limits * PARAMETERS.slope_limit_rad)
}

#[test]
fn the_flat_has_the_printed_probabilities() {
    for direction in Direction::ALL {
        check(&Ground::FLAT, direction, [0.9, 0.0, 0.05, 0.05]);
        check(&sloped([0.0, 0.0], Soil::Sand), direction, [0.7, 0.1, 0.1, 0.1]);
    }
}

#[test]
fn a_hop_uphill_loses_to_staying_and_downhill_gains_nothing() {
    let half_up_north = sloped([0.0, rise(0.5)], Soil::Hard);
    check(&half_up_north, Direction::North, [0.45, 0.45, 0.05, 0.05]);
    check(&half_up_north, Direction::South, [0.9, 0.0, 0.05, 0.05]);
    let half_up_north = sloped([0.0, rise(0.5)], Soil::Sand);
    check(&half_up_north, Direction::North, [0.35, 0.45, 0.1, 0.1]);
}

#[test]
fn a_slope_that_rises_to_the_left_makes_the_slip_to_the_left_likelier() {
    // East of here it rises: left of a hop south, right of a hop north.
    let up_east = sloped([rise(0.5), 0.0], Soil::Hard);
    check(&up_east, Direction::South, [0.9, 0.0, 0.075, 0.025]);
    check(&up_east, Direction::North, [0.9, 0.0, 0.025, 0.075]);
}

#[test]
fn slopes_beyond_the_limit_are_clamped_by_sign() {
    let cliff = sloped([rise(2.0), rise(1.5)], Soil::Sand);
    check(&cliff, Direction::North, [0.0, 0.8, 0.0, 0.2]);
    check(&cliff, Direction::South, [0.7, 0.1, 0.2, 0.0]);
    check(&cliff, Direction::East, [0.0, 0.8, 0.2, 0.0]);
    check(&cliff, Direction::West, [0.7, 0.1, 0.0, 0.2]);
}

#[test]
fn landings_are_a_hop_ahead_to_the_left_and_to_the_right() {
    let grid = Grid::new(9, 9, 0.5, 2).unwrap();
    let from = Cell::new(4, 4);
    let at = |branch| landing(&grid, from, Direction::East, branch);
    assert_eq!(at(Branch::Intended), Cell::new(6, 4));
    assert_eq!(at(Branch::Left), Cell::new(4, 6));
    assert_eq!(at(Branch::Right), Cell::new(4, 2));
    assert_eq!(at(Branch::Stayed), from);
    assert_eq!(at(Branch::Held), from);
    assert_eq!(landing(&grid, Cell::new(0, 1), Direction::West, Branch::Intended), Cell::new(-2, 1));
}

#[test]
fn a_uniform_draw_selects_branches_in_the_documented_order() {
    let row = transition(&PARAMETERS, &sloped([0.0, 0.0], Soil::Sand), Direction::North);
    for (uniform, branch) in [
        (0.0, Branch::Intended),
        (0.699, Branch::Intended),
        (0.7, Branch::Stayed),
        (0.799, Branch::Stayed),
        (0.801, Branch::Left),
        (0.899, Branch::Left),
        (0.901, Branch::Right),
        (1.0 - f64::EPSILON / 2.0, Branch::Right),
    ] {
        assert_eq!(row.branch(uniform), branch, "{uniform}");
    }
}

proptest! {
    /// P-PHYSICS.
    #[test]
    fn every_row_is_a_distribution(
        gx in -1.0e4..1.0e4_f64,
        gy in -3.0..3.0_f64,
        sand: bool,
        intended in 0.0..1.0_f64,
        share in 0.0..1.0_f64,
    ) {
        let mut parameters = PARAMETERS;
        let soil = if sand { Soil::Sand } else { Soil::Hard };
        let scatter = if sand { &mut parameters.sand } else { &mut parameters.hard };
        scatter.intended = intended;
        scatter.stuck = (1.0 - intended) * share;
        scatter.sideways = (1.0 - intended - scatter.stuck) / 2.0;
        for row in transitions(&parameters, &sloped([gx, gy], soil)) {
            let parts = [row.intended, row.stayed, row.left, row.right];
            prop_assert!(parts.iter().all(|p| (0.0..=1.0).contains(p)), "{:?}", row);
            prop_assert!((parts.iter().sum::<f64>() - 1.0).abs() <= f64::EPSILON, "{:?}", row);
            let named = Branch::ALL.map(|branch| row.probability(branch));
            prop_assert_eq!(named, [row.intended, row.stayed, row.left, row.right, 0.0, 0.0, 0.0, 0.0, 0.0]);
        }
    }

    #[test]
    fn a_mirrored_slope_swaps_left_and_right(gx in -2.0..2.0_f64, gy in -2.0..2.0_f64) {
        let [here, mirrored] = [gx, -gx].map(|gx| transition(&PARAMETERS, &sloped([gx, gy], Soil::Hard), Direction::North));
        prop_assert!((here.left - mirrored.right).abs() < 1e-15);
        prop_assert_eq!(here.intended, mirrored.intended);
    }
}
