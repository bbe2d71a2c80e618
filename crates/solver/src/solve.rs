//! The solver: values from nothing, to a certified bound or to the end of the budget.
//!
//! 1. **Start** from below: every free node has the worst value there can be, min r / (1 − γ) or the loss.
//! 2. **Sweep** Bellman's operator in single precision (`sweep`) in a window that moves outwards
//!    from the goal (`window`), as long as that pays: on most worlds until the last bits of
//!    single precision, on worlds where lingering beats the goal until the change stalls.
//! 3. **Survey** in double precision, straight from the definition (`survey`): residual, and the
//!    best hops. Within the target, that is the certificate, and the end.
//! 4. **Correct** the values by the best hops' linear equation, in single precision
//!    (`correct`); on to 3, or, while the residual is above what single precision can tell, to 2.
//!
//! Should a round of 3 and 4 not bring the residual down, sweeps in double precision, which contract by γ
//! whatever happens, take over.

use crate::certificate::rounding;
use crate::correct::Krylov;
use crate::simd::Simd;
use crate::skew::{LANES, Skew};
use crate::survey::{self, Findings};
use crate::sweep::Planes;
use crate::window::{Diagonals, Window, largest};
use crate::{Certificate, Hop, Kind, Leaving, Scatter, World};

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Bound on |V − V*| to reach, in units of payoff.
    pub error_max: f64,
    /// Most sweeps over all nodes, as [`Solution::sweeps`] counts them. The last survey comes on top.
    pub sweeps_max: u64,
}

impl Default for Effort {
    /// An error of 1e-6, whatever it takes.
    fn default() -> Self {
        Self { error_max: 1e-6, sweeps_max: u64::MAX }
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The certificate's bound is within the error asked for, or at the limit of floating point.
    Solved,
    /// The budget ended first; values and certificate are valid, the bound is larger.
    Cut,
}

/// How a solve ended, and how good the values are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// The bound on the values' error.
    pub certificate: Certificate,
    /// Whether that is what was asked for.
    pub status: Status,
    /// Sweeps made: updates of nodes over nodes, rounded up. An update of the linear equation counts as a
    /// quarter, about what it takes; surveys are not counted.
    pub sweeps: u64,
    /// Surveys made, the certificate's included.
    pub surveys: u64,
}

/// The solver, with buffers that each solve overwrites: repeated solves of worlds of one size allocate
/// nothing.
#[derive(Clone, Debug, Default)]
pub struct Solver {
    simd: Simd,
    values: Vec<f64>,
    skew: Skew,
    planes: Planes,
    krylov: Krylov,
}

/// Most surveys before plain sweeps take over.
const SURVEYS_MAX: u64 = 60;
/// Surveys in a row without progress before plain sweeps take over for a while.
const STALLS_MAX: u64 = 3;
/// Plain sweeps in a row, there and back.
const PLAIN_SWEEPS: u64 = 8;
/// Change of a worth, relative to the largest worth there may be, that sweeps in single precision reach
/// without delay: some 100 units in the last place.
const SINGLE: f64 = 6e-6;
/// Residuals above so many times that are swept down before they are corrected.
const ROUGH: f64 = 10.0;
/// A correction that settles, from a residual of at most so many times that, is expected to be the last.
const EXPECTED: f64 = 100.0;
/// Change, relative to the residual asked for, at which a correction has settled.
const SETTLED: f64 = 0.05;
/// Reduction of the change from pass to pass below which sweeping no longer pays.
const STALL: f32 = 0.7;
/// Passes between two surveys, every other one back towards the goal.
const PASSES: usize = 8;

impl Solver {
    /// A solver without buffers yet, for the widest vectors this processor has.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A solver for given vectors, or the widest there are if the processor lacks those. The values are
    /// the same bit for bit.
    #[must_use]
    pub fn with_simd(simd: Simd) -> Self {
        Self { simd: simd.or_available(), ..Self::default() }
    }

    /// Value of each node of the world solved last, row-major: 0 at a goal, the loss where lost.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Solves `world` from nothing. The result depends on the world and the effort alone.
    pub fn solve(&mut self, world: &World, effort: &Effort) -> Solution {
        self.solve_with(world, effort, &|| ())
    }

    /// [`Solver::solve`], calling `pulse` whenever some more of the work is done: every few dozen sweeps.
    pub fn solve_with(&mut self, world: &World, effort: &Effort, pulse: &dyn Fn()) -> Solution {
        let worth_max = world.worth_max();
        let discount = world.rules().discount;
        // Below this the sweeps' own rounding may keep the residual from falling.
        let limit = 2.0 * rounding(2.0 * worth_max) / (1.0 - discount);
        let error_max = effort.error_max.max(limit);
        let residual_max = error_max * (1.0 - discount) - rounding(2.0 * worth_max);
        let nodes = world.nodes() as u64;
        let updates_max = effort.sweeps_max.saturating_mul(nodes);
        let single = (SINGLE * worth_max).max(residual_max);

        if self.skew.fit(world) {
            self.planes.reset(self.skew.len);
        }
        self.start(world);
        let (mut updates, mut surveys, mut stalls) = (0, 0, 0);
        let mut residual = f64::INFINITY;
        // Whether the next survey is expected to be the last.
        let mut expected = false;
        // Whether single precision has nothing to offer any more.
        let mut plain = worth_max > SINGLE_MAX;
        loop {
            pulse();
            if !plain && !expected && residual > ROUGH * single {
                let left = updates_max.saturating_sub(updates);
                updates += self.sweep(world, single as f32, left, surveys == 0);
            }
            pulse();
            let findings = self.survey(world, plain || expected);
            surveys += 1;
            let certificate = Certificate::new(findings.residual, discount, findings.worth_max);
            let solved = certificate.error_bound <= error_max;
            // Less than a pass of the linear equation is left: the survey was the last.
            let out = updates_max.saturating_sub(updates) < nodes * Window::default().visits().div_ceil(4);
            if solved || out {
                let status = if solved { Status::Solved } else { Status::Cut };
                return Solution { certificate, status, sweeps: updates.div_ceil(nodes), surveys };
            }
            if !plain && expected {
                // Close, but not there: survey again, for the correction this time.
                expected = false;
                continue;
            }
            stalls = if findings.residual > 0.5 * residual { stalls + 1 } else { 0 };
            residual = findings.residual;
            plain |= surveys >= SURVEYS_MAX;
            if plain || stalls >= STALLS_MAX {
                let sweeps = PLAIN_SWEEPS.min((updates_max - updates) / nodes);
                for sweep in 0..sweeps {
                    sweep_plainly(world, &mut self.values, sweep % 2 == 1);
                    pulse();
                }
                updates += sweeps * nodes;
                stalls = 0;
            } else {
                let Self { planes, skew, krylov, values, simd, .. } = self;
                let change_max = (SETTLED * residual_max) as f32;
                let left = (updates_max - updates).saturating_mul(4);
                let (corrected, settled) = planes.correct(*simd, skew, krylov, change_max, left);
                updates += corrected.div_ceil(4);
                expected = settled && residual < EXPECTED * single;
                planes.add_to(skew, world, values);
            }
        }
    }

    fn start(&mut self, world: &World) {
        let rules = world.rules();
        let worst = (0..world.nodes()).map(|node| world.payoff(node)).fold(0.0, f64::min);
        let mut worst = worst / (1.0 - rules.discount);
        if rules.leaving == Leaving::Loses || (0..world.nodes()).any(|node| world.kind(node) == Kind::Lost) {
            worst = worst.min(rules.loss);
        }
        self.values.clear();
        self.values.extend((0..world.nodes()).map(|node| match world.kind(node) {
            Kind::Free => worst,
            Kind::Goal => 0.0,
            Kind::Lost => rules.loss,
        }));
    }

    /// Sweeps in single precision while that pays; updates made.
    fn sweep(&mut self, world: &World, change_min: f32, updates_max: u64, first: bool) -> u64 {
        let Self { simd, values, skew, planes, .. } = self;
        let nodes = world.nodes() as u64;
        planes.load(skew, world, values);
        let leaving = world.rules().leaving;
        let window = Window::default();
        let mut updates = 0;
        let mut last = f32::INFINITY;
        for pass in 0.. {
            let mut change = [0.0_f32; LANES];
            let windowed = first || pass % 2 == 0;
            let left = updates_max - updates;
            if windowed && left >= nodes * window.visits() {
                updates += nodes * window.visits();
                window.pass(skew.diagonals(), |diagonals| {
                    planes.relax(*simd, skew, leaving, diagonals, &mut change);
                });
            } else if left >= nodes {
                updates += nodes;
                let diagonals = Diagonals::all(skew.diagonals(), !windowed);
                planes.relax(*simd, skew, leaving, diagonals, &mut change);
            } else {
                break;
            }
            let change = largest(&change);
            let stalled = if first { pass > 1 && change > STALL * last } else { pass + 1 == PASSES };
            if change <= change_min || stalled {
                break;
            }
            last = change;
        }
        planes.store(skew, world, values);
        updates
    }

    /// Surveys the values, and, unless that is to be all, takes down the best hops' equation.
    fn survey(&mut self, world: &World, measure_only: bool) -> Findings {
        let Self { simd, values, skew, planes, .. } = self;
        if measure_only {
            return survey::run(*simd, world, values, |_, _, _| {});
        }
        planes.begin(skew);
        survey::run(*simd, world, values, |columns, y, row| planes.load_row(skew, columns, y, row))
    }
}

/// Worths that single precision holds with room for sums.
const SINGLE_MAX: f64 = 1e30;

/// One Gauss–Seidel sweep in double precision.
fn sweep_plainly(world: &World, values: &mut [f64], backwards: bool) {
    for index in 0..values.len() {
        let node = if backwards { values.len() - 1 - index } else { index };
        if world.kind(node) == Kind::Free {
            values[node] = backup(world, values, node);
        }
    }
}

/// The value of a free node under its neighbours' values, with what stays at the node solved for:
/// V = a + b V is V = a / (1 − b), which leaves the fixed point where it is.
fn backup(world: &World, values: &[f64], node: usize) -> f64 {
    let rules = world.rules();
    let soil = world.soil(node);
    let (payoff, discount) = (world.payoff(node), soil.discount(rules.discount));
    let around = Hop::ALL.map(|hop| (world.neighbour(node, hop)).map(|to| world.worth(values, to)));
    let value = |hop: Hop| {
        let Scatter { intended, stayed, left, right } = world.scatter(node, hop);
        let mut stays = stayed;
        let mut leaves = 0.0;
        for (probability, towards) in [(intended, hop), (left, hop.left()), (right, hop.right())] {
            match (around[towards as usize], rules.leaving) {
                (Some(worth), _) => leaves += probability * worth,
                (None, Leaving::Stays) => stays += probability,
                (None, Leaving::Loses) => leaves += probability * rules.loss,
            }
        }
        (rules.discount * soil.wait * payoff + discount * (leaves + stays * payoff))
            / (1.0 - discount * stays)
    };
    Hop::ALL.into_iter().map(value).fold(f64::NEG_INFINITY, f64::max)
}
