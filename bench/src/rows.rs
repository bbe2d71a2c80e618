//! A world as the rows of a general Markov decision process, which every solver can read.
//!
//! Only the free nodes are states, numbered in the order of their nodes. Each has four rows, one per hop,
//! and a row has a reward and four weights: V(s) = max over rows of reward + Σ weight · V(to). The numbers
//! include discount, second periods, goals and losses: a weight is a probability times the
//! discount between departure and landing; the payoffs on the way and on landing, goals' and losses' included,
//! are in the reward. Weights of a row sum to less than 1; the rest ends the process.

use std::io::{self, Write};
use std::path::Path;

use solver::{GridWorld, Hop, Kind, Leaving};

/// Most states that a row leads to.
pub const LANDINGS: usize = 4;

/// The rows of a world, flat: four to a state.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    /// The world's node of each state.
    pub nodes: Vec<usize>,
    /// Reward of each row.
    pub rewards: Vec<f64>,
    /// State that each landing of each row leads to; −1 where the process ends.
    pub to: Vec<[i32; LANDINGS]>,
    /// Weight of each landing of each row; 0 where the process ends.
    pub weights: Vec<[f64; LANDINGS]>,
}

impl Rows {
    /// The rows of `world`.
    ///
    /// # Panics
    /// If it has more states than an `i32` counts, which no world has.
    #[must_use]
    pub fn of(world: &GridWorld) -> Self {
        let free = |&node: &usize| world.kind(node) == Kind::Free;
        let nodes: Vec<usize> = (0..world.nodes()).filter(free).collect();
        let mut states = vec![-1; world.nodes()];
        for (state, &node) in nodes.iter().enumerate() {
            states[node] = i32::try_from(state).expect("a world has fewer states than an i32 counts");
        }
        let mut rows = Self { nodes, rewards: Vec::new(), to: Vec::new(), weights: Vec::new() };
        for index in 0..rows.nodes.len() {
            for hop in Hop::ALL {
                rows.push(world, &states, rows.nodes[index], hop);
            }
        }
        rows
    }

    fn push(&mut self, world: &GridWorld, states: &[i32], node: usize, hop: Hop) {
        let rules = world.rules();
        let soil = world.soil(node);
        let discount = soil.discount(rules.discount);
        let scatter = world.scatter(node, hop);
        let landings = [
            (scatter.intended, world.neighbour(node, hop)),
            (scatter.stayed, Some(node)),
            (scatter.left, world.neighbour(node, hop.left())),
            (scatter.right, world.neighbour(node, hop.right())),
        ];
        let mut reward = rules.discount * soil.wait * world.payoff(node);
        let (mut to, mut weights) = ([-1; LANDINGS], [0.0; LANDINGS]);
        for (slot, (probability, landing)) in landings.into_iter().enumerate() {
            let landing = landing.or((rules.leaving == Leaving::Stays).then_some(node));
            let weight = discount * probability;
            reward += weight
                * match landing.map(|landing| (landing, world.kind(landing))) {
                    Some((landing, Kind::Free | Kind::Goal)) => world.payoff(landing),
                    Some((_, Kind::Lost)) | None => rules.loss,
                };
            if let Some(state) = landing.map(|landing| states[landing]).filter(|&state| state >= 0) {
                (to[slot], weights[slot]) = (state, weight);
            }
        }
        self.rewards.push(reward);
        self.to.push(to);
        self.weights.push(weights);
    }

    /// The values of the states among the values of all nodes.
    pub fn values<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.nodes.iter().map(|&node| values[node])
    }

    /// Writes `rewards.f64`, `to.i32` and `weights.f64` into `folder`: little-endian, nothing but numbers.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        write(&folder.join("rewards.f64"), self.rewards.iter().map(|reward| reward.to_le_bytes()))?;
        write(&folder.join("to.i32"), self.to.iter().flatten().map(|to| to.to_le_bytes()))?;
        write(&folder.join("weights.f64"), self.weights.iter().flatten().map(|weight| weight.to_le_bytes()))
    }
}

/// Writes numbers into the file `path`, one after the other.
///
/// # Errors
/// If it cannot be written.
pub fn write<const N: usize>(path: &Path, numbers: impl Iterator<Item = [u8; N]>) -> io::Result<()> {
    let mut file = io::BufWriter::new(std::fs::File::create(path)?);
    for number in numbers {
        file.write_all(&number)?;
    }
    file.flush()
}

#[cfg(test)]
mod tests {
    use solver::fixtures::{Fixture, SplitMix64};

    use super::*;

    /// The rows' right-hand side under `values` of all nodes.
    fn rows_values(rows: &Rows, values: &[f64], row: usize) -> f64 {
        let landings = rows.to[row].iter().zip(&rows.weights[row]);
        rows.rewards[row]
            + landings
                .filter(|(to, _)| **to >= 0)
                .map(|(to, weight)| weight * values[rows.nodes[*to as usize]])
                .sum::<f64>()
    }

    #[test]
    fn the_rows_are_the_solvers_equation() {
        for (fixture, leaving) in [
            (Fixture::plain(20, 1), Leaving::Stays),
            (Fixture::trap(23, 2), Leaving::Stays),
            (Fixture::plain(20, 3), Leaving::Loses),
        ] {
            let world = Fixture { leaving, ..fixture }.world().expect("a sound world");
            let rows = Rows::of(&world);
            assert_eq!(rows.nodes.len(), world.nodes() - 1, "all but the goal");
            let mut draw = SplitMix64(7);
            let values: Vec<f64> = (0..world.nodes()).map(|_| draw.between(-100.0, 100.0)).collect();
            for (state, &node) in rows.nodes.iter().enumerate() {
                let expected = solver::action_values(&world, &values, node);
                for (hop, expected) in expected.into_iter().enumerate() {
                    let got = rows_values(&rows, &values, 4 * state + hop);
                    assert!((got - expected).abs() < 1e-9, "node {node}, hop {hop}: {got}, not {expected}");
                }
            }
        }
    }

    #[test]
    fn the_weights_of_a_row_leave_room_for_the_end() {
        let world = Fixture::plain(20, 1).world().expect("a sound world");
        let rows = Rows::of(&world);
        for (weights, to) in rows.weights.iter().zip(&rows.to) {
            assert!(weights.iter().sum::<f64>() <= 0.99 + 1e-12);
            assert!(
                weights.iter().zip(to).all(|(weight, to)| (*weight >= 0.0) && (*to >= 0 || *weight == 0.0))
            );
        }
    }
}
