//! How well each reading of the paper's open points fits the published numbers.
//!
//! The score of a cell is −ln L, L the likelihood of the paper's numbers if our shares, means and deviations were the
//! truth:
//!
//! - its successes of 100 are binomial, with our share, (successes + ½) / (trials + 1);
//! - its mean of steps is normal about ours, with variance sd² (1/n + 1/m), n the paper's successes and m ours; a cell
//!   with fewer than two successes on either side is scored by its successes alone;
//! - its treasures, where it counts them, are multinomial with our shares, ½ added to each count.
//!
//! Standard deviations are not scored. `large` is kept apart: its map is ours, not the paper's.
//!
//! A reading that is chosen on the numbers it is judged by proves little. So the reading that fits two of the paper's
//! three grounds best is judged on the third, on the treasures and on the large map, for each two in turn.

use std::fmt::Write as _;

use campaign::cell_results::CellResults;
use campaign::markdown::table;
use campaign::notation::{number, percent, signed, spread, weights_in_brackets};
use campaign::report::CampaignResults;
use campaign::tally::CellStatistics;
use serde::Serialize;
use statrs::distribution::{Binomial, Continuous as _, Discrete as _, Normal};
use statrs::function::factorial::ln_factorial;

use crate::tables::{self, Published};

/// The grounds on which a reading may be chosen.
const GROUNDS: [&str; 3] = ["hard", "heterogeneous", "sandy"];

/// What readings are judged on besides the ground left out.
const JUDGES: [&str; 2] = ["treasures", "large"];

/// Most treasures of the paper's worlds.
const TREASURES: usize = 4;

/// The scores of all readings of a campaign.
#[derive(Clone, Debug, Serialize)]
pub struct ReadingScores<'a> {
    /// The readings in the order of the campaign; the first is what the others are compared with.
    pub readings: Vec<ReadingScore<'a>>,
    /// Chosen on two grounds and judged on the rest, for each two in turn.
    pub choices: Vec<Choice<'a>>,
}

/// The scores of one reading.
#[derive(Clone, Debug, Serialize)]
pub struct ReadingScore<'a> {
    /// Its name in the campaign.
    pub reading: &'a str,
    /// Its score in each cell that the paper has.
    pub cells: Vec<CellScore<'a>>,
}

/// Our means of steps less the paper's, over the cells on which greedy and MDP alike hardly meet sand: those of `hard`, and of
/// the MDP on `heterogeneous`. Each counts by the inverse of its variance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PooledDifference {
    /// Weighted mean of the differences, steps.
    pub steps: f64,
    /// Standard error of the weighted mean, steps.
    pub standard_error: f64,
    /// Sum of the squared differences, each in standard errors: χ² if none of them were real.
    pub chi_squared: f64,
    /// Cells of the report whose likelihoods are summed.
    pub cells: usize,
}

/// The score of one cell under one reading.
#[derive(Clone, Debug, Serialize)]
pub struct CellScore<'a> {
    /// Scenario as the campaign names it.
    pub scenario: &'a str,
    /// Name of the algorithm.
    pub planner: &'a str,
    /// Weights w1 and w2.
    pub weights: [f64; 2],
    /// −ln L.
    pub score: f64,
    #[serde(skip)]
    results: &'a CellResults<'a>,
    #[serde(skip)]
    published: Published,
}

/// The reading that fits two grounds best, and how it does on what it was not chosen on.
#[derive(Clone, Debug, Serialize)]
pub struct Choice<'a> {
    /// The two grounds.
    pub chosen_on: [&'static str; 2],
    /// The reading with the lowest score on them.
    pub reading: &'a str,
    /// Its score on them less that of the first reading.
    pub difference: f64,
    /// Its score on each ground it was not chosen on less that of the first reading.
    pub judged: Vec<(&'static str, f64)>,
}

impl<'a> ReadingScores<'a> {
    /// Scores the readings of a campaign that has some; `None` if it has none, or no cell of the paper.
    #[must_use]
    pub fn new(results: &'a CampaignResults<'a>) -> Option<Self> {
        let mut readings: Vec<ReadingScore<'a>> = Vec::new();
        for cell in &results.cells {
            let Some(name) = cell.reading else { continue };
            let Some(scored) = CellScore::new(cell) else { continue };
            match readings.iter_mut().find(|one| one.reading == name) {
                Some(one) => one.cells.push(scored),
                None => readings.push(ReadingScore { reading: name, cells: vec![scored] }),
            }
        }
        let first = readings.first()?.clone();
        let choices = GROUNDS.iter().filter_map(|left_out| {
            let chosen_on = GROUNDS.iter().filter(|ground| *ground != left_out).copied().collect::<Vec<_>>();
            let chosen_on: [&str; 2] = chosen_on.try_into().ok()?;
            let best = readings.iter().min_by(|a, b| a.on(&chosen_on).total_cmp(&b.on(&chosen_on)))?;
            let less = |grounds: &[&str]| best.on(grounds) - first.on(grounds);
            let judges = std::iter::once(*left_out).chain(JUDGES);
            let judged =
                judges.filter(|judge| first.has(judge)).map(|judge| (judge, less(&[judge]))).collect();
            Some(Choice { chosen_on, reading: best.reading, difference: less(&chosen_on), judged })
        });
        let choices = choices.collect();
        Some(Self { readings, choices })
    }

    /// Whether every choice does better than the first reading on everything it was not chosen on.
    #[must_use]
    pub fn one_wins(&self) -> bool {
        let same = self.choices.windows(2).all(|pair| pair[0].reading == pair[1].reading);
        let wins = |choice: &Choice<'_>| choice.judged.iter().all(|(_, difference)| *difference < 0.0);
        same && !self.choices.is_empty() && self.choices.iter().all(wins)
    }

    /// The scores as a page of Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = String::from("# Readings of the paper's open points\n\n");
        text += "−ln L of the paper's successes, means of steps and treasure counts, under our shares, means and \
                 deviations; lower is better. `large` stands apart: its map is ours.\n\n";
        text += &self.score_table();
        text += "\n## Chosen on two grounds, judged on the rest\n\nScores less those of the first reading; below 0 the \
                 chosen one fits better.\n\n";
        text += &self.choice_table();
        let verdict = if self.one_wins() {
            "One reading is chosen each time and wins on everything it was not chosen on."
        } else {
            "No reading is chosen each time and wins on everything it was not chosen on."
        };
        let _ = writeln!(text, "\n{verdict}\n");
        text += &self.pooled_table();
        text += &self.wins_and_losses();
        text
    }

    fn score_table(&self) -> String {
        let rows: Vec<_> = self
            .readings
            .iter()
            .map(|one| {
                let on = |grounds: &[&str]| number(Some(one.on(grounds)), 1);
                [
                    one.reading.to_string(),
                    on(&["hard"]),
                    on(&["heterogeneous"]),
                    on(&["sandy"]),
                    on(&GROUNDS),
                    on(&["treasures"]),
                    on(&["large"]),
                ]
            })
            .collect();
        table(["reading", "hard", "heterogeneous", "sandy", "the three", "treasures", "large"], &rows)
    }

    fn choice_table(&self) -> String {
        let rows: Vec<_> = self
            .choices
            .iter()
            .map(|choice| {
                let judged =
                    choice.judged.iter().map(|(ground, less)| format!("{ground} {}", signed(Some(*less))));
                [
                    choice.chosen_on.join(" and "),
                    choice.reading.to_string(),
                    signed(Some(choice.difference)),
                    judged.collect::<Vec<_>>().join(", "),
                ]
            })
            .collect();
        table(["chosen on", "reading", "there", "judged on"], &rows)
    }

    fn pooled_table(&self) -> String {
        let rows: Vec<_> = (self.readings.iter())
            .filter_map(|one| {
                let PooledDifference { steps, standard_error, chi_squared, cells } = one.pooled()?;
                Some([
                    one.reading.to_string(),
                    format!("{steps:+.2} ± {standard_error:.2}"),
                    format!("{:+.1}", steps / standard_error),
                    format!("{chi_squared:.1} on {cells}"),
                ])
            })
            .collect();
        let title = "## Steps less the paper's, where hardly any hop meets sand\n\nThe cells of hard ground, and of the MDP on \
                     heterogeneous ground, each counted by the inverse of its variance.\n\n";
        format!("{title}{}\n", table(["reading", "difference, steps", "z", "χ²"], &rows))
    }

    /// Cell by cell, the reading that fits the three grounds best beside the first and the paper.
    fn wins_and_losses(&self) -> String {
        let best = self.readings.iter().min_by(|a, b| a.on(&GROUNDS).total_cmp(&b.on(&GROUNDS)));
        let (Some(first), Some(best)) = (self.readings.first(), best) else { return String::new() };
        let rows: Vec<_> = first
            .cells
            .iter()
            .zip(&best.cells)
            .map(|(first, best)| {
                let ours = |cell: &CellScore<'_>| {
                    let CellStatistics { successes, trials, steps, .. } = &cell.results.statistics;
                    format!("{}, {}", percent(*successes, *trials), spread(steps))
                };
                [
                    format!(
                        "{} {} {}",
                        first.scenario,
                        first.planner,
                        weights_in_brackets(&first.results.weights)
                    ),
                    format!("{} %, {}", first.published.successes, spread(&first.published.steps())),
                    ours(first),
                    ours(best),
                    signed(Some(best.score - first.score)),
                ]
            })
            .collect();
        format!(
            "## Where `{}` wins and loses\n\n{}",
            best.reading,
            table(["cell", "paper", first.reading, best.reading, "difference of −ln L"], &rows)
        )
    }
}

impl ReadingScore<'_> {
    /// The sum of the scores on these grounds.
    #[must_use]
    pub fn on(&self, grounds: &[&str]) -> f64 {
        self.cells.iter().filter(|cell| grounds.contains(&cell.scenario)).map(|cell| cell.score).sum()
    }

    /// See [`PooledDifference`]; `None` without such cells.
    #[must_use]
    pub fn pooled(&self) -> Option<PooledDifference> {
        let hardly_sand = |cell: &&CellScore<'_>| {
            cell.scenario == "hard" || (cell.scenario, cell.planner) == ("heterogeneous", "mdp")
        };
        let differences: Vec<(f64, f64)> = (self.cells.iter().filter(hardly_sand))
            .filter_map(|cell| {
                let (ours, theirs) = (cell.results.statistics.steps, cell.published.steps());
                let variance = ours.variance_of_mean()? + theirs.variance_of_mean()?;
                Some((ours.mean? - theirs.mean?, variance))
            })
            .collect();
        let weight: f64 = differences.iter().map(|(_, variance)| 1.0 / variance).sum();
        let sum: f64 = differences.iter().map(|(steps, variance)| steps / variance).sum();
        (!differences.is_empty()).then(|| PooledDifference {
            steps: sum / weight,
            standard_error: weight.recip().sqrt(),
            chi_squared: differences.iter().map(|(steps, variance)| steps * steps / variance).sum(),
            cells: differences.len(),
        })
    }

    fn has(&self, ground: &str) -> bool {
        self.cells.iter().any(|cell| cell.scenario == ground)
    }
}

impl<'a> CellScore<'a> {
    fn new(results: &'a CellResults<'a>) -> Option<Self> {
        let published = tables::published(results.scenario, results.planner, &results.weights)?;
        (results.statistics.trials > 0).then(|| Self {
            scenario: results.scenario,
            planner: results.planner,
            weights: published.weights,
            score: -log_likelihood(&published, &results.statistics),
            results,
            published,
        })
    }
}

fn log_likelihood(paper: &Published, ours: &CellStatistics) -> f64 {
    let share = (ours.successes as f64 + 0.5) / (ours.trials as f64 + 1.0);
    let successes =
        Binomial::new(share, tables::TRIALS).map_or(0.0, |successes| successes.ln_pmf(paper.successes));
    let theirs = paper.steps();
    let steps = match (theirs.mean, ours.steps.mean, ours.steps.sd) {
        (Some(mean), Some(our_mean), Some(sd)) if theirs.count > 1 => {
            let spread = sd.max(1.0) * (1.0 / theirs.count as f64 + 1.0 / ours.steps.count as f64).sqrt();
            Normal::new(our_mean, spread).map_or(0.0, |steps| steps.ln_pdf(mean))
        }
        _ => 0.0,
    };
    successes + steps + treasure_log_likelihood(paper, ours)
}

/// The paper does not print how many successes collected none: what its counts leave of the successes.
fn treasure_log_likelihood(paper: &Published, ours: &CellStatistics) -> f64 {
    if paper.treasures.is_empty() {
        return 0.0;
    }
    let mut counts = [0; TREASURES + 1];
    for &(treasures, successes) in paper.treasures {
        counts[treasures as usize] += successes;
    }
    counts[0] = paper.successes.saturating_sub(counts.iter().sum());
    let shares: Vec<f64> = (0..=TREASURES as u64)
        .map(|treasures| ours.treasure_counts.get(&treasures).copied().unwrap_or(0) as f64 + 0.5)
        .collect();
    let total: f64 = shares.iter().sum();
    let likely: f64 =
        counts.iter().zip(&shares).map(|(&count, share)| count as f64 * libm::log(share / total)).sum();
    let ways =
        ln_factorial(counts.iter().sum()) - counts.iter().map(|&count| ln_factorial(count)).sum::<f64>();
    likely + ways
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use campaign::statistics::{Interval, Sample};

    use super::*;

    fn ours(successes: u64, mean: f64, sd: f64, treasures: &[(u64, u64)]) -> CellStatistics {
        let steps = Sample::published(successes, mean, sd);
        CellStatistics {
            trials: 1000,
            successes,
            success_interval: Interval { low: 0.0, high: 1.0 },
            failures: BTreeMap::new(),
            steps,
            restricted_steps: steps,
            treasures: Sample::of(std::iter::empty()),
            treasure_counts: treasures.iter().copied().collect(),
            mean_hops: None,
            mean_coverage: None,
        }
    }

    #[test]
    fn the_likelihood_of_a_cell_by_hand() {
        // Table 9 at (0.5, 0.5): 92 of 100 in 114.9 steps.
        let sandy = tables::all().find(|cell| cell.table == 9 && cell.weights == [0.5, 0.5]).unwrap();
        let share: f64 = 920.5 / 1001.0;
        let ways: f64 = (1..=8).map(|k| libm::log(f64::from(92 + k) / f64::from(k))).sum();
        let successes = ways + 92.0 * libm::log(share) + 8.0 * libm::log(1.0 - share);
        let variance: f64 = 12.0 * 12.0 * (1.0 / 92.0 + 1.0 / 920.0);
        let steps = -(114.9_f64 - 116.0).powi(2) / (2.0 * variance)
            - libm::log(std::f64::consts::TAU * variance) / 2.0;
        let got = log_likelihood(&sandy, &ours(920, 116.0, 12.0, &[]));
        assert!((got - successes - steps).abs() < 1e-9, "{got} for {}", successes + steps);
        assert!(log_likelihood(&sandy, &ours(920, 119.0, 12.0, &[])) < got, "a mean further off fits less");
        assert!(log_likelihood(&sandy, &ours(700, 116.0, 12.0, &[])) < got, "so do other successes");
    }

    #[test]
    fn treasure_counts_like_the_papers_fit_best() {
        // Table 16 at (1, 0): of 91 successes 2 collected two and 89 one.
        let hunt = tables::all().find(|cell| cell.table == 16 && cell.weights == [1.0, 0.0]).unwrap();
        let score = |counts: &[(u64, u64)]| treasure_log_likelihood(&hunt, &ours(910, 78.5, 7.0, counts));
        assert!(score(&[(1, 890), (2, 20)]) > score(&[(1, 800), (2, 110)]));
        assert!(score(&[(0, 900), (1, 10)]) < -100.0, "hardly any: {}", score(&[(0, 900), (1, 10)]));
        assert!(score(&[]).is_finite());
    }
}
