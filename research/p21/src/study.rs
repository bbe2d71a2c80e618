//! Travel times of all arms over many worlds, and what they say.

use routing::Stream;
use serde::{Deserialize, Serialize};

use crate::{Arm, Outcome};

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Estimate.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl From<Spread> for (f64, f64) {
    /// The interval.
    fn from(Spread { low, high, .. }: Spread) -> Self {
        (low, high)
    }
}

impl Spread {
    /// The mean of `values` with its normal interval.
    #[must_use]
    pub fn mean(values: &[f64]) -> Self {
        let value = mean(values);
        let variance = values.iter().map(|other| (other - value).powi(2)).sum::<f64>()
            / (values.len() as f64 - 1.0).max(1.0);
        let half = 1.96 * (variance / values.len() as f64).sqrt();
        Self { value, low: value - half, high: value + half }
    }
}

/// How a mission ended: what a study needs to know of an [`Outcome`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ending {
    /// Time to the goal, in Sol; none if the rover is stuck or found no route.
    pub travel_sol: Option<f64>,
    /// Whether it entered a cell of speed 0.
    pub stuck: bool,
    /// Whether it had a route to drive.
    pub has_route: bool,
}

impl From<&Outcome> for Ending {
    fn from(outcome: &Outcome) -> Self {
        let Outcome { travel_sol, stuck, route, .. } = outcome;
        Self { travel_sol: *travel_sol, stuck: *stuck, has_route: !route.is_empty() }
    }
}

/// How the missions of one arm ended, world by world.
#[derive(Clone, Debug)]
pub struct ArmEndings {
    /// In the order of the worlds, the same in each arm.
    pub endings: Vec<Ending>,
}

/// Resamplings of the bootstrap.
const RESAMPLINGS: usize = 1000;

impl ArmEndings {
    /// The endings of each arm of [`Arm::ALL`], from the endings of all arms by world.
    #[must_use]
    pub fn of_arms<'a>(
        worlds: impl Iterator<Item = &'a [Ending; Arm::ALL.len()]> + Clone,
    ) -> [Self; Arm::ALL.len()] {
        std::array::from_fn(|arm| Self { endings: worlds.clone().map(|arms| arms[arm]).collect() })
    }

    /// Travel times of the rovers that arrived, in Sol.
    #[must_use]
    pub fn times_sol(&self) -> Vec<f64> {
        self.endings.iter().filter_map(|ending| ending.travel_sol).collect()
    }

    /// Rovers that got stuck.
    #[must_use]
    pub fn stuck(&self) -> usize {
        self.endings.iter().filter(|ending| ending.stuck).count()
    }

    /// Rovers that had no route to drive.
    #[must_use]
    pub fn without_route(&self) -> usize {
        self.endings.iter().filter(|ending| !ending.has_route).count()
    }

    /// Median travel time, in Sol; NaN if none arrived.
    #[must_use]
    pub fn median_sol(&self) -> f64 {
        median(&mut self.times_sol())
    }

    /// Standard deviation of the travel time (n − 1), in Sol.
    #[must_use]
    pub fn sd_sol(&self) -> f64 {
        sd(&self.times_sol())
    }

    /// 1 − median / median of `without`, the paper's measure, with a bootstrap interval over worlds.
    #[must_use]
    pub fn median_saving(&self, without: &Self) -> Spread {
        let pairs = self.pairs(without);
        let saving = |pairs: &[(f64, f64)]| {
            let mut with: Vec<f64> = pairs.iter().map(|pair| pair.0).collect();
            let mut without: Vec<f64> = pairs.iter().map(|pair| pair.1).collect();
            1.0 - median(&mut with) / median(&mut without)
        };
        bootstrap(&pairs, saving)
    }

    /// Mean over worlds of 1 − time / time of `without`, with its normal interval.
    #[must_use]
    pub fn mean_paired_saving(&self, without: &Self) -> Spread {
        let savings: Vec<f64> =
            self.pairs(without).iter().map(|(with, without)| 1.0 - with / without).collect();
        Spread::mean(&savings)
    }

    /// How much more of the time of `without` is saved than by `other`: the mean over worlds of the difference of both savings,
    /// with its normal interval.
    #[must_use]
    pub fn more_saved(&self, other: &Self, without: &Self) -> Spread {
        let triples = self.triples(other, without);
        let more = triples.iter().map(|[own, other, without]| (other - own) / without);
        Spread::mean(&more.collect::<Vec<_>>())
    }

    /// By how many Sol the median travel time is below that of `other`, with a bootstrap interval over worlds; each of the
    /// rovers of its arm that arrived.
    #[must_use]
    pub fn median_below(&self, other: &Self) -> Spread {
        self.below(other, median)
    }

    /// By how many Sol the standard deviation of travel times is below that of `other`, with a
    /// bootstrap interval over worlds; each of the rovers of its arm that arrived.
    #[must_use]
    pub fn sd_below(&self, other: &Self) -> Spread {
        self.below(other, |times| sd(times))
    }

    /// `measure` of the times of `other` less that of these.
    fn below(&self, other: &Self, measure: impl Fn(&mut [f64]) -> f64) -> Spread {
        let both = self.endings.iter().zip(&other.endings);
        let pairs: Vec<_> = both.map(|(own, other)| (own.travel_sol, other.travel_sol)).collect();
        bootstrap(&pairs, |pairs| {
            let mut own: Vec<f64> = pairs.iter().filter_map(|pair| pair.0).collect();
            let mut other: Vec<f64> = pairs.iter().filter_map(|pair| pair.1).collect();
            measure(&mut other) - measure(&mut own)
        })
    }

    /// Mean time beyond that of the rover that knows the truth, in Sol, with its normal interval.
    #[must_use]
    pub fn regret_sol(&self, knowing: &Self) -> Spread {
        let beyond = self.pairs(knowing).into_iter().map(|(own, knowing)| own - knowing);
        Spread::mean(&beyond.collect::<Vec<_>>())
    }

    /// Share of the regret of `without` to the rover that knows the truth that is not there any more, with a bootstrap interval over
    /// worlds.
    #[must_use]
    pub fn regret_closed(&self, without: &Self, knowing: &Self) -> Spread {
        let triples = self.triples(without, knowing);
        bootstrap(&triples, |triples| {
            let sums = triples.iter().fold((0.0, 0.0), |sums, [own, without, knowing]| {
                (sums.0 + (own - knowing), sums.1 + (without - knowing))
            });
            1.0 - sums.0 / sums.1
        })
    }

    /// Times of three arms, of the worlds in which all arrived.
    fn triples(&self, second: &Self, third: &Self) -> Vec<[f64; 3]> {
        let all = self.endings.iter().zip(&second.endings).zip(&third.endings);
        all.filter_map(|((a, b), c)| Some([a.travel_sol?, b.travel_sol?, c.travel_sol?])).collect()
    }

    /// Times with and without, of the worlds in which both arrived.
    fn pairs(&self, without: &Self) -> Vec<(f64, f64)> {
        let both = self.endings.iter().zip(&without.endings);
        both.filter_map(|(with, without)| Some((with.travel_sol?, without.travel_sol?))).collect()
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn sd(values: &[f64]) -> f64 {
    let mean = mean(values);
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)).sqrt()
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let (low, high) = (values.len().saturating_sub(1) / 2, values.len() / 2);
    values.get(low).zip(values.get(high)).map_or(f64::NAN, |(low, high)| (low + high) / 2.0)
}

/// The percentile bootstrap, with random numbers that do not depend on the values.
fn bootstrap<Pair: Copy>(pairs: &[Pair], measure: impl Fn(&[Pair]) -> f64) -> Spread {
    if pairs.is_empty() {
        return Spread { value: f64::NAN, low: f64::NAN, high: f64::NAN };
    }
    let mut random = Stream::new(1, "bootstrap");
    let mut drawn: Vec<f64> = (0..RESAMPLINGS)
        .map(|_| {
            let pick = |_| pairs[(random.uniform() * pairs.len() as f64) as usize];
            measure(&(0..pairs.len()).map(pick).collect::<Vec<_>>())
        })
        .collect();
    drawn.sort_by(f64::total_cmp);
    let at = |share: f64| drawn[(share * (RESAMPLINGS - 1) as f64).round() as usize];
    Spread { value: measure(pairs), low: at(0.025), high: at(0.975) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn study(times: &[Option<f64>]) -> ArmEndings {
        let ending =
            |time: &Option<f64>| Ending { travel_sol: *time, stuck: time.is_none(), has_route: true };
        ArmEndings { endings: times.iter().map(ending).collect() }
    }

    #[test]
    fn savings_compare_the_worlds_in_which_both_arrived() {
        let without = study(&[Some(1.0), Some(2.0), Some(4.0), Some(1.0)]);
        let with = study(&[Some(1.0), Some(1.0), Some(3.0), None]);
        assert_eq!(with.stuck(), 1);
        assert_eq!(with.mean_paired_saving(&without).value, (0.0 + 0.5 + 0.25) / 3.0);
        let saving = with.median_saving(&without);
        assert_eq!(saving.value, 0.5);
        assert!(saving.low <= saving.value && saving.value <= saving.high);
        assert_eq!(without.median_sol(), 1.5);
        assert_eq!(with.more_saved(&without, &without).value, (0.0 + 0.5 + 0.25) / 3.0);
        assert!((study(&[Some(1.0), Some(3.0)]).sd_sol() - 2_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn how_far_an_arm_is_below_another_has_an_interval_that_few_worlds_leave_wide() {
        let times = |of: fn(usize) -> f64, worlds: usize| {
            study(&(0..worlds).map(|world| Some(of(world))).collect::<Vec<_>>())
        };
        let wide = |world: usize| 1.0 + (world % 5) as f64;
        let narrow = |world: usize| 2.0 + (world * 3 % 4) as f64 / 4.0;
        let few = times(narrow, 4).median_below(&times(wide, 4));
        assert!(few.low < 0.0 && few.high > 0.0, "{few:?}");
        let many = times(narrow, 200).median_below(&times(wide, 200));
        assert!(many.low > 0.0 && many.low <= many.value && many.value <= many.high, "{many:?}");
        assert_eq!(many.value, 3.0 - 2.375);
        let sds = times(narrow, 200).sd_below(&times(wide, 200));
        assert_eq!(sds.value, times(wide, 200).sd_sol() - times(narrow, 200).sd_sol());
        assert!(sds.low > 0.0, "{sds:?}");
    }

    #[test]
    fn the_regret_is_the_time_beyond_that_of_full_knowledge() {
        let without = study(&[Some(2.0), Some(4.0), None]);
        let with = study(&[Some(2.0), Some(2.5), Some(1.0)]);
        let knowing = study(&[Some(1.0), Some(2.0), Some(1.0)]);
        assert_eq!(without.regret_sol(&knowing).value, 1.5);
        assert_eq!(with.regret_closed(&without, &knowing).value, 0.5);
        assert_eq!(knowing.regret_closed(&without, &knowing).value, 1.0);
    }
}
