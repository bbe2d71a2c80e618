//! The least E\[steps\] + price · P(loss): modified policy iteration with steps and risk side by side.
//!
//! Sweeps of Gauss and Seidel go outwards from the goals, so that a change there crosses the whole map at once; every third goes back.
//! Staying is solved for. A hop replaces the one that was best only if it is better by more than [`TIE`] of its value, so rounding
//! changes no policy for ever.

use super::Process;

/// Share of its cost by which a hop needs to be better than the one that was best.
const TIE: f64 = 1e-12;

/// Most sweeps over the best hops between two over all hops.
const EVALUATIONS: u32 = 12;

/// They end when the change has fallen to this share of that of the sweep over all hops.
const EVALUATED: f64 = 0.05;

/// Unit roundings of the largest value by which values may still change at the end.
const ROUNDINGS: f64 = 4.0;

/// Sweeps without any smaller change after which no smaller one is to be expected.
const STALLED: u32 = 400;

/// The same where steps and risk settle each by itself.
const STALLED_SETTLING: u32 = 40;

/// Most sweeps over all hops.
const ROUNDS_MAX: u32 = 20_000;

/// Steps a hop that a solve from nothing begins with.
const STEPS_GUESS: f64 = 2.5;

/// Steps and risk of a place.
type Values = [f64; 2];

/// A policy of least cost at a price of loss, with its steps and its risk at each place.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved {
    /// Price of a loss, steps.
    pub price: f64,
    /// Number of the hop at each place, in the order of [`crate::Hop::ALL`].
    pub hops: Vec<u8>,
    /// Expected steps and probability of loss under these hops, as computed; [`super::PolicyBounds`] bounds their errors.
    pub(super) values: Vec<Values>,
    /// Sweeps over all hops, and over the best hops.
    pub sweeps: [u32; 2],
}

impl Process {
    /// The policy of least E\[steps\] + price · P(loss) from every place, from the values and hops of `start` or from nothing.
    /// `pulse` is called after each sweep.
    #[must_use]
    pub fn solve(&self, price: f64, start: Option<&Solved>, pulse: &dyn Fn()) -> Solved {
        let mut solved = match start {
            Some(start) => Solved { price, sweeps: [0; 2], ..start.clone() },
            None => self.guess(price),
        };
        let (mut least, mut stalled, mut turn) = (f64::INFINITY, 0, 0_u32);
        for _ in 0..ROUNDS_MAX {
            let (change, replaced) = self.improve(&mut solved);
            solved.sweeps[0] += 1;
            pulse();
            let largest = solved.values.iter().map(|of| of[0] + price * of[1]).fold(0.0, f64::max);
            let settled = ROUNDINGS * f64::EPSILON * largest;
            if replaced == 0 {
                stalled = if change < least { 0 } else { stalled + 1 };
                least = least.min(change);
                if change <= settled || stalled > STALLED {
                    break;
                }
            }
            for _ in 0..EVALUATIONS {
                turn += 1;
                let left = self.evaluate(&mut solved, turn % 3 == 2);
                solved.sweeps[1] += 1;
                pulse();
                if left <= (EVALUATED * change).max(settled) {
                    break;
                }
            }
        }
        // Steps and risk each to the end, where their weighted sum already is.
        let (mut least, mut stalled) = ([f64::INFINITY; 2], 0);
        while stalled < STALLED_SETTLING {
            let inwards = solved.sweeps[1] % 3 == 2;
            let changes = self.settle(&mut solved, inwards);
            solved.sweeps[1] += 1;
            pulse();
            let is_less = changes[0] < least[0] || changes[1] < least[1];
            stalled = if is_less { 0 } else { stalled + 1 };
            least = [least[0].min(changes[0]), least[1].min(changes[1])];
            let steps = solved.values.iter().map(|of| of[0]).fold(0.0, f64::max);
            if changes[0] <= ROUNDINGS * f64::EPSILON * steps && changes[1] <= ROUNDINGS * f64::EPSILON {
                break;
            }
        }
        solved
    }

    /// A first guess: as many steps as hops to the goal, no risk, and hops that lead nearer.
    fn guess(&self, price: f64) -> Solved {
        let values =
            (0..self.places()).map(|place| [STEPS_GUESS * f64::from(self.distance(place)), 0.0]).collect();
        let nearer = |place: usize| {
            let share = |hop: usize| {
                let is_nearer = |to: usize| self.distance(to) < self.distance(place);
                // What neither stays, nor is lost, nor lands elsewhere has reached a goal.
                let elsewhere: f64 =
                    self.landings(place, hop).filter(|(to, _)| !is_nearer(*to)).map(|(_, share)| share).sum();
                let row = self.row(place, hop);
                1.0 - row.lost - row.stays - elsewhere
            };
            let mut best = 0;
            for hop in 1..4 {
                if share(hop) > share(best) {
                    best = hop;
                }
            }
            best as u8
        };
        let hops = (0..self.places()).map(nearer).collect();
        Solved { price, hops, values, sweeps: [0; 2] }
    }

    /// Steps and risk of a hop under `values`, staying solved for.
    #[inline(always)]
    fn value_of(&self, values: &[Values], place: usize, hop: usize) -> Values {
        let row = self.row(place, hop);
        let (mut steps, mut risk) = (row.steps, row.lost);
        for (to, probability) in self.landings(place, hop) {
            let [of_steps, of_risk] = values[to];
            steps += probability * of_steps;
            risk += probability * of_risk;
        }
        let factor = 1.0 / (1.0 - row.stays);
        [factor * steps, factor * risk]
    }

    /// Chooses the best hop of each place; the largest change of a cost, and how many hops were replaced.
    fn improve(&self, solved: &mut Solved) -> (f64, usize) {
        let Solved { price, hops, values, .. } = solved;
        let (mut change, mut replaced): (f64, usize) = (0.0, 0);
        let cost = |of: Values| of[0] + *price * of[1];
        for place in 0..self.places() {
            let kept = usize::from(hops[place]);
            let mut best = (kept, [f64::INFINITY, 0.0]);
            if self.row(place, kept).is_useful() {
                best.1 = self.value_of(values, place, kept);
            }
            let mut need = cost(best.1) - TIE * cost(best.1).abs();
            if need.is_nan() {
                need = f64::INFINITY;
            }
            for hop in (0..4).filter(|hop| *hop != kept && self.row(place, *hop).is_useful()) {
                let of = self.value_of(values, place, hop);
                if cost(of) < need {
                    (best, need) = ((hop, of), cost(of));
                }
            }
            if best.0 != kept {
                hops[place] = best.0 as u8;
                replaced += 1;
            }
            change = change.max((cost(best.1) - cost(values[place])).abs());
            values[place] = best.1;
        }
        (change, replaced)
    }

    /// Updates all places by the hops that are best; the largest change of a cost.
    fn evaluate(&self, solved: &mut Solved, inwards: bool) -> f64 {
        let price = solved.price;
        let [steps, risk] = self.each(solved, inwards, |before, after| {
            [((after[0] - before[0]) + price * (after[1] - before[1])).abs(), 0.0]
        });
        steps.max(risk)
    }

    /// The same, and the largest changes of steps and of risk.
    fn settle(&self, solved: &mut Solved, inwards: bool) -> [f64; 2] {
        self.each(solved, inwards, |before, after| {
            [(after[0] - before[0]).abs(), (after[1] - before[1]).abs()]
        })
    }

    fn each(
        &self,
        solved: &mut Solved,
        inwards: bool,
        changes: impl Fn(Values, Values) -> [f64; 2],
    ) -> [f64; 2] {
        let Solved { hops, values, .. } = solved;
        let mut most = [0.0_f64; 2];
        for at in 0..self.places() {
            let place = if inwards { self.places() - 1 - at } else { at };
            let after = self.value_of(values, place, usize::from(hops[place]));
            let [first, second] = changes(values[place], after);
            most = [most[0].max(first), most[1].max(second)];
            values[place] = after;
        }
        most
    }
}
