//! The layers of the dynamic programme, one for each number of steps left.

use contract::{Action, Branch, Brief, Cell, Direction};
use motion::{landing, steps, transitions};
use terrain::Terrain;

/// Branches of a hop.
const BRANCHES: [Branch; 4] = [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right];

/// Layers that are kept: the one being made and the three that a hop's cost reaches back to.
const RING: usize = 4;

/// Successes that differ by less are equal, so that steps decide; rounding stays far below.
const SUCCESS_TIE: f64 = 1.0e-12;

/// What no planner can pass from the start of a mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Largest probability of reaching the goal within `steps_max`.
    pub success: f64,
    /// Least mean of the steps, a failure counted as `steps_max`.
    pub restricted_mean_steps: f64,
}

/// The bounds of a mission on `terrain` under `brief`.
#[must_use]
pub fn bounds(brief: &Brief, terrain: &Terrain) -> Bounds {
    let Some(start) = brief.grid.index(brief.start) else {
        return Bounds { success: 0.0, restricted_mean_steps: brief.limits.steps_max as f64 };
    };
    let mut horizon = Horizon::new(brief, terrain);
    for _ in 0..brief.limits.steps_max {
        horizon.next_layer(&mut |_, _| ());
    }
    let at_start = horizon.here(start);
    Bounds { success: at_start.success, restricted_mean_steps: at_start.least_steps }
}

/// What the best plan from a cell comes to with so many steps left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outlook {
    /// Largest probability of success.
    pub(crate) success: f64,
    /// Least restricted mean, whatever the success.
    pub(crate) least_steps: f64,
    /// Restricted mean of the plan whose success is largest: of such plans the quickest.
    pub(crate) steps: f64,
}

/// Where one branch of a hop leads, how likely it is, and what it costs.
#[derive(Clone, Copy, Debug)]
struct Landing {
    /// Index of the cell; `None` where the mission fails.
    to: Option<usize>,
    probability: f64,
    cost: u64,
}

pub(crate) struct Horizon {
    goal: Option<usize>,
    /// The four hops from each cell; `None` where nobody stands.
    hops: Vec<Option<[[Landing; 4]; 4]>>,
    layers: [Vec<Outlook>; RING],
    left: u64,
}

impl Horizon {
    /// Layer 0: no steps left.
    pub(crate) fn new(brief: &Brief, terrain: &Terrain) -> Self {
        let grid = brief.grid;
        let arrives = |to: Cell| {
            let stands = to == brief.goal || terrain.ground(to).is_some_and(|ground| ground.passable);
            grid.index(to).filter(|_| stands)
        };
        let hops_from = |cell: Cell| {
            let ground = terrain.ground(cell)?;
            let scatter = transitions(&brief.motion, ground);
            Some(Direction::ALL.map(|direction| {
                BRANCHES.map(|branch| Landing {
                    to: arrives(landing(&grid, cell, direction, branch)),
                    probability: scatter[direction as usize].probability(branch),
                    cost: steps(ground.soil, Action::Hop(direction), branch),
                })
            }))
        };
        let late = Outlook { success: 0.0, least_steps: 0.0, steps: 0.0 };
        let goal = grid.index(brief.goal);
        let mut layers = [(); RING].map(|()| vec![late; grid.cells()]);
        if let Some(goal) = goal {
            layers[0][goal].success = 1.0;
        }
        Self { goal, hops: grid.iter().map(hops_from).collect(), layers, left: 0 }
    }

    /// What the newest layer says of a cell.
    pub(crate) fn here(&self, index: usize) -> Outlook {
        self.layers[(self.left % RING as u64) as usize][index]
    }

    /// One more step left; `tell` hears the best hop of each cell but the goal.
    pub(crate) fn next_layer(&mut self, tell: &mut dyn FnMut(usize, Direction)) {
        self.left += 1;
        let place = (self.left % RING as u64) as usize;
        let mut layer = std::mem::take(&mut self.layers[place]);
        for (index, hops) in self.hops.iter().enumerate() {
            layer[index] = match hops {
                _ if self.goal == Some(index) => Outlook { success: 1.0, least_steps: 0.0, steps: 0.0 },
                Some(hops) => {
                    let (best, direction) = self.best(hops);
                    tell(index, direction);
                    best
                }
                None => self.failed(),
            };
        }
        self.layers[place] = layer;
    }

    fn best(&self, hops: &[[Landing; 4]; 4]) -> (Outlook, Direction) {
        let outlooks = hops.map(|landings| self.outlook(&landings));
        let success = outlooks.iter().map(|outlook| outlook.success).fold(0.0, f64::max);
        let least_steps = outlooks.iter().map(|outlook| outlook.least_steps).fold(f64::INFINITY, f64::min);
        let (mut steps, mut direction) = (f64::INFINITY, Direction::North);
        for (outlook, towards) in outlooks.into_iter().zip(Direction::ALL) {
            if outlook.success >= success - SUCCESS_TIE && outlook.steps < steps {
                (steps, direction) = (outlook.steps, towards);
            }
        }
        (Outlook { success, least_steps, steps }, direction)
    }

    /// What a hop comes to if the best follows.
    fn outlook(&self, landings: &[Landing; 4]) -> Outlook {
        let mut sum = Outlook { success: 0.0, least_steps: 0.0, steps: 0.0 };
        for &Landing { to, probability, cost } in landings {
            let (then, spent) = match to {
                // Late, even at the goal.
                _ if cost > self.left => (self.failed(), 0.0),
                Some(to) if cost < self.left || self.goal == Some(to) => {
                    (self.layers[((self.left - cost) % RING as u64) as usize][to], cost as f64)
                }
                _ => (self.failed(), 0.0),
            };
            sum.success += probability * then.success;
            sum.least_steps += probability * (spent + then.least_steps);
            sum.steps += probability * (spent + then.steps);
        }
        sum
    }

    /// A mission that has failed counts at the limit.
    fn failed(&self) -> Outlook {
        Outlook { success: 0.0, least_steps: self.left as f64, steps: self.left as f64 }
    }
}
