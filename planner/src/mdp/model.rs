//! The grid world as a Markov decision process: what a hop pays, and where it may lead.
//!
//! With r(x) the payoff of landing on x, γ the discount, p(x′ | x, u) the scatter of hop u:
//!
//! - from hard ground V(x) = γ max_u Σ p (r(x′) + V(x′));
//! - from sand a hop takes two periods, the first spent where it stands:
//!   V(x) = γ max_u \[r(x) + γ Σ p (r(x′) + V(x′))\];
//! - the goal absorbs: V = 0, and landing there pays the brief's goal payoff;
//! - unseen cells are what [`Belief`] takes them for;
//! - in profile `paper-2023` leaving the map counts as staying, in the plan only; in profile `hopper`
//!   it loses the hopper, from unseen cells too;
//! - landing on ground known to be impassable loses the hopper, in both profiles (the paper's worlds
//!   have none).
//!
//! A loss stands in place of r(x′) + V(x′), [`LOSS`] below the worst life there is on this map: the
//! worst payoff for ever, min r / (1 − γ). A fixed price would not do: at −300, far from the goal on
//! a map of 50 × 50 cells the way there costs more than that, and the plan jumps off the map.
//!
//! Hops keep to a lattice of every `hop_cells`-th cell, so only the goal's lattice is modelled.

use contract::{Branch, Brief, Cell, Direction, Grid, Profile, Soil};
use motion::{Transition, soil_motion, transitions};

use crate::Situation;
use crate::belief::Belief;
use crate::payoff::LandingPayoff;

/// What losing the hopper costs beyond the worst life on the map, in units of payoff.
pub const LOSS: f64 = -300.0;

/// What a node of the lattice is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// Ground to hop on.
    Free,
    /// The goal: absorbs.
    Goal,
    /// A treasure still to be collected: absorbs in this model, whose payoff there is all that collecting
    /// it is worth ([`super::treasures`]).
    Treasure,
    /// Known to be impassable: the hopper is lost there.
    Impassable,
    /// The rim around the map.
    Outside,
}

/// The process, on the goal's lattice with a rim of one node around it, row-major, southernmost row
/// first. Its buffers may be reused for another situation: building leaves nothing of the last behind.
#[derive(Clone, Debug)]
pub struct Model {
    /// Nodes a row, the rim included.
    pub width: usize,
    /// What each node is.
    pub nodes: Vec<Node>,
    /// Payoff r of landing on each node; 0 on the rim.
    pub payoffs: Vec<f64>,
    /// Scatter of the four hops from each node, in the order of [`Direction::ALL`].
    pub scatter: Vec<[Transition; 4]>,
    /// Slopes of each node towards the east and the north, in slope limits.
    pub slopes: Vec<[f64; 2]>,
    /// Hard ground and sand, as the solver knows soils.
    pub soils: [solver::Soil; 2],
    /// Whether a hop from the node takes two periods.
    pub two_periods: Vec<bool>,
    /// Discount γ of one period.
    pub discount: f64,
    /// What being lost is worth, in place of payoff and value.
    pub loss: f64,
    /// Whether leaving the map counts as staying; otherwise it is a loss.
    pub leaving_is_staying: bool,
    grid: Grid,
    origin: Cell,
}

impl Model {
    /// The process of `situation`.
    #[must_use]
    pub fn new(situation: &Situation<'_>) -> Self {
        let mut model = Self {
            width: 0,
            nodes: Vec::new(),
            payoffs: Vec::new(),
            scatter: Vec::new(),
            slopes: Vec::new(),
            soils: soils(situation.brief),
            two_periods: Vec::new(),
            discount: 0.0,
            loss: 0.0,
            leaving_is_staying: false,
            grid: situation.brief.grid,
            origin: Cell::default(),
        };
        model.rebuild(situation);
        model
    }

    /// Becomes the process of `situation`, whatever it was before.
    pub fn rebuild(&mut self, situation: &Situation<'_>) {
        let Situation { brief, map, .. } = *situation;
        let stride = brief.grid.hop_cells as i32;
        let along = |side: u32, origin: i32| ((side as i32 - origin + stride - 1) / stride) as usize + 2;
        self.grid = brief.grid;
        self.origin = Cell::new(brief.goal.x.rem_euclid(stride), brief.goal.y.rem_euclid(stride));
        self.width = along(brief.grid.width, self.origin.x);
        let height = along(brief.grid.height, self.origin.y);
        self.discount = brief.payoff.discount;
        self.leaving_is_staying = brief.profile == Profile::Paper2023;

        let belief = Belief::new(brief, map);
        let payoff = LandingPayoff::new(brief);
        let unseen_scatter = transitions(&brief.motion, &belief.unseen);
        refill(&mut self.nodes, self.width * height, Node::Outside);
        refill(&mut self.payoffs, self.width * height, 0.0);
        refill(&mut self.scatter, self.width * height, unseen_scatter);
        refill(&mut self.slopes, self.width * height, [0.0; 2]);
        refill(&mut self.two_periods, self.width * height, false);
        self.soils = soils(brief);
        let mut worst_payoff = 0.0_f64;
        for row in 1..height - 1 {
            for node in row * self.width + 1..(row + 1) * self.width - 1 {
                let cell = self.cell(node);
                let ground = belief.ground(cell);
                self.nodes[node] = match ground.passable {
                    _ if cell == brief.goal => Node::Goal,
                    true => Node::Free,
                    false => Node::Impassable,
                };
                self.payoffs[node] = payoff.of(cell, ground);
                self.two_periods[node] = ground.soil == Soil::Sand;
                self.slopes[node] =
                    ground.gradient.map(|along| libm::atan(along) / brief.motion.slope_limit_rad);
                if belief.is_seen(cell) {
                    self.scatter[node] = transitions(&brief.motion, ground);
                }
                if self.nodes[node] != Node::Impassable {
                    worst_payoff = worst_payoff.min(self.payoffs[node]);
                }
            }
        }
        self.loss = LOSS + worst_payoff / (1.0 - self.discount);
    }

    /// The grid it was built on.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The cell of a node; outside the grid for the rim.
    #[must_use]
    pub fn cell(&self, node: usize) -> Cell {
        let stride = self.grid.hop_cells as i32;
        let (column, row) = ((node % self.width) as i32, (node / self.width) as i32);
        Cell::new(self.origin.x + (column - 1) * stride, self.origin.y + (row - 1) * stride)
    }

    /// The node of a cell; `None` outside the grid or off the goal's lattice.
    #[must_use]
    pub fn node(&self, cell: Cell) -> Option<usize> {
        let stride = self.grid.hop_cells as i32;
        (self.grid.contains(cell) && self.grid.on_same_lattice(cell, self.origin)).then(|| {
            let (column, row) = ((cell.x - self.origin.x) / stride, (cell.y - self.origin.y) / stride);
            (row + 1) as usize * self.width + (column + 1) as usize
        })
    }

    /// The node one hop from `node`, which is not on the rim, towards `direction`.
    #[must_use]
    pub fn neighbour(&self, node: usize, direction: Direction) -> usize {
        match direction {
            Direction::North => node + self.width,
            Direction::East => node + 1,
            Direction::South => node - self.width,
            Direction::West => node - 1,
        }
    }

    /// The free nodes in index order.
    pub fn free(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.nodes.len()).filter(|&node| self.nodes[node] == Node::Free)
    }

    /// Where the hop `direction` from a free node may come down, with which probability: the node
    /// itself where leaving the map counts as staying.
    #[must_use]
    pub fn landings(&self, node: usize, direction: Direction) -> [(usize, f64); 4] {
        let scatter = &self.scatter[node][direction as usize];
        [
            (Branch::Intended, self.neighbour(node, direction)),
            (Branch::Stayed, node),
            (Branch::Left, self.neighbour(node, direction.left())),
            (Branch::Right, self.neighbour(node, direction.right())),
        ]
        .map(|(branch, to)| {
            let stays = self.leaving_is_staying && self.nodes[to] == Node::Outside;
            (if stays { node } else { to }, scatter.probability(branch))
        })
    }

    /// What landing on a node is worth under `values`: r + V, or the loss.
    #[must_use]
    pub fn worth(&self, values: &[f64], node: usize) -> f64 {
        match self.nodes[node] {
            Node::Free => self.payoffs[node] + values[node],
            Node::Goal | Node::Treasure => self.payoffs[node],
            Node::Impassable | Node::Outside => self.loss,
        }
    }

    /// The right-hand side of Bellman's equation at a free node under `values`, for each of the four
    /// hops: straight from the definition, and apart from the solver's kernel.
    #[must_use]
    pub fn action_values(&self, values: &[f64], node: usize) -> [f64; 4] {
        Direction::ALL.map(|direction| {
            let landings = self.landings(node, direction);
            let next: f64 = landings.iter().map(|&(to, p)| p * self.worth(values, to)).sum();
            if self.two_periods[node] {
                self.discount * (self.payoffs[node] + self.discount * next)
            } else {
                self.discount * next
            }
        })
    }

    /// Whether some chain of hops over free nodes leads from `node` to the goal, each landing of it
    /// with a probability above 0.
    #[must_use]
    pub fn leads_to_goal(&self, node: usize) -> bool {
        let mut reached = vec![false; self.nodes.len()];
        let mut open = vec![node];
        while let Some(from) = open.pop() {
            match self.nodes[from] {
                Node::Goal => return true,
                Node::Free | Node::Treasure => {}
                Node::Impassable | Node::Outside => continue,
            }
            for direction in Direction::ALL {
                for (to, probability) in self.landings(from, direction) {
                    if probability > 0.0 && !reached[to] {
                        reached[to] = true;
                        open.push(to);
                    }
                }
            }
        }
        false
    }
}

/// Hard ground and sand, as the solver knows soils: a hop from sand takes two periods.
pub(super) fn soils(brief: &Brief) -> [solver::Soil; 2] {
    [Soil::Hard, Soil::Sand].map(|soil| {
        let motion = soil_motion(&brief.motion, soil);
        // The scatter takes the remainder for one side; here both sides share it. Where there are no slips,
        // rounding may leave a remainder just below 0.
        let sideways = (0.5 * (1.0 - motion.intended - motion.stuck)).max(0.0);
        let wait = f64::from(u8::from(soil == Soil::Sand));
        solver::Soil { intended: motion.intended, stuck: motion.stuck, sideways, wait }
    })
}

fn refill<T: Clone>(buffer: &mut Vec<T>, len: usize, value: T) {
    buffer.clear();
    buffer.resize(len, value);
}
