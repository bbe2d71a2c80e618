//! A Markov decision process with information as its reward, as Folsom et al. 2021 tried it (Figs 18 and 19), by value iteration.
//!
//! The paper gives neither rewards nor transitions. Here an agent goes to one of four neighbours, and to either side of it with a
//! probability of 10 % each; what is impassable or beyond the map keeps it where it is. Entering a cell pays the entropy of the cell's
//! speed in bits, at every visit: a process without memory cannot pay only the first. A goal pays once, and ends the trip.

use rover::{Belief, SpeedDistribution};

/// γ.
const DISCOUNT: f64 = 0.95;
/// Probability of going to one side of the neighbour aimed at.
const SIDEWAYS: f64 = 0.1;
/// What the goal pays: ten times the most that a cell of two equally likely speeds does.
const GOAL_BITS: f64 = 10.0;

/// East, north, west, south.
const STEPS: [(isize, isize); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// The process on a map.
#[derive(Clone, Debug)]
pub struct GridMdp {
    columns: usize,
    /// Entropy of each cell in bits; no number where it is impassable.
    entropy: Vec<f64>,
    goal: Option<usize>,
}

/// The values of all cells.
#[derive(Clone, Debug)]
pub struct GridValues {
    /// In the order of the cells; no number where the map is impassable.
    pub values: Vec<f64>,
    /// Sweeps until no value changed by more than asked for.
    pub sweeps: usize,
}

/// Shannon entropy in bits (eq. 10, for any number of outcomes).
#[must_use]
pub fn entropy_bits(speeds: &SpeedDistribution) -> f64 {
    let term =
        |probability: &f64| if *probability > 0.0 { -probability * libm::log2(*probability) } else { 0.0 };
    speeds.probabilities().iter().map(term).sum::<f64>().max(0.0)
}

impl GridMdp {
    /// The process on what is known of a map, with or without a goal.
    #[must_use]
    pub fn new(belief: &Belief, goal: Option<usize>) -> Self {
        let entropy = |cell: &SpeedDistribution| {
            if cell.mean_m_per_sol() > 0.0 { entropy_bits(cell) } else { f64::NAN }
        };
        Self {
            columns: belief.surface().lattice().width(),
            entropy: belief.cells().iter().map(entropy).collect(),
            goal,
        }
    }

    /// The cell that a step leads to: where it began, if there is no other.
    fn next(&self, cell: usize, step: usize) -> usize {
        let (columns, rows) = STEPS[step % 4];
        let (column, row) = ((cell % self.columns) as isize + columns, (cell / self.columns) as isize + rows);
        let within = (0..self.columns as isize).contains(&column)
            && (0..(self.entropy.len() / self.columns) as isize).contains(&row);
        let to = (row * self.columns as isize + column) as usize;
        if within && !self.entropy[to].is_nan() { to } else { cell }
    }

    /// What entering a cell is worth.
    fn entering(&self, values: &[f64], cell: usize) -> f64 {
        if self.goal == Some(cell) { GOAL_BITS } else { self.entropy[cell] + DISCOUNT * values[cell] }
    }

    /// What aiming at a neighbour is worth.
    fn aiming(&self, values: &[f64], cell: usize, step: usize) -> f64 {
        let worth = |step: usize| self.entering(values, self.next(cell, step));
        (1.0 - 2.0 * SIDEWAYS) * worth(step) + SIDEWAYS * (worth(step + 1) + worth(step + 3))
    }

    /// The best value, with the step that has it.
    fn best(&self, values: &[f64], cell: usize) -> (f64, usize) {
        let worths = (0..4).map(|step| (self.aiming(values, cell, step), step));
        worths.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))).expect("there are four steps")
    }

    /// Value iteration in place, until no value changes by more than `tolerance`.
    #[must_use]
    pub fn solve(&self, tolerance: f64) -> GridValues {
        let mut values: Vec<f64> =
            self.entropy.iter().map(|bits| if bits.is_nan() { f64::NAN } else { 0.0 }).collect();
        for sweeps in 1.. {
            let mut change = 0.0_f64;
            for cell in 0..values.len() {
                if values[cell].is_nan() || self.goal == Some(cell) {
                    continue;
                }
                let (best, _) = self.best(&values, cell);
                change = change.max((best - values[cell]).abs());
                values[cell] = best;
            }
            if change <= tolerance {
                return GridValues { values, sweeps };
            }
        }
        unreachable!("a discounted process converges")
    }

    /// The cells of the likeliest way from `start`: each step does as aimed. It ends at the goal, or where it comes back to a cell.
    #[must_use]
    pub fn likeliest_way(&self, solution: &GridValues, start: usize) -> Vec<usize> {
        let mut visited = vec![false; self.entropy.len()];
        let mut way = vec![start];
        loop {
            let cell = way[way.len() - 1];
            if self.goal == Some(cell) || std::mem::replace(&mut visited[cell], true) {
                return way;
            }
            way.push(self.next(cell, self.best(&solution.values, cell).1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rover::{Lattice, Speed, Surface};
    use std::sync::Arc;

    /// Seven cells in a row: sure, but for one that is fast or slow.
    fn row() -> Belief {
        let mut cells = vec![SpeedDistribution::certain(Speed::Fast); 7];
        cells[5] = SpeedDistribution::new([0.0, 0.5, 0.0, 0.5]).unwrap();
        Belief::new(Arc::new(Surface::flat(Lattice::new(7, 1).unwrap())), cells).unwrap()
    }

    #[test]
    fn an_even_choice_has_one_bit() {
        assert_eq!(entropy_bits(&SpeedDistribution::new([0.5, 0.0, 0.0, 0.5]).unwrap()), 1.0);
        assert_eq!(entropy_bits(&SpeedDistribution::certain(Speed::Slow)), 0.0);
    }

    #[test]
    fn values_satisfy_the_bellman_equation_and_an_agent_without_a_goal_circles_on_what_is_uncertain() {
        let mdp = GridMdp::new(&row(), None);
        let solution = mdp.solve(1e-12);
        for cell in 0..7 {
            assert!((mdp.best(&solution.values, cell).0 - solution.values[cell]).abs() < 1e-10);
        }
        // In the uncertain cell it aims beyond the map, and stays where it is paid.
        assert_eq!(mdp.likeliest_way(&solution, 0), [0, 1, 2, 3, 4, 5, 5]);
    }

    #[test]
    fn a_goal_near_by_is_reached() {
        let mdp = GridMdp::new(&row(), Some(2));
        assert_eq!(mdp.likeliest_way(&mdp.solve(1e-9), 0), [0, 1, 2]);
    }
}
