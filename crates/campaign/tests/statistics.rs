//! Statistics against published examples.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use campaign::statistics::{Sample, fisher_below, share_difference, student, welch, welch_above, wilson};

/// P-STATISTICS.
///
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

/// P-STATISTICS.
///
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

/// Fisher 1935, the lady tasting tea: of eight cups she names three or more of four right by chance with
/// 17 in 70; and the twins of convicts (Fisher 1935): 2 of 17 dizygotic against 10 of 13 monozygotic,
/// one-sided 0.0004652 in the manual of R.
#[test]
fn fishers_test_gives_fishers_examples() {
    let three_or_more = 1.0 - fisher_below((2, 4), (2, 4)).unwrap();
    assert!((three_or_more - 17.0 / 70.0).abs() < 1e-12, "{three_or_more}");
    let twins = fisher_below((2, 17), (10, 13)).unwrap();
    assert!((twins - 0.000_465_2).abs() < 5e-8, "{twins}");
    assert_eq!(fisher_below((10, 10), (5, 10)), Some(1.0));
    assert_eq!(fisher_below((0, 0), (5, 10)), None);
}

#[test]
fn the_one_sided_test_is_half_of_the_two_sided_on_the_side_of_the_difference() {
    let (slow, quick) = (Sample::published(100, 76.9, 6.3), Sample::published(98, 75.0, 6.8));
    let two_sided = welch(&slow, &quick).unwrap().p;
    let above = welch_above(&slow, &quick).unwrap();
    let below = welch_above(&quick, &slow).unwrap();
    assert!(
        (above - two_sided / 2.0).abs() < 1e-12 && (above + below - 1.0).abs() < 1e-12,
        "{above} {below}"
    );
}

/// "Student" 1908 on the sleep data, as every textbook has it: 0.75 ± 1.789 and 2.33 ± 2.002 hours of ten
/// each, t = −1.8608 with pooled variance.
#[test]
fn students_test_gives_students_example() {
    let t =
        student(&Sample::published(10, 0.75, 1.789_010), &Sample::published(10, 2.33, 2.002_249)).unwrap();
    assert!((t + 1.860_8).abs() < 5e-5, "{t}");
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
