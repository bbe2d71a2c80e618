//! The solver's session on one brief, kept in step with the observed map.
//!
//! The same process as [`super::model`], laid out for [`solver::online`], which proves each hop by the
//! cheapest way there is. What the session remembers saves time and changes no answer: its hop is a
//! function of brief, map and pose alone ([`solver::online::choice`]).
//!
//! A cell is handed on when what is believed of it changes: seen for the first time, or, in profile
//! `hopper`, all the unseen ones when the majority of the seen soils turns. If much of the map changes at
//! once, the session starts anew.

use contract::{Action, Brief, Cell, Direction, Grid, Ground, ObservedMap, PolicyCell, Profile, Soil};
use solver::online::{Decision, Online, choice};
use solver::{Hop, Kind, Leaving, Rules, Site, World, policy};

use super::model::{LOSS, soils};
use crate::Pulse;
use crate::belief::Belief;
use crate::payoff::LandingPayoff;

/// The session.
#[derive(Clone, Debug)]
pub struct Session {
    brief: Brief,
    lattice: Lattice,
    /// What was believed of each node's cell.
    believed: Vec<Ground>,
    /// What was believed of unseen cells.
    unseen: Ground,
    /// Fingerprint of the map that was believed.
    observation: u64,
    /// The least payoff of a node that is not impassable, 0 at most.
    worst_payoff: f64,
    online: Online,
}

/// The cells a hopper on the goal's lattice can come to, row by row: every `hop_cells`-th.
#[derive(Clone, Copy, Debug)]
struct Lattice {
    grid: Grid,
    origin: Cell,
    width: usize,
    height: usize,
}

impl Session {
    /// A session on `brief` and `map`.
    ///
    /// # Panics
    /// If the brief's numbers are out of range: they are checked where a brief enters a process.
    #[must_use]
    pub fn new(brief: &Brief, map: &ObservedMap) -> Self {
        let lattice = Lattice::new(brief);
        let belief = Belief::new(brief, map);
        let believed: Vec<Ground> =
            (0..lattice.nodes()).map(|node| *belief.ground(lattice.cell(node))).collect();
        let (world, worst_payoff) = world(brief, &lattice, &believed);
        Self {
            brief: *brief,
            lattice,
            believed,
            unseen: belief.unseen,
            observation: map.observation(),
            worst_payoff,
            online: Online::new(world),
        }
    }

    /// Whether the session is about `brief`.
    #[must_use]
    pub fn is_of(&self, brief: &Brief) -> bool {
        self.brief == *brief
    }

    /// Takes in what is believed by now.
    pub fn follow(&mut self, map: &ObservedMap) {
        let belief = Belief::new(&self.brief, map);
        let changed = self.changed(map, &belief);
        (self.unseen, self.observation) = (belief.unseen, map.observation());
        for &node in &changed {
            self.believed[node] = *belief.ground(self.lattice.cell(node));
        }
        if 4 * changed.len() > self.believed.len() {
            let (world, worst_payoff) = world(&self.brief, &self.lattice, &self.believed);
            self.worst_payoff = worst_payoff;
            self.online.replace(world);
            return;
        }
        let payoff = LandingPayoff::new(&self.brief);
        let mut worst_left = false;
        for node in changed {
            worst_left |= counted(self.online.world(), node) <= self.worst_payoff;
            let site = site(&self.brief, &payoff, self.lattice.cell(node), &self.believed[node]);
            self.online.update(node, site);
            self.worst_payoff = self.worst_payoff.min(counted(self.online.world(), node));
        }
        if worst_left {
            self.worst_payoff = worst_payoff(self.online.world());
        }
        // Where it makes a difference, the session starts anew: the loss is near every node of the rim.
        let loss = loss(&self.brief, self.worst_payoff);
        self.online.set_loss(loss).expect("a loss of finite payoffs is finite");
    }

    /// The nodes of which something else is believed now, in order. The map tells which cells are new; all of
    /// them are looked at only if it no longer can, or if unseen ground is taken for something else.
    fn changed(&self, map: &ObservedMap, belief: &Belief<'_>) -> Vec<usize> {
        let differs = |&node: &usize| *belief.ground(self.lattice.cell(node)) != self.believed[node];
        match map.changed_since(self.observation).filter(|_| belief.unseen == self.unseen) {
            Some(cells) => {
                let node = |&index: &u32| self.lattice.node(self.lattice.grid.cell(index as usize));
                let mut nodes: Vec<usize> = cells.iter().filter_map(node).filter(differs).collect();
                nodes.sort_unstable();
                nodes.dedup();
                nodes
            }
            None => (0..self.lattice.nodes()).filter(differs).collect(),
        }
    }

    /// Decides at `cell`, which is on the map, beating as it works; `None` off the goal's lattice.
    pub fn act(&mut self, cell: Cell, pulse: Pulse<'_>) -> Option<Decision> {
        Some(self.online.act_with(self.lattice.node(cell)?, None, &|| pulse.beat()))
    }

    /// Action and value of every cell of the grid in index order; hold and 0 off the goal's lattice.
    pub fn policy(&mut self) -> Vec<PolicyCell> {
        let values = self.online.values().0.to_vec();
        let world = self.online.world();
        let policy_cell = |cell: Cell| {
            let node = self.lattice.node(cell)?;
            let action = policy::hop(world, &values, node, choice::TIE).map_or(Action::Hold, action);
            Some(PolicyCell { action, value: values[node] })
        };
        let nothing = PolicyCell { action: Action::Hold, value: 0.0 };
        self.lattice.grid.iter().map(|cell| policy_cell(cell).unwrap_or(nothing)).collect()
    }
}

/// The contract's name of a hop.
#[must_use]
pub fn action(hop: Hop) -> Action {
    Action::Hop(match hop {
        Hop::North => Direction::North,
        Hop::East => Direction::East,
        Hop::South => Direction::South,
        Hop::West => Direction::West,
    })
}

impl Lattice {
    fn new(brief: &Brief) -> Self {
        let stride = brief.grid.hop_cells as i32;
        let origin = Cell::new(brief.goal.x.rem_euclid(stride), brief.goal.y.rem_euclid(stride));
        let along = |side: u32, origin: i32| ((side as i32 - origin + stride - 1) / stride) as usize;
        Self {
            grid: brief.grid,
            origin,
            width: along(brief.grid.width, origin.x),
            height: along(brief.grid.height, origin.y),
        }
    }

    fn nodes(&self) -> usize {
        self.width * self.height
    }

    fn cell(&self, node: usize) -> Cell {
        let stride = self.grid.hop_cells as i32;
        let (column, row) = ((node % self.width) as i32, (node / self.width) as i32);
        Cell::new(self.origin.x + column * stride, self.origin.y + row * stride)
    }

    fn node(&self, cell: Cell) -> Option<usize> {
        let stride = self.grid.hop_cells as i32;
        (self.grid.contains(cell) && self.grid.on_same_lattice(cell, self.origin)).then(|| {
            let (column, row) = ((cell.x - self.origin.x) / stride, (cell.y - self.origin.y) / stride);
            row as usize * self.width + column as usize
        })
    }
}

/// The world of what is believed, and its least payoff.
fn world(brief: &Brief, lattice: &Lattice, believed: &[Ground]) -> (World, f64) {
    let leaving = match brief.profile {
        Profile::Paper2023 => Leaving::Stays,
        Profile::Hopper => Leaving::Loses,
    };
    let rules = Rules { discount: brief.payoff.discount, loss: 0.0, leaving, soils: soils(brief).to_vec() };
    let refused = "a brief is checked where it enters a process";
    let mut world = World::new(lattice.width, lattice.height, rules).expect(refused);
    let payoff = LandingPayoff::new(brief);
    for (node, ground) in believed.iter().enumerate() {
        world.set(node, site(brief, &payoff, lattice.cell(node), ground));
    }
    let worst_payoff = worst_payoff(&world);
    world.set_loss(loss(brief, worst_payoff)).expect(refused);
    (world, worst_payoff)
}

fn site(brief: &Brief, payoff: &LandingPayoff<'_>, cell: Cell, ground: &Ground) -> Site {
    Site {
        kind: match ground.passable {
            _ if cell == brief.goal => Kind::Goal,
            true => Kind::Free,
            false => Kind::Lost,
        },
        payoff: payoff.of(cell, ground),
        slope_east: libm::atan(ground.gradient[0]) / brief.motion.slope_limit_rad,
        slope_north: libm::atan(ground.gradient[1]) / brief.motion.slope_limit_rad,
        soil: u8::from(ground.soil == Soil::Sand),
    }
}

/// What a node's payoff counts as in the worst: nothing where it is impassable.
fn counted(world: &World, node: usize) -> f64 {
    if world.kind(node) == Kind::Lost { 0.0 } else { world.payoff(node) }
}

fn worst_payoff(world: &World) -> f64 {
    (0..world.nodes()).map(|node| counted(world, node)).fold(0.0, f64::min)
}

/// [`LOSS`] below the worst life there is, as in [`super::model`].
fn loss(brief: &Brief, worst_payoff: f64) -> f64 {
    LOSS + worst_payoff / (1.0 - brief.payoff.discount)
}
