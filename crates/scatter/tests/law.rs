//! The slope law against the paper's table.

use scatter::{FlatScatter, slope_in_limits};

const FLAT: FlatScatter = FlatScatter { intended: 0.7, stuck: 0.1, sideways: 0.1 };

#[test]
fn landings_follow_the_papers_table_and_sum_to_one() {
    for ahead in [-2.0, -0.5, 0.0, 0.25, 1.0, 3.0] {
        for to_right in [-2.0, -0.5, 0.0, 0.25, 1.0] {
            let scatter = FLAT.on_slope(ahead, to_right);
            let (forwards, right) = (f64::clamp(ahead, 0.0, 1.0), f64::clamp(to_right, -1.0, 1.0));
            let expected =
                [0.7 * (1.0 - forwards), 0.7 * forwards + 0.1, 0.1 * (1.0 - right), 0.1 * (1.0 + right)];
            let got = [scatter.intended, scatter.stayed, scatter.left, scatter.right];
            for (got, expected) in got.into_iter().zip(expected) {
                assert!((got - expected).abs() < 1e-15, "{got}, not {expected}, at {ahead}, {to_right}");
            }
            assert!((got.iter().sum::<f64>() - 1.0).abs() <= f64::EPSILON);
        }
    }
}

#[test]
fn a_slope_at_the_limit_measures_one() {
    let limit_rad = std::f64::consts::FRAC_PI_6;
    assert!((slope_in_limits(libm::tan(limit_rad), limit_rad) - 1.0).abs() < 1e-15);
    assert_eq!(slope_in_limits(0.0, limit_rad), 0.0);
}
