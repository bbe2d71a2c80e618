//! A world as the rows of a general Markov decision process, which every solver can read.
//!
//! Only the free nodes are states, numbered in the order of their nodes. Each has four rows, one per hop,
//! and a row has a reward and a weight a landing: V(s) = max over rows of reward + Σ weight · V(to). The numbers
//! include discount, second periods, goals and losses: a weight is a probability times the
//! discount between departure and landing; the payoffs on the way and on landing, goals' and losses' included,
//! are in the reward. Weights of a row sum to less than 1; the rest ends the process.

use std::io::{self, Write};
use std::path::Path;

use solver::landings::TableWorld;
use solver::{GridWorld, Hop, Kind, Leaving};

/// The rows of a world, flat: four to a state.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    /// Landings of each row.
    pub landings: usize,
    /// The world's node of each state.
    pub nodes: Vec<usize>,
    /// Reward of each row.
    pub rewards: Vec<f64>,
    /// State that each landing of each row leads to, `landings` to a row; −1 where the process ends.
    pub to: Vec<i32>,
    /// Weight of each landing of each row; 0 where the process ends.
    pub weights: Vec<f64>,
}

/// Where a landing leads to: what it pays, and its node, from which the hopper may hop on.
struct Lands {
    weight: f64,
    pays: f64,
    node: Option<usize>,
}

impl Rows {
    /// The rows of `world`.
    #[must_use]
    pub fn of(world: &GridWorld) -> Self {
        let rules = world.rules();
        let row = |node: usize, hop: Hop| {
            let soil = world.soil(node);
            let scatter = world.scatter(node, hop);
            let landings = [
                (scatter.intended, world.neighbour(node, hop)),
                (scatter.stayed, Some(node)),
                (scatter.left, world.neighbour(node, hop.left())),
                (scatter.right, world.neighbour(node, hop.right())),
            ];
            let landings = landings.map(|(probability, to)| {
                let node = to.or((rules.leaving == Leaving::Stays).then_some(node));
                let pays = match node.map(|node| (node, world.kind(node))) {
                    Some((node, Kind::Free | Kind::Goal)) => world.payoff(node),
                    Some((_, Kind::Lost)) | None => rules.loss,
                };
                Lands { weight: soil.discount(rules.discount) * probability, pays, node }
            });
            (rules.discount * soil.wait * world.payoff(node), landings.into())
        };
        Self::new(world.nodes(), |node| world.kind(node), 4, row)
    }

    /// The rows of a world whose hops land by a table.
    #[must_use]
    pub fn of_table(world: &TableWorld) -> Self {
        let rules = world.rules();
        let rows = world.table().rows();
        let row = |node: usize, hop: Hop| {
            let row = &rows[usize::from(world.classes(node)[hop as usize])];
            let lands = |landing: &solver::landings::Landing| {
                let to = world.landing(node, hop, landing.forward, landing.left);
                let node = to.or((rules.leaving == Leaving::Stays).then_some(node));
                let pays = match node.map(|node| (node, world.kind(node))) {
                    Some((node, Kind::Free | Kind::Goal)) => world.payoff(node),
                    Some((_, Kind::Lost)) | None => rules.loss,
                };
                Lands { weight: rules.discount * landing.probability, pays, node }
            };
            (rules.discount * row.lost() * rules.loss, row.landings.iter().map(lands).collect())
        };
        let most = rows.iter().map(|row| row.landings.len()).max().unwrap_or(0);
        Self::new(world.nodes(), |node| world.kind(node), most, row)
    }

    /// The rows of all free nodes: their reward apart from landings, and their landings, of which there are at most `landings`.
    ///
    /// # Panics
    /// If there are more states than an `i32` counts, which no world has.
    fn new(
        nodes: usize,
        kind: impl Fn(usize) -> Kind,
        landings: usize,
        row: impl Fn(usize, Hop) -> (f64, Vec<Lands>),
    ) -> Self {
        let free: Vec<usize> = (0..nodes).filter(|&node| kind(node) == Kind::Free).collect();
        let mut states = vec![-1; nodes];
        for (state, &node) in free.iter().enumerate() {
            states[node] = i32::try_from(state).expect("a world has fewer states than an i32 counts");
        }
        let (mut rewards, mut to, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        for &node in &free {
            for hop in Hop::ALL {
                let (mut reward, lands) = row(node, hop);
                let first = to.len();
                to.resize(first + landings, -1);
                weights.resize(first + landings, 0.0);
                for (slot, Lands { weight, pays, node }) in lands.into_iter().enumerate() {
                    reward += weight * pays;
                    if let Some(state) = node.map(|node| states[node]).filter(|&state| state >= 0) {
                        (to[first + slot], weights[first + slot]) = (state, weight);
                    }
                }
                rewards.push(reward);
            }
        }
        Self { landings, nodes: free, rewards, to, weights }
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
        write(&folder.join("to.i32"), self.to.iter().map(|to| to.to_le_bytes()))?;
        write(&folder.join("weights.f64"), self.weights.iter().map(|weight| weight.to_le_bytes()))
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
        let range = rows.landings * row..rows.landings * (row + 1);
        let landings = rows.to[range.clone()].iter().zip(&rows.weights[range]);
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
    fn the_rows_of_a_table_are_the_solvers_equation() {
        for leaving in [Leaving::Stays, Leaving::Loses] {
            let fixture = Fixture { leaving, ..Fixture::plain(20, 1) };
            let world = fixture.table_world().expect("a sound world");
            let rows = Rows::of_table(&world);
            assert_eq!((rows.landings, rows.nodes.len()), (12, world.nodes() - 1));
            let mut draw = SplitMix64(7);
            let values: Vec<f64> = (0..world.nodes()).map(|_| draw.between(-100.0, 100.0)).collect();
            for (state, &node) in rows.nodes.iter().enumerate() {
                let expected = solver::landings::action_values(&world, &values, node);
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
        for (weights, to) in rows.weights.chunks(rows.landings).zip(rows.to.chunks(rows.landings)) {
            assert!(weights.iter().sum::<f64>() <= 0.99 + 1e-12);
            assert!(
                weights.iter().zip(to).all(|(weight, to)| (*weight >= 0.0) && (*to >= 0 || *weight == 0.0))
            );
        }
    }
}
