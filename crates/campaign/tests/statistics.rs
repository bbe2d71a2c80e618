//! Statistics against published examples.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use campaign::paper;
use campaign::statistics::{Sample, share_difference, welch, wilson};
use contract::Weights;

/// P-STATISTICS.
/// Newcombe 1998, "Two-sided confidence intervals for the single proportion", Table I, method 3.
#[test]
fn wilson_intervals_are_those_newcombe_published() {
    for (successes, count, low, high) in
        [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)]
    {
        let interval = wilson(successes, count);
        assert!((interval.low - low).abs() < 5e-5, "{successes} of {count}: {interval:?}");
        assert!((interval.high - high).abs() < 5e-5, "{successes} of {count}: {interval:?}");
    }
    assert_eq!(wilson(20, 20).high, 1.0);
}

/// The three worked examples of unequal variances and sizes in the literature on Welch's test, as
/// (n, mean, variance) twice, then t, degrees of freedom and two-sided p.
#[test]
fn welchs_test_gives_the_published_examples() {
    for ((na, ma, va), (nb, mb, vb), t, degrees, p) in [
        ((15, 20.8, 7.9), (15, 23.0, 3.8), -2.49, 25.0, 0.021),
        ((10, 20.6, 9.0), (20, 22.1, 0.9), -1.54, 9.9, 0.149),
        ((10, 19.4, 1.4), (20, 21.6, 17.1), -2.22, 24.5, 0.036),
    ] {
        let sample = |n, mean, variance: f64| Sample::published(n, mean, variance.sqrt());
        let test = welch(&sample(na, ma, va), &sample(nb, mb, vb)).unwrap();
        // Means and variances are published with one decimal.
        assert!((test.t - t).abs() < 0.06, "{test:?}, {t}");
        assert!((test.degrees - degrees).abs() < 0.3, "{test:?}, {degrees}");
        assert!((test.p - p).abs() < 0.012, "{test:?}, {p}");
    }
}

/// Student's statistic with pooled variance, which the paper used.
fn student(a: &Sample, b: &Sample) -> f64 {
    let squares = |sample: &Sample| (sample.count - 1) as f64 * sample.sd.unwrap().powi(2);
    let (na, nb) = (a.count as f64, b.count as f64);
    let pooled = (squares(a) + squares(b)) / (na + nb - 2.0);
    (a.mean.unwrap() - b.mean.unwrap()) / (pooled * (1.0 / na + 1.0 / nb)).sqrt()
}

/// Tables 5, 8 and 11 follow from Tables 3 to 10 by Student's test, and by Welch's where as many
/// succeeded; but for one value, which nothing explains.
#[test]
fn the_papers_own_t_values_follow_from_its_tables() {
    for (scenario, values) in paper::T_VALUES {
        for ([safety, information], published) in paper::WEIGHTS.into_iter().zip(values) {
            let weights = Weights { safety, information, distance: 10.0 };
            let steps = |planner| paper::published(scenario, planner, &weights).unwrap().steps();
            let (mdp, greedy) = (steps("mdp"), steps("greedy"));
            let near = |t: f64| (t.abs() - published).abs() < 0.015 * published + 0.005;
            let alike = mdp.count.abs_diff(greedy.count) < 10;
            assert_eq!(near(student(&mdp, &greedy)), published != 0.762, "{scenario} {published}");
            assert_eq!(
                near(welch(&mdp, &greedy).unwrap().t),
                alike && published != 0.762,
                "{scenario} {published}"
            );
        }
    }
}

#[test]
fn a_sample_is_that_of_its_values() {
    let sample = Sample::of([(2, 1), (4, 3), (5, 2), (7, 1), (9, 1)].into_iter());
    assert_eq!((sample.count, sample.mean), (8, Some(5.0)));
    assert!((sample.sd.unwrap() - (32.0_f64 / 7.0).sqrt()).abs() < 1e-12);
    assert_eq!(Sample::of([(74, 1)].into_iter()).sd, None);
    assert_eq!(Sample::of(std::iter::empty()).mean, None);
}

#[test]
fn equal_shares_do_not_differ_and_nothing_is_compared_with_nothing() {
    assert_eq!(share_difference((100, 100), (1000, 1000)), Some(0.0));
    assert_eq!(share_difference((0, 0), (1, 2)), None);
    // (0.75 - 0.25) / sqrt(0.5 * 0.5 * (1/100 + 1/100)) = 5 sqrt 2
    let difference = share_difference((75, 100), (25, 100)).unwrap();
    assert!((difference - 50_f64.sqrt()).abs() < 1e-12, "{difference}");
}
