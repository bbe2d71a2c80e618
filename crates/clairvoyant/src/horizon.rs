//! The dynamic programme, one layer for each number of steps left.

use contract::{Action, Branch, Cell, Direction, Ground, Leg, MotionTable};
use motion::{Offer, landing, offers, slope_classes, steps, table_landing};
use terrain::Terrain;

/// The branches that a hop may end in.
const BRANCHES: [Branch; 4] = [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right];

/// Layers kept: the one being computed, and the three before it, since a hop costs at most three steps.
const LAYERS: usize = 4;

/// Successes that differ by less count as equal, so that steps decide. Rounding errors are far smaller.
const SUCCESS_TIE: f64 = 1.0e-12;

/// Bounds on what any planner can reach from the start of a mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Largest probability of reaching the goal within `steps_max`.
    pub success: f64,
    /// Least mean of the steps, with a failure counted as `steps_max`.
    pub restricted_mean_steps: f64,
}

/// The bounds of a mission of one `leg` on `terrain`.
#[must_use]
pub fn bounds(leg: &Leg, terrain: &Terrain) -> Bounds {
    let Some(start) = leg.grid.index(leg.start) else {
        return Bounds { success: 0.0, restricted_mean_steps: leg.limits.steps_max as f64 };
    };
    let mut horizon = Horizon::new(leg, terrain, None);
    for _ in 0..leg.limits.steps_max {
        horizon.next_layer(&mut |_, _| ());
    }
    let at_start = horizon.optimum_at(start);
    Bounds { success: at_start.success, restricted_mean_steps: at_start.least_steps }
}

/// The optimum from a cell with a given number of steps left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Optimum {
    /// Largest probability of reaching the goal in time.
    pub(crate) success: f64,
    /// Least restricted mean of the steps, at any success.
    pub(crate) least_steps: f64,
    /// Restricted mean of the quickest plan among those of largest success.
    pub(crate) steps: f64,
}

/// One branch of a hop.
#[derive(Clone, Copy, Debug)]
struct Landing {
    /// Index of the cell; `None` where the mission fails.
    to: Option<usize>,
    probability: f64,
    /// Steps, 1 to 3.
    cost: u64,
}

/// The hops that the true ground offers from a cell.
pub(crate) fn offers_from(leg: &Leg, terrain: &Terrain, cell: Cell, ground: &Ground) -> [Option<Offer>; 4] {
    let height_m = |cell| terrain.ground(cell).map(|ground| ground.height_m);
    offers(&leg.motion, &leg.grid, (cell, ground), height_m)
}

/// Where a hop may land: by the law, or by a table.
#[derive(Clone, Debug)]
enum Landings {
    Law([Landing; 4]),
    Table(Vec<Landing>),
}

impl Landings {
    fn all(&self) -> &[Landing] {
        match self {
            Self::Law(landings) => landings,
            Self::Table(landings) => landings,
        }
    }
}

/// The layers computed so far.
pub(crate) struct Horizon {
    goal: Option<usize>,
    /// The hops from each cell, `None` where none is offered; `None` where the hopper cannot stand.
    hops: Vec<Option<[Option<Landings>; 4]>>,
    layers: [Vec<Optimum>; LAYERS],
    left: u64,
    /// Whether the best hop is that of the least restricted mean, whatever its success: by a table every way may fail, and success alone
    /// would go any way round for the last millionth of it.
    by_steps: bool,
}

impl Horizon {
    /// Computes layer 0, no steps left.
    pub(crate) fn new(leg: &Leg, terrain: &Terrain, table: Option<&MotionTable>) -> Self {
        let grid = leg.grid;
        let arrives = |to: Cell| {
            let stands = to == leg.goal || terrain.ground(to).is_some_and(|ground| ground.passable);
            if stands { grid.index(to) } else { None }
        };
        let hops_from = |cell: Cell| {
            let ground = terrain.ground(cell)?;
            if let Some(table) = table {
                let classes = slope_classes(&grid, (cell, ground), |cell| terrain.ground(cell));
                return Some(Direction::ALL.map(|hop| {
                    let cost_of = |branch| steps(ground.soil, Action::Hop(hop), branch);
                    let row = table.rows()[classes[hop as usize]].landings().iter();
                    let mut landings: Vec<Landing> = row
                        .map(|at| Landing {
                            to: arrives(table_landing(&grid, cell, hop, at)),
                            probability: at.probability,
                            cost: cost_of(if (at.forward, at.left) == (1, 0) {
                                Branch::Intended
                            } else {
                                Branch::Elsewhere
                            }),
                        })
                        .collect();
                    let lands: f64 = landings.iter().map(|landing| landing.probability).sum();
                    let cost = cost_of(Branch::RolledAway);
                    landings.push(Landing { to: None, probability: (1.0 - lands).max(0.0), cost });
                    Some(Landings::Table(landings))
                }));
            }
            let offers = offers_from(leg, terrain, cell, ground);
            Some(Direction::ALL.map(|direction| {
                let offer = offers[direction as usize]?;
                let scatter = offer.scatter();
                Some(Landings::Law(BRANCHES.map(|branch| Landing {
                    to: arrives(landing(&grid, cell, direction, branch)),
                    probability: scatter.probability(branch),
                    cost: steps(ground.soil, offer.action, branch),
                })))
            }))
        };
        let late = Optimum { success: 0.0, least_steps: 0.0, steps: 0.0 };
        let goal = grid.index(leg.goal);
        let mut layers = [(); LAYERS].map(|()| vec![late; grid.cells()]);
        if let Some(goal) = goal {
            layers[0][goal].success = 1.0;
        }
        Self { goal, hops: grid.iter().map(hops_from).collect(), layers, left: 0, by_steps: table.is_some() }
    }

    /// The optimum of a cell in the newest layer.
    pub(crate) fn optimum_at(&self, index: usize) -> Optimum {
        self.layers[(self.left % LAYERS as u64) as usize][index]
    }

    /// Computes the layer with one more step left, and calls `record` with the best hop of each cell but the goal.
    pub(crate) fn next_layer(&mut self, record: &mut dyn FnMut(usize, Direction)) {
        self.left += 1;
        let place = (self.left % LAYERS as u64) as usize;
        let mut layer = std::mem::take(&mut self.layers[place]);
        for (index, hops) in self.hops.iter().enumerate() {
            layer[index] = match hops {
                _ if self.goal == Some(index) => Optimum { success: 1.0, least_steps: 0.0, steps: 0.0 },
                Some(hops) => {
                    let (best, direction) = self.best(hops);
                    record(index, direction);
                    best
                }
                None => self.failed(),
            };
        }
        self.layers[place] = layer;
    }

    fn best(&self, hops: &[Option<Landings>; 4]) -> (Optimum, Direction) {
        // Where no hop is offered, all that is left is to fail.
        let optima = hops.each_ref().map(|landings| match landings {
            Some(landings) => self.optimum_of(landings.all()),
            None => Optimum { success: -1.0, least_steps: f64::INFINITY, steps: f64::INFINITY },
        });
        if hops.iter().all(Option::is_none) {
            return (self.failed(), Direction::North);
        }
        let success = optima.iter().map(|optimum| optimum.success).fold(0.0, f64::max);
        let least_steps = optima.iter().map(|optimum| optimum.least_steps).fold(f64::INFINITY, f64::min);
        let (mut steps, mut direction) = (f64::INFINITY, Direction::North);
        for (optimum, towards) in optima.into_iter().zip(Direction::ALL) {
            let own_steps = if self.by_steps { optimum.least_steps } else { optimum.steps };
            let is_candidate = self.by_steps || optimum.success >= success - SUCCESS_TIE;
            if is_candidate && own_steps < steps {
                (steps, direction) = (own_steps, towards);
            }
        }
        (Optimum { success, least_steps, steps }, direction)
    }

    /// The outcome of a hop if the optimal plan follows.
    fn optimum_of(&self, landings: &[Landing]) -> Optimum {
        let mut sum = Optimum { success: 0.0, least_steps: 0.0, steps: 0.0 };
        for &Landing { to, probability, cost } in landings {
            let (then, spent) = match to {
                // Too late, even at the goal.
                _ if cost > self.left => (self.failed(), 0.0),
                Some(to) if cost < self.left || self.goal == Some(to) => {
                    (self.layers[((self.left - cost) % LAYERS as u64) as usize][to], cost as f64)
                }
                _ => (self.failed(), 0.0),
            };
            sum.success += probability * then.success;
            sum.least_steps += probability * (spent + then.least_steps);
            sum.steps += probability * (spent + then.steps);
        }
        sum
    }

    /// A failed mission counts at the limit.
    fn failed(&self) -> Optimum {
        Optimum { success: 0.0, least_steps: self.left as f64, steps: self.left as f64 }
    }
}
