//! What the paper says of its results, claim by claim, with a verdict on each by the whole 95 % interval of ours.
//!
//! A claim is judged on the cells of profile `paper-2023`, under the first reading of a campaign with several. What needs a
//! cell that a campaign does not have is left out. Nothing is hidden by a profile or reading that fits better elsewhere.

use campaign::cell_results::CellResults;
use campaign::statistics::Sample;
use campaign::tally::CellStatistics;
use contract::Profile;

use crate::cell_beside_paper::CellBesidePaper;
use crate::claim::{Claim, Verdict};
use crate::paper_tests::{PaperTest, paper_tests};
use crate::range::Range;
use crate::tables::{self, Published, TRIALS, WEIGHTS};

/// Both planners on a ground under a pair of weights, ours and the paper's.
struct Pair<'a> {
    weights: [f64; 2],
    mdp: (&'a CellStatistics, Published),
    greedy: (&'a CellStatistics, Published),
}

fn share(statistics: &CellStatistics) -> (u64, u64) {
    (statistics.successes, statistics.trials)
}

fn of_paper(published: &Published) -> (u64, u64) {
    (published.successes, TRIALS)
}

fn at(weights: [f64; 2]) -> String {
    format!("({}, {})", weights[0], weights[1])
}

/// The cells of a ground: both planners under each of the paper's weights that the campaign has.
fn pairs<'a>(cells: &'a [CellBesidePaper<'a>], scenario: &str) -> Vec<Pair<'a>> {
    let find = |planner: &str, weights: [f64; 2]| {
        let is_it = |cell: &&CellResults<'_>| {
            cell.profile == Profile::Paper2023
                && (cell.scenario, cell.planner) == (scenario, planner)
                && [cell.weights.safety, cell.weights.information] == weights
        };
        let of_the_paper = cells.iter().filter(|cell| cell.paper.is_some()).map(|cell| cell.results);
        let cell = of_the_paper.into_iter().find(is_it)?;
        let published = tables::published(scenario, planner, &cell.weights)?;
        (cell.statistics.trials > 0).then_some((&cell.statistics, published))
    };
    let pair = |weights: [f64; 2]| {
        Some(Pair { weights, mdp: find("mdp", weights)?, greedy: find("greedy", weights)? })
    };
    WEIGHTS.into_iter().filter_map(pair).collect()
}

/// Every claim that `cells` can be asked about, in the order of the paper.
pub(crate) fn claims(cells: &[CellBesidePaper<'_>]) -> Vec<Claim> {
    let of = |scenario: &str| pairs(cells, scenario);
    let (hard, mixed, sandy) = (of("hard"), of("heterogeneous"), of("sandy"));
    let (large, treasures) = (of("large"), of("treasures"));
    let mut claims = Vec::new();
    claims.extend(success_above("hard and heterogeneous", hard.iter().chain(&mixed), 0.98, "98 %"));
    claims.extend(success_above("sandy", sandy.iter(), 0.8, "over 80 %"));
    claims.extend(mixed.first().and_then(times_the_success));
    claims.extend(mixed.first().and_then(fewer_steps_in_the_best_case));
    claims.extend(no_deadlock("hard and heterogeneous", hard.iter().chain(&mixed)));
    claims.extend(no_deadlock("sandy", sandy.iter()));
    claims.extend(mixed.first().map(greedy_is_caught));
    claims.extend(hard.iter().filter_map(alike_on_hard_ground));
    claims.extend(mixed.iter().filter_map(|pair| fewer_steps("heterogeneous", pair)));
    claims.extend(sandy.iter().filter_map(|pair| fewer_steps("sandy", pair)));
    claims.extend(sandy.iter().map(|pair| more_success("sandy", pair)));
    claims.extend(large.iter().map(|pair| more_success("large, another map", pair)));
    claims.extend(large.iter().filter_map(half_the_steps));
    claims.extend(large.first().map(fails_on_the_large_map));
    claims.extend(treasures.iter().filter_map(two_treasures));
    claims.extend(treasures.iter().filter_map(greedy_gets_one));
    claims.extend(treasures.iter().filter_map(more_treasures));
    claims.extend(treasures.iter().filter_map(|hunt| detour(hunt, &hard)));
    claims.extend(treasures.iter().filter_map(|hunt| no_less_success(hunt, &hard)));
    claims.extend(paper_tests(cells).iter().filter_map(rejects));
    claims
}

fn success_above<'a>(
    ground: &str,
    pairs: impl Iterator<Item = &'a Pair<'a>>,
    limit: f64,
    paper: &str,
) -> Option<Claim> {
    let shares: Vec<_> = pairs.map(|pair| share(pair.mdp.0)).collect();
    let shares: Vec<_> = shares.into_iter().map(|(part, whole)| Range::of_share(part, whole)).collect();
    let least = shares.iter().copied().min_by(|a, b| a.low.total_cmp(&b.low))?;
    Some(Claim::new(
        &format!("the MDP reaches the goal in {paper} of the missions: {ground}"),
        paper,
        "at every weighting",
        format!("least: {} %", least.percent()),
        Verdict::all(shares.iter().map(|share| Verdict::above(*share, limit))),
    ))
}

fn times_the_success(pair: &Pair<'_>) -> Option<Claim> {
    let ours = Range::of_ratio(share(pair.mdp.0), share(pair.greedy.0))?;
    let paper = Range::of_ratio(of_paper(&pair.mdp.1), of_paper(&pair.greedy.1))?;
    Some(Claim::new(
        "its success is 20 times that of greedy in the best case: heterogeneous (1, 0)",
        "20",
        &format!("{:.0} to {:.0} times, what 100 and 5 of 100 missions allow", paper.low, paper.high),
        format!("{} times", ours.written(1)),
        Verdict::within(ours, paper.low, paper.high),
    ))
}

fn fewer_steps_in_the_best_case(pair: &Pair<'_>) -> Option<Claim> {
    let fewer = |mdp: &Sample, greedy: &Sample| Some(100.0 * (1.0 - mdp.mean? / greedy.mean?));
    let (mdp, greedy) = (&pair.mdp, &pair.greedy);
    let ours = fewer(&mdp.0.steps, &greedy.0.steps)?;
    let theirs = fewer(&mdp.1.steps(), &greedy.1.steps())?;
    Some(Claim::new(
        "38.7 % fewer steps than greedy in the best case",
        "38.7 %",
        &format!("no two means of its tables give that; those of heterogeneous (1, 0) give {theirs:.1} %"),
        format!("{ours:.1} % there, greedy's mean over {} successes", greedy.0.successes),
        Verdict::NotToBeHad,
    ))
}

fn deadlocks(statistics: &CellStatistics) -> u64 {
    statistics.failures.get("deadlock").copied().unwrap_or_default()
}

fn no_deadlock<'a>(ground: &str, pairs: impl Iterator<Item = &'a Pair<'a>>) -> Option<Claim> {
    let cells: Vec<_> = pairs.map(|pair| pair.mdp.0).collect();
    let trials: u64 = cells.iter().map(|cell| cell.trials).sum();
    let count: u64 = cells.iter().map(|cell| deadlocks(cell)).sum();
    (trials > 0).then(|| {
        Claim::new(
            &format!("the MDP avoids deadlocks in all cases: {ground}"),
            "yes",
            "none runs out of steps, of at least 100 missions a cell",
            format!("{count} of {trials}"),
            Verdict::never(count as usize, trials, TRIALS * cells.len() as u64),
        )
    })
}

fn greedy_is_caught(pair: &Pair<'_>) -> Claim {
    let (statistics, published) = &pair.greedy;
    let caught = Range::of_share(deadlocks(statistics), statistics.trials);
    Claim::new(
        "greedy ends in a deadlock: heterogeneous (1, 0)",
        &format!("{} of 100 arrive", published.successes),
        "more than half of its missions run out of steps",
        format!("{} %", caught.percent()),
        Verdict::above(caught, 0.5),
    )
}

fn steps_more(pair: &Pair<'_>) -> Option<Range> {
    Range::of_difference(&pair.greedy.0.steps, &pair.mdp.0.steps)
}

fn paper_more(pair: &Pair<'_>) -> String {
    let difference = || Some(pair.greedy.1.steps().mean? - pair.mdp.1.steps().mean?);
    difference().map_or("no success".into(), |more| format!("{more:+.1}").replace('-', "−"))
}

fn alike_on_hard_ground(pair: &Pair<'_>) -> Option<Claim> {
    let more = steps_more(pair)?;
    Some(Claim::new(
        &format!("greedy takes almost as many steps: hard {}", at(pair.weights)),
        &paper_more(pair),
        "within 2 steps",
        more.written(1),
        Verdict::within(more, -2.0, 2.0),
    ))
}

fn fewer_steps(ground: &str, pair: &Pair<'_>) -> Option<Claim> {
    let more = steps_more(pair)?;
    Some(Claim::new(
        &format!("the MDP takes fewer steps than greedy: {ground} {}", at(pair.weights)),
        &paper_more(pair),
        "greedy's mean over successes less the MDP's is above 0",
        more.written(1),
        Verdict::above(more, 0.0),
    ))
}

fn more_success(ground: &str, pair: &Pair<'_>) -> Claim {
    let more = Range::of_shares(share(pair.mdp.0), share(pair.greedy.0));
    let (mdp, greedy) = (pair.mdp.1.successes, pair.greedy.1.successes);
    Claim::new(
        &format!("the MDP succeeds more often than greedy: {ground} {}", at(pair.weights)),
        &format!("{mdp} and {greedy} of 100"),
        "the difference of the shares is above 0",
        format!("{} points", more.percent()),
        Verdict::above(more, 0.0),
    )
}

fn half_the_steps(pair: &Pair<'_>) -> Option<Claim> {
    let means = |mdp: Sample, greedy: Sample| Some(mdp.mean? / greedy.mean?);
    let paper = means(pair.mdp.1.steps(), pair.greedy.1.steps())?;
    let (mdp, greedy) = (pair.mdp.0.steps, pair.greedy.0.steps);
    let ours = means(mdp, greedy)?;
    // By the relative errors of both means.
    let error = |sample: &Sample| Some(sample.variance_of_mean()?.sqrt() / sample.mean?);
    let half = 1.96 * ours * libm::hypot(error(&mdp)?, error(&greedy)?);
    let ours = Range { value: ours, low: ours - half, high: ours + half };
    Some(Claim::new(
        &format!("the MDP takes less than half of greedy's steps: large, another map {}", at(pair.weights)),
        &format!("{paper:.2}"),
        "its mean over greedy's is below 0.5",
        ours.written(2),
        Verdict::below(ours, 0.5),
    ))
}

fn fails_on_the_large_map(pair: &Pair<'_>) -> Claim {
    let ours = Range::of_share(pair.mdp.0.successes, pair.mdp.0.trials);
    let paper = Range::of_share(pair.mdp.1.successes, TRIALS);
    Claim::new(
        "safety alone makes the MDP fail: large, another map (1, 0)",
        "5 of 100 arrive",
        &format!("{} %, what 5 of 100 allow", paper.percent()),
        format!("{} %", ours.percent()),
        Verdict::within(ours, paper.low, paper.high),
    )
}

/// Share of the successes that collect exactly so many treasures.
fn collects(statistics: &CellStatistics, treasures: u64) -> Option<Range> {
    let count = statistics.treasure_counts.get(&treasures).copied().unwrap_or_default();
    if statistics.successes == 0 { None } else { Some(Range::of_share(count, statistics.successes)) }
}

fn two_treasures(pair: &Pair<'_>) -> Option<Claim> {
    let two = collects(pair.mdp.0, 2)?;
    Some(Claim::new(
        &format!("the MDP collects two treasures most often {}", at(pair.weights)),
        "yes",
        "in more than half of its successes",
        format!("{} %", two.percent()),
        Verdict::above(two, 0.5),
    ))
}

fn greedy_gets_one(pair: &Pair<'_>) -> Option<Claim> {
    let one = collects(pair.greedy.0, 1)?;
    Some(Claim::new(
        &format!("greedy collects one treasure most often {}", at(pair.weights)),
        "yes",
        "in more than half of its successes",
        format!("{} %", one.percent()),
        Verdict::above(one, 0.5),
    ))
}

fn more_treasures(pair: &Pair<'_>) -> Option<Claim> {
    let more = Range::of_difference(&pair.mdp.0.treasures, &pair.greedy.0.treasures)?;
    let paper = pair.mdp.1.treasures()?.mean? - pair.greedy.1.treasures()?.mean?;
    Some(Claim::new(
        &format!("the MDP hunts treasures better than greedy {}", at(pair.weights)),
        &format!("{paper:+.2}").replace('-', "−"),
        "it collects more a success",
        more.written(2),
        Verdict::above(more, 0.0),
    ))
}

/// The cell of hard ground under the same weights.
fn without_treasures<'a, 'b>(hunt: &Pair<'_>, hard: &'b [Pair<'a>]) -> Option<&'b Pair<'a>> {
    hard.iter().find(|pair| pair.weights == hunt.weights)
}

fn detour(hunt: &Pair<'_>, hard: &[Pair<'_>]) -> Option<Claim> {
    let without = without_treasures(hunt, hard)?;
    let ours = Range::of_difference(&hunt.mdp.0.steps, &without.mdp.0.steps)?;
    let paper = Range::of_difference(&hunt.mdp.1.steps(), &without.mdp.1.steps())?;
    Some(Claim::new(
        &format!("treasures cost the MDP steps {}", at(hunt.weights)),
        &format!("{:+.1}", paper.value),
        &format!("{:.1} to {:.1} steps, what the paper's missions allow", paper.low, paper.high),
        ours.written(1),
        Verdict::within(ours, paper.low, paper.high),
    ))
}

fn no_less_success(hunt: &Pair<'_>, hard: &[Pair<'_>]) -> Option<Claim> {
    let without = without_treasures(hunt, hard)?;
    let more = Range::of_shares(share(hunt.mdp.0), share(without.mdp.0));
    Some(Claim::new(
        &format!("treasures cost the MDP no success {}", at(hunt.weights)),
        "yes",
        "at most 2 points less than without",
        format!("{} points", more.percent()),
        Verdict::above(more, -0.02),
    ))
}

/// A t-test, sign and all: the paper prints sizes only, its tables give the sign.
fn rejects(test: &PaperTest) -> Option<Claim> {
    let (ours, theirs) = (test.ours.as_ref()?, test.paper_recomputed_t?);
    let planner = if theirs > 0.0 { "the MDP needs more" } else { "the MDP needs less" };
    let planner = if test.of == "treasures" { "the MDP collects more" } else { planner };
    let ahead = ours.t * theirs.signum();
    let verdict = match test.paper_claims_rejection {
        true => Verdict::above((ahead - ours.critical, ahead + ours.critical), 0.0),
        false => Verdict::of(ours.t.abs() <= ours.critical),
    };
    let what = if test.paper_claims_rejection { "rejects" } else { "does not reject" };
    Some(Claim::new(
        &format!("the t-test {what} that both are alike: Table {} {}", test.table, at(test.weights)),
        &format!("{}, {theirs:+.2} from its tables", test.paper_t.map_or("–".into(), |t| t.to_string()))
            .replace('-', "−"),
        &if test.paper_claims_rejection {
            format!("t is beyond the critical value on the same side: {planner}")
        } else {
            "t is within the critical value".into()
        },
        format!("{:+.2}, critical {:.2}", ours.t, ours.critical).replace('-', "−"),
        verdict,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(got: Range, need: [f64; 3]) {
        for (got, need) in [got.value, got.low, got.high].into_iter().zip(need) {
            assert!((got - need).abs() < 5e-4 * (1.0 + need.abs()), "{got} for {need}");
        }
    }

    #[test]
    fn intervals_are_those_of_the_textbooks() {
        // Newcombe 1998, method 10: 56/70 and 48/80.
        close(Range::of_shares((56, 70), (48, 80)), [0.2, 0.0524, 0.3339]);
        // ln(20) ± 1.96 √(1/100 − 1/100 + 1/5 − 1/100).
        close(Range::of_ratio((100, 100), (5, 100)).unwrap(), [20.0, 8.511, 46.998]);
        assert!(Range::of_ratio((3, 4), (0, 4)).is_none());
        let sample = |mean: f64| Sample { count: 50, mean: Some(mean), sd: Some(2.0) };
        // Half the width: 1.9845 · √(2 · 4 / 50).
        close(Range::of_difference(&sample(7.0), &sample(6.0)).unwrap(), [1.0, 0.2062, 1.7938]);
    }
}
