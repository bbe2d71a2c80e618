//! The process without discount: what each hop costs in steps, and where it ends.

use crate::landings::TableWorld;
use crate::{GridWorld, Hop, Kind, Leaving, Scatter};

/// Steps of a hop that does not take two periods (observe, hop).
const STEPS: f64 = 2.0;

/// A probability of staying above this makes a hop useless: it takes more than 10⁹ tries.
const STAYS_MAX: f64 = 1.0 - 1e-9;

/// Where a landing is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// At a node.
    At(usize),
    /// Off the map or otherwise lost.
    Lost,
}

/// A landing with its probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Where it is.
    pub ends: Ends,
    /// Its probability, in [0, 1].
    pub probability: f64,
}

/// What a hop costs and how it ends apart from its landings on other free nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// Expected steps, above 0.
    pub steps: f64,
    /// Probability of being lost, or of ground from which no goal can be reached.
    pub lost: f64,
    /// Probability of staying, below 1; 1 where the hop is useless.
    pub stays: f64,
}

impl Row {
    pub fn is_useful(&self) -> bool {
        self.stays < 1.0
    }
}

/// Free nodes from which a goal can be reached, in order of distance from the goals, with four hops each.
///
/// It takes about 20 bytes a landing: 200 MB for a map of 821 × 821 nodes whose hops have four landings.
#[derive(Clone, Debug)]
pub struct Process {
    /// Position of each node of the world among the places, or what it is.
    place_of: Vec<u32>,
    /// Node of each place.
    node_of: Vec<u32>,
    /// Hops from each place to a goal.
    distances: Vec<u32>,
    /// Four rows a place.
    rows: Vec<Row>,
    /// First landing of each row, and the number of landings at the end.
    first: Vec<u32>,
    /// Place that each landing is at.
    to: Vec<u32>,
    probabilities: Vec<f64>,
    /// Least steps of a useful hop.
    steps_min: f64,
}

/// Marks in [`Process::place_of`].
const GOAL: u32 = u32::MAX;
const LOST: u32 = u32::MAX - 1;
/// A free node from which no goal can be reached.
const STRANDED: u32 = u32::MAX - 2;

impl Process {
    /// The process of a grid world by its slope law. Payoffs and discount do not matter; leaving the grid is as its rules say.
    #[must_use]
    pub fn of_grid(world: &GridWorld) -> Self {
        let stays = world.rules().leaving == Leaving::Stays;
        Self::new(
            world.nodes(),
            |node| world.kind(node),
            |node, hop, landings| {
                let Scatter { intended, stayed, left, right } = world.scatter(node, hop);
                let to = |towards, probability| {
                    let ends = match world.neighbour(node, towards) {
                        Some(to) => Ends::At(to),
                        None if stays => Ends::At(node),
                        None => Ends::Lost,
                    };
                    Landing { ends, probability }
                };
                landings.push(to(hop, intended));
                landings.push(Landing { ends: Ends::At(node), probability: stayed });
                landings.push(to(hop.left(), left));
                landings.push(to(hop.right(), right));
                STEPS + world.soil(node).wait * intended
            },
        )
    }

    /// The process of a world whose hops land by a table.
    #[must_use]
    pub fn of_table(world: &TableWorld) -> Self {
        let stays = world.rules().leaving == Leaving::Stays;
        Self::new(
            world.nodes(),
            |node| world.kind(node),
            |node, hop, landings| {
                let row = &world.table().rows()[usize::from(world.classes(node)[hop as usize])];
                let mut steps = STEPS;
                for landing in &row.landings {
                    let ends = match world.landing(node, hop, landing.forward, landing.left) {
                        Some(to) => Ends::At(to),
                        None if stays => Ends::At(node),
                        None => Ends::Lost,
                    };
                    if row.waits && (landing.forward, landing.left) == (1, 0) {
                        steps += landing.probability;
                    }
                    landings.push(Landing { ends, probability: landing.probability });
                }
                landings.push(Landing { ends: Ends::Lost, probability: row.lost() });
                steps
            },
        )
    }

    /// The process of `nodes` nodes of the kinds that `kind` gives. `hop` adds the landings of a hop, whose probabilities sum to 1, and
    /// returns its expected steps.
    ///
    /// # Panics
    /// If there are more than 2²⁶ nodes, a landing is at no node, or steps are not finite and above 0.
    #[must_use]
    pub fn new(
        nodes: usize,
        kind: impl Fn(usize) -> Kind,
        hop: impl Fn(usize, Hop, &mut Vec<Landing>) -> f64,
    ) -> Self {
        assert!(nodes <= GridWorld::NODES_MAX, "a process has at most 2^26 nodes, got {nodes}");
        let (order, distances) = outwards(nodes, &kind, &hop);
        let mut place_of = vec![STRANDED; nodes];
        for (node, place) in place_of.iter_mut().enumerate() {
            match kind(node) {
                Kind::Free => {}
                Kind::Goal => *place = GOAL,
                Kind::Lost => *place = LOST,
            }
        }
        for (place, node) in order.iter().enumerate() {
            place_of[*node as usize] = place as u32;
        }
        let mut process = Self {
            place_of,
            rows: Vec::with_capacity(4 * order.len()),
            first: Vec::with_capacity(4 * order.len() + 1),
            to: Vec::new(),
            probabilities: Vec::new(),
            steps_min: f64::INFINITY,
            node_of: order,
            distances,
        };
        process.first.push(0);
        let mut landings = Vec::new();
        for place in 0..process.node_of.len() {
            for towards in Hop::ALL {
                landings.clear();
                let node = process.node_of[place] as usize;
                let steps = hop(node, towards, &mut landings);
                assert!(steps > 0.0 && steps.is_finite(), "a hop needs finite steps above 0, got {steps}");
                process.push(place as u32, steps, &landings);
            }
        }
        process
    }

    /// Adds the next row.
    fn push(&mut self, place: u32, steps: f64, landings: &[Landing]) {
        let (mut lost, mut stays) = (0.0, 0.0);
        let begin = self.to.len();
        for Landing { ends, probability } in landings.iter().filter(|landing| landing.probability > 0.0) {
            let to = match ends {
                Ends::At(node) => self.place_of[*node],
                Ends::Lost => LOST,
            };
            match to {
                GOAL => {}
                LOST | STRANDED => lost += probability,
                to if to == place => stays += probability,
                to => {
                    self.to.push(to);
                    self.probabilities.push(*probability);
                }
            }
        }
        if stays > STAYS_MAX {
            stays = 1.0;
            self.to.truncate(begin);
            self.probabilities.truncate(begin);
        } else {
            self.steps_min = self.steps_min.min(steps);
        }
        self.rows.push(Row { steps, lost, stays });
        self.first.push(self.to.len() as u32);
    }

    /// Number of places: free nodes from which a goal can be reached.
    #[must_use]
    pub fn places(&self) -> usize {
        self.node_of.len()
    }

    /// The place of a node; `None` where it is not free, or no chain of hops leads from it to a goal.
    #[must_use]
    pub fn place(&self, node: usize) -> Option<usize> {
        let place = *self.place_of.get(node)?;
        (place < STRANDED).then_some(place as usize)
    }

    /// Whether a node is a goal.
    #[must_use]
    pub fn is_goal(&self, node: usize) -> bool {
        self.place_of.get(node) == Some(&GOAL)
    }

    /// The node of a place.
    #[must_use]
    pub fn node(&self, place: usize) -> usize {
        self.node_of[place] as usize
    }

    /// Fewest hops from a place to a goal, if all land where they should.
    #[must_use]
    pub fn distance(&self, place: usize) -> u32 {
        self.distances[place]
    }

    /// Least steps of a hop.
    pub(super) fn steps_min(&self) -> f64 {
        self.steps_min
    }

    #[inline(always)]
    pub(super) fn row(&self, place: usize, hop: usize) -> &Row {
        &self.rows[4 * place + hop]
    }

    /// Landings of a row at other places, with their probabilities.
    #[inline(always)]
    pub(super) fn landings(&self, place: usize, hop: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let row = 4 * place + hop;
        let range = self.first[row] as usize..self.first[row + 1] as usize;
        let probabilities = &self.probabilities[range.clone()];
        self.to[range].iter().zip(probabilities).map(|(to, probability)| (*to as usize, *probability))
    }

    /// The expectation of a value over the landings of a hop: `lost` where it is lost, 0 at a goal.
    #[inline(always)]
    pub(super) fn expect(&self, place: usize, hop: usize, lost: f64, value: impl Fn(usize) -> f64) -> f64 {
        let row = self.row(place, hop);
        let mut sum = row.lost * lost + row.stays * value(place);
        for (to, probability) in self.landings(place, hop) {
            sum += probability * value(to);
        }
        sum
    }
}

/// The free nodes from which a goal can be reached, nearest first, and their distances in hops.
fn outwards(
    nodes: usize,
    kind: &impl Fn(usize) -> Kind,
    hop: &impl Fn(usize, Hop, &mut Vec<Landing>) -> f64,
) -> (Vec<u32>, Vec<u32>) {
    // From where hops land on each node, as one list by node.
    let mut landings = Vec::new();
    let mut each = |visit: &mut dyn FnMut(u32, usize)| {
        for from in (0..nodes).filter(|node| kind(*node) == Kind::Free) {
            for towards in Hop::ALL {
                landings.clear();
                let _ = hop(from, towards, &mut landings);
                let is_back = |landing: &&Landing| landing.ends == Ends::At(from);
                let stays: f64 = landings.iter().filter(is_back).map(|landing| landing.probability).sum();
                if stays > STAYS_MAX {
                    continue;
                }
                for landing in landings.iter().filter(|landing| landing.probability > 0.0) {
                    if let Ends::At(to) = landing.ends
                        && to != from
                    {
                        visit(from as u32, to);
                    }
                }
            }
        }
    };
    let mut first = vec![0_u32; nodes + 1];
    each(&mut |_, to| first[to + 1] += 1);
    for node in 0..nodes {
        first[node + 1] += first[node];
    }
    let mut next: Vec<u32> = first[..nodes].to_vec();
    let mut from = vec![0_u32; first[nodes] as usize];
    each(&mut |node, to| {
        from[next[to] as usize] = node;
        next[to] += 1;
    });
    let mut is_met = vec![false; nodes];
    let (mut order, mut distances): (Vec<u32>, Vec<u32>) = (Vec::new(), Vec::new());
    let mut arrive = |to: usize, distance: u32, order: &mut Vec<u32>, distances: &mut Vec<u32>| {
        for node in &from[first[to] as usize..first[to + 1] as usize] {
            if !std::mem::replace(&mut is_met[*node as usize], true) {
                order.push(*node);
                distances.push(distance);
            }
        }
    };
    for goal in (0..nodes).filter(|node| kind(*node) == Kind::Goal) {
        arrive(goal, 1, &mut order, &mut distances);
    }
    let mut done = 0;
    while done < order.len() {
        let (node, distance) = (order[done] as usize, distances[done]);
        arrive(node, distance + 1, &mut order, &mut distances);
        done += 1;
    }
    (order, distances)
}
