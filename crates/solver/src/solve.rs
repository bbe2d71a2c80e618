//! The solver: values from nothing, to a certified bound or to the end of the budget.
//!
//! 1. **Start** from below: every free node has the worst value there can be, min r / (1 − γ) or the loss.
//! 2. **Sweep** Bellman's operator in single precision ([`crate::sweep`]) in a window that moves outwards
//!    from the goal ([`crate::window`]), as long as that pays: on most worlds until the last bits of
//!    single precision, on worlds where lingering beats the goal until the change stalls.
//! 3. **Survey** in double precision, straight from the definition ([`crate::survey`]): residual, and the
//!    best hops. Within the target, that is the certificate, and the end.
//! 4. **Correct** the values by the best hops' linear equation, in single precision
//!    ([`crate::correct`]); on to 3, or, while the residual is above what single precision can tell, to 2.
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
    /// Most sweeps over all nodes; at least one pass is made.
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

/// Most rounds of survey and correction before plain sweeps take over.
const ROUNDS_MAX: u64 = 60;
/// Change of a worth, relative to the largest worth, that single precision can still tell: 16 units in
/// the last place.
const SINGLE: f64 = 1e-6;

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
        let worth_max = world.worth_max();
        let discount = world.rules().discount;
        // Below this the sweeps' own rounding may keep the residual from falling.
        let limit = 2.0 * rounding(2.0 * worth_max) / (1.0 - discount);
        let error_max = effort.error_max.max(limit);
        let residual_max = (error_max * (1.0 - discount) - rounding(2.0 * worth_max)) * (1.0 - 1e-9);
        let nodes = world.nodes() as u64;
        let updates_max = effort.sweeps_max.saturating_mul(nodes);
        let single = (SINGLE * worth_max).max(residual_max);

        if self.skew.fit(world) {
            self.planes.reset(self.skew.len);
        }
        self.start(world);
        let mut updates = 0;
        let mut surveys = 0;
        let mut before = f64::INFINITY;
        // Whether the next survey is expected to be the last.
        let mut expected = false;
        loop {
            if !expected && before > 10.0 * single && surveys < ROUNDS_MAX {
                updates +=
                    self.sweep(world, single as f32, updates_max.saturating_sub(updates), surveys == 0);
            }
            let findings = self.survey(world, expected);
            surveys += 1;
            let certificate = Certificate::new(findings.residual, discount, findings.worth_max);
            let solved = certificate.error_bound <= error_max;
            if solved || updates >= updates_max {
                let status = if solved { Status::Solved } else { Status::Cut };
                return Solution { certificate, status, sweeps: updates.div_ceil(nodes), surveys };
            }
            if expected {
                // Close, but not there: survey again, for the correction this time.
                expected = false;
                continue;
            }
            let stuck = before <= 10.0 * single && findings.residual > 0.5 * before;
            before = findings.residual;
            if stuck || surveys >= ROUNDS_MAX {
                for _ in 0..4 {
                    sweep_plainly(world, &mut self.values, false);
                    sweep_plainly(world, &mut self.values, true);
                }
                updates += 8 * nodes;
            } else {
                let Self { planes, skew, krylov, values, simd, .. } = self;
                let change_max = (0.05 * residual_max) as f32;
                let (corrected, settled) = planes.correct(*simd, skew, krylov, change_max);
                updates += corrected.div_ceil(4);
                expected = settled && before < EXPECTED * single;
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
            if first || pass % 2 == 0 {
                updates += nodes * window.visits();
                window.pass(skew.diagonals(), |diagonals| {
                    planes.relax(*simd, skew, leaving, diagonals, &mut change);
                });
            } else {
                updates += BACK * nodes;
                for _ in 0..BACK {
                    let diagonals = Diagonals::all(skew.diagonals(), true);
                    planes.relax(*simd, skew, leaving, diagonals, &mut change);
                }
            }
            let change = largest(&change);
            if change <= change_min || updates >= updates_max || (!first && pass == 1) {
                break;
            }
            if first && pass > 1 && change > STALL * last {
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
        planes.clear();
        survey::run(*simd, world, values, |columns, y, row| planes.load_row(skew, columns, y, row))
    }
}

/// A correction that settles, from a residual of at most so many times what single precision can tell, is
/// expected to be the last.
const EXPECTED: f64 = 100.0;
/// Sweeps back towards the goal between two surveys.
const BACK: u64 = 3;
/// Reduction of the change from pass to pass below which sweeping no longer pays.
const STALL: f32 = 0.7;
/// One Gauss–Seidel sweep; the largest change of a value.
fn sweep_plainly(world: &World, values: &mut [f64], backwards: bool) -> f64 {
    let mut change = 0.0_f64;
    for index in 0..values.len() {
        let node = if backwards { values.len() - 1 - index } else { index };
        if world.kind(node) == Kind::Free {
            let value = backup(world, values, node);
            change = change.max((value - values[node]).abs());
            values[node] = value;
        }
    }
    change
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
