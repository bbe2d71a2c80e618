//! The claims of P19 about its figures, each judged by the whole interval of ours.

use ::campaign::statistics::{Interval, wilson};
use ::coverage::Algorithm;
use p19::{Account, Estimate, Moments, PERCENTS, PLANNERS, Row, Sharing, row};

use crate::claims::{Claim, Verdict};

/// Every claim, in the order of the paper's figures.
pub fn all(account: &Account) -> Vec<Claim> {
    let single = &account.single;
    let mut claims = vec![typical(single)];
    claims.push(shorter(
        "spiral is shorter than boustrophedon at every percentage",
        single,
        Algorithm::Spiral,
        Algorithm::Boustrophedon,
    ));
    claims.push(shorter(
        "so it is with circumnavigation",
        single,
        Algorithm::SpiralCircumnavigation,
        Algorithm::BoustrophedonCircumnavigation,
    ));
    claims.push(shorter(
        "circumnavigation makes spiral longer at every percentage",
        single,
        Algorithm::Spiral,
        Algorithm::SpiralCircumnavigation,
    ));
    claims.extend(PLANNERS.map(|algorithm| last_cells("20 × 20", single, algorithm)));
    claims.push(last_cells("15 × 15", &account.small, Algorithm::Spiral));
    let spirals = [Algorithm::Spiral, Algorithm::SpiralCircumnavigation];
    claims.extend(spirals.map(|algorithm| spread(single, algorithm)));
    claims.extend(account.pairs.iter().flat_map(one_pair));
    claims.push(overlap_is_shorter(&account.sharing));
    claims.push(overlap_varies_less(&account.sharing));
    claims
}

/// The mission of Fig. 5, which ends at 1.75.
fn typical(rows: &[Row]) -> Claim {
    let all = row(rows, Algorithm::Spiral, 100);
    let (low, high) = (all.quantile(0.05), all.quantile(0.95));
    Claim::new(
        "a typical run covers everything at a path ratio of 1.75 (Fig. 5)",
        "1.75",
        "within the middle 90 % of the runs of spiral",
        format!("middle 90 %: {low:.2} to {high:.2}, mean {}", all.mean.written(3)),
        Verdict::of((low..=high).contains(&1.75)),
    )
}

/// `short` needs shorter paths than `long` at every share.
fn shorter(statement: &str, rows: &[Row], short: Algorithm, long: Algorithm) -> Claim {
    let longer = PERCENTS.map(|percent| row(rows, short, percent).longer(row(rows, long, percent)));
    let at = |n: usize| format!("+{} at {} %", longer[n].written(3), PERCENTS[n]);
    Claim::new(
        &format!("{statement} (Fig. 6)"),
        "yes",
        "the mean difference in path ratio is above 0 at each percentage",
        format!("{}, {}", at(0), at(PERCENTS.len() - 1)),
        Verdict::all(longer.iter().map(|longer| Verdict::above(longer, 0.0))),
    )
}

/// What the last 2 % cost.
fn last_cells(ground: &str, rows: &[Row], algorithm: Algorithm) -> Claim {
    let pairs = row(rows, algorithm, 98).beside(row(rows, algorithm, 100));
    let more = Estimate::jackknife(&pairs, |moments| 100.0 * (moments.ratio_of_means() - 1.0));
    Claim::new(
        &format!("the last 2 % cost 10 to 20 % more path: {algorithm}, {ground} (Fig. 6)"),
        "10 to 20 %",
        "the mean increases by 10 to 20 %",
        format!("{} %", more.written(1)),
        Verdict::within(&more, 10.0, 20.0),
    )
}

/// The standard deviation at 100 % and at 97 %.
fn spread(rows: &[Row], algorithm: Algorithm) -> Claim {
    let pairs = row(rows, algorithm, 97).beside(row(rows, algorithm, 100));
    let times = Estimate::jackknife(&pairs, Moments::ratio_of_deviations);
    Claim::new(
        &format!("the standard deviation at 100 % is twice that at 97 %: {algorithm} (Fig. 6)"),
        "twice",
        "1.75 to 2.25 times",
        format!("{} times", times.written(2)),
        Verdict::within(&times, 1.75, 2.25),
    )
}

/// Fig. 7's two missions, on a world whose size the paper does not print.
fn one_pair(pair: &[Row; 2]) -> [Claim; 2] {
    let cells = f64::from(pair[0].case.ground.side.pow(2));
    let middle = |row: &Row| [0.025, 0.5, 0.975].map(|below| (row.quantile(below) * cells).round());
    let drawn = |row: &Row, steps: f64| {
        let [low, median, high] = middle(row);
        let share = 100.0 * row.share_up_to(steps / cells);
        (
            (low..=high).contains(&steps),
            format!("median {median}, middle 95 % {low} to {high}, {share:.0} % up to {steps}"),
        )
    };
    let ((overlap_fits, overlap), (voronoi_fits, voronoi)) = (drawn(&pair[0], 444.0), drawn(&pair[1], 449.0));
    let pairs = pair[0].beside(&pair[1]);
    let close = pairs.iter().filter(|[one, other]| ((one - other) * cells).abs() < 5.5).count() as u64;
    let count = pairs.len() as u64;
    let Interval { low, high } = wilson(close, count);
    let close = Estimate { value: close as f64 / count as f64, low, high }.times(100.0);
    let side = pair[0].case.ground.side;
    [
        Claim::new(
            &format!(
                "4 rovers cover 99 % in 444 steps (overlap) and 449 (Voronoi): {side} × {side} (Fig. 7)"
            ),
            "444, 449 steps",
            "both within the middle 95 % of their distributions",
            format!("overlap: {overlap}; Voronoi: {voronoi}"),
            Verdict::of(overlap_fits && voronoi_fits),
        ),
        Claim::new(
            &format!("that both need almost the same is not guaranteed: {side} × {side} (Fig. 7)"),
            "yes",
            "in less than half of the worlds they differ by at most 5 steps",
            format!("{} % of the worlds", close.written(1)),
            Verdict::within(&close, 0.0, 50.0),
        ),
    ]
}

/// Fig. 8: the mean path over all sizes and teams.
fn overlap_is_shorter(sharing: &[Sharing]) -> Claim {
    let times = sharing.iter().map(|both| {
        (Estimate::jackknife(&both.overlap.beside(&both.voronoi), Moments::ratio_of_means), both.overlap.case)
    });
    let times: Vec<_> = times.collect();
    let written = |n: usize| {
        let (times, case) = &times[n];
        format!(
            "{} times ({} rovers, {} × {})",
            times.written(2),
            case.rovers,
            case.ground.side,
            case.ground.side
        )
    };
    let as_short = sharing.iter().map(|both| (both.voronoi_as_short().times(100.0), both.overlap.case));
    let (as_short, case) =
        as_short.max_by(|one, other| one.0.value.total_cmp(&other.0.value)).expect("Fig. 8 has cells");
    let order = |one: &usize, other: &usize| times[*one].0.value.total_cmp(&times[*other].0.value);
    let ends = [(0..times.len()).min_by(order), (0..times.len()).max_by(order)];
    Claim::new(
        "at 95 %, overlap is shorter than Voronoi for every size and team (Fig. 8), in the mean",
        "yes",
        "Voronoi's mean over that of overlap is above 1 in each cell",
        format!(
            "{}; Voronoi is at most as long in up to {} % of the worlds ({} rovers, {} × {})",
            ends.into_iter().flatten().map(written).collect::<Vec<_>>().join(" to "),
            as_short.written(1),
            case.rovers,
            case.ground.side,
            case.ground.side
        ),
        Verdict::all(times.iter().map(|(times, _)| Verdict::above(times, 1.0))),
    )
}

/// Fig. 8: the standard deviation over all sizes and teams.
fn overlap_varies_less(sharing: &[Sharing]) -> Claim {
    let times = sharing
        .iter()
        .map(|both| Estimate::jackknife(&both.overlap.beside(&both.voronoi), Moments::ratio_of_deviations));
    let least = times.min_by(|one, other| one.low.total_cmp(&other.low)).expect("Fig. 8 has cells");
    Claim::new(
        "Voronoi has the larger standard deviation for every size and team (Fig. 8)",
        "yes",
        "its standard deviation over that of overlap is above 1 in each cell",
        format!("at least {} times", least.written(2)),
        Verdict::above(&least, 1.0),
    )
}
