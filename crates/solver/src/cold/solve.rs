//! The solver: values from nothing, to a certified bound or to the end of the budget.
//!
//! 1. **Start** from below: every free node gets the worst value there can be, min r / (1 − γ) or the loss.
//! 2. **Sweep** Bellman's operator in single precision (`sweep`), in wavefronts that move away from the goal
//!    (`wavefront`), as long as that pays: on most worlds nearly to the last bits of single precision, on worlds with
//!    lingering until the change stalls. A wavefront starts in a corner. If the goal is not in one, wavefronts
//!    alternate in direction, and the layout is flipped between them, so that a change at the goal crosses each of
//!    the four quadrants around it in one sweep.
//! 3. **Residual** in double precision (`residual`): for each hop at each node, Bellman's right-hand side less the
//!    value.
//! 4. **Correct** the values in single precision, by sweeps of the same operator shifted to the present values. Where
//!    the hopper lingers, and first on small worlds, solve the linear equation of the best hops instead (`correct`):
//!    by sweeps, alternating around a goal inside, and by a Krylov method where they are slow. Then go to 3, or to 2
//!    while the residual is above what single precision can resolve.
//! 5. **Measure** (`measure`) the values as they are handed out, straight from the definition, whenever they are
//!    expected to be good enough, or when the budget ends: the certificate.
//!
//! If rounds of 3 and 4 do not reduce the residual, sweeps in double precision take over, which always contract by γ.

use super::correct::SweepOrder;
use super::krylov::Krylov;
use super::measure;
use super::planes::Planes;
use super::skew::Skew;
use super::wavefront::{Wavefront, largest};
use crate::certificate::rounding;
use crate::extent::Extent;
use crate::simd::{SINGLE_LANES, Simd};
use crate::{Certificate, GridWorld, Hop, Kind, Leaving, Scatter, pages};

/// The error to reach and the work it may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Bound on |V − V*| to reach, in units of payoff. One below 0, or that is not a number, is reached by nothing: the
    /// solve then ends at the limit of floating point, as for 0.
    pub error_max: f64,
    /// Most sweeps over all nodes, counted as in [`Solution::sweeps`]. The last residual pass is extra.
    pub sweeps_max: u64,
}

impl Default for Effort {
    /// An error of 1e-6 and no bound on the sweeps.
    fn default() -> Self {
        Self { error_max: 1e-6, sweeps_max: u64::MAX }
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolveStatus {
    /// The certificate's bound is within the error asked for.
    Solved,
    /// The error asked for is below what floating point can certify on this world. Values and certificate are valid, the
    /// bound is larger, and infinite where the values are beyond the largest number.
    AtLimit,
    /// The budget ended first; values and certificate are valid, the bound is larger.
    Cut,
}

/// How a solve ended, and how good the values are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Bound on the error of the values.
    pub certificate: Certificate,
    /// Whether the error asked for was reached.
    pub status: SolveStatus,
    /// Node updates divided by nodes, rounded up. An update of the linear equation counts as a quarter, about
    /// what it takes; residual passes are not counted.
    pub sweeps: u64,
    /// Passes over all nodes that measured residuals, the certificate's included.
    pub residual_passes: u64,
}

/// Solves worlds from nothing. It keeps its buffers, which each solve overwrites: repeated solves of worlds of one
/// size allocate nothing.
#[derive(Clone, Debug, Default)]
pub struct Solver {
    simd: Simd,
    values: Vec<f64>,
    skew: Skew,
    planes: Planes,
    krylov: Krylov,
}

/// Most residual passes before sweeps in double precision take over for good.
const RESIDUAL_PASSES_MAX: u64 = 60;
/// Residual passes in a row without progress before sweeps in double precision take over for a while.
const STALLS_MAX: u64 = 3;
/// Sweeps in double precision in a row, alternating in direction.
const DOUBLE_SWEEPS: u64 = 8;
/// Change of an afterstate value, relative to the largest there may be, at which sweeps in single precision end: some
/// 250 units in the last place, so that corrections are small enough for single precision to hold them to the bound.
const SINGLE: f64 = 1.5e-5;
/// Change, relative to the largest there may be, at which sweeps in single precision end on small
/// worlds without lingering, where the linear equation of the best hops takes over.
const SINGLE_SMALL: f64 = 1.5e-4;
/// Residuals above this many times that change are swept again before they are corrected.
const SWEEP_AGAIN: f64 = 10.0;
/// A correction that settles, from a residual of at most this many times that change, is expected to be the last.
const LAST_CORRECTION: f64 = 1e4;
/// Change, relative to the residual asked for, at which a correction has settled.
const SETTLED: f64 = 0.5;
/// Ratio of the change to the least one before, above which a wavefront counts as slow.
const STALL: f32 = 0.7;
/// Wavefronts between two residual passes where the hopper lingers, every other one towards the goal.
const WAVEFRONTS_MAX: usize = 8;

/// Numbers of sweeps per wavefront, tuned by benchmark.
struct SweepCounts {
    /// In the first wavefront.
    first: u64,
    /// In each after it.
    next: u64,
    /// In each after it where the hopper lingers.
    slow: u64,
    /// In each around a goal inside the grid.
    around: u64,
}

/// For worlds where sweeps wait for memory.
const SWEEPS_LARGE: SweepCounts = SweepCounts { first: 12, next: 8, slow: 8, around: 12 };
/// For small worlds, which fit into the nearest caches.
const SWEEPS_SMALL: SweepCounts = SweepCounts { first: 10, next: 3, slow: 4, around: 5 };
/// Sweeps of the first wavefront where the hopper lingers.
const FIRST_SLOW: u64 = 12;
/// Nodes between a goal and the nearest side of the grid beyond which it counts as inside.
const INSIDE: usize = 12;
/// Most nodes between a goal and both sides of a corner for it to count as in that corner.
const CORNER: usize = 3;
/// Ratio of the residual to that of two rounds before, above which the hopper counts as lingering.
const SLOW_ROUNDS: f64 = 0.1;
/// Most nodes of a small world.
const SMALL: usize = 4096;
/// Largest afterstate value that single precision holds with room for sums.
const SINGLE_MAX: f64 = 1e30;

/// What stays the same throughout one solve.
struct Task<'a> {
    world: &'a GridWorld,
    pulse: &'a dyn Fn(),
    nodes: u64,
    /// Bound at which the solve ends: the error asked for, or the limit of floating point if that is larger.
    error_max: f64,
    /// Residual that certifies the error asked for.
    residual_max: f64,
    updates_max: u64,
    /// Largest |r + V*| possible.
    afterstate_max: f64,
    /// No free node's value is below this.
    value_min: f64,
    is_small: bool,
    /// Whether the goal lies so far inside that diagonals of one kind lead away from it in two quadrants only.
    goal_is_inside: bool,
    /// Directions of the sweeps of a linear correction.
    order: SweepOrder,
}

impl<'a> Task<'a> {
    fn new(extent: &Extent, world: &'a GridWorld, effort: &Effort, pulse: &'a dyn Fn()) -> Self {
        let rules = world.rules();
        let afterstate_max = extent.afterstate_max(rules);
        // Below this the sweeps' own rounding may keep the residual from falling.
        let limit = 2.0 * rounding(2.0 * afterstate_max) / (1.0 - rules.discount);
        let error_max = effort.error_max.max(limit);
        let nodes = world.nodes() as u64;
        let in_corner = extent.best_goal.is_none_or(|goal| is_in_corner(world, goal));
        Self {
            world,
            pulse,
            nodes,
            error_max,
            residual_max: error_max * (1.0 - rules.discount) - rounding(2.0 * afterstate_max),
            updates_max: effort.sweeps_max.saturating_mul(nodes),
            afterstate_max,
            value_min: extent.value_min(rules),
            is_small: world.nodes() <= SMALL,
            goal_is_inside: extent.best_goal.is_some_and(|goal| is_inside(world, goal)),
            order: if in_corner { SweepOrder::Outwards } else { SweepOrder::Alternating },
        }
    }

    /// Change at which sweeps in single precision end.
    fn single_change(&self, lingers: bool) -> f64 {
        let single = if self.is_small && !lingers { SINGLE_SMALL } else { SINGLE };
        (single * self.afterstate_max).max(self.residual_max)
    }
}

/// What changes from round to round of one solve.
struct Rounds {
    /// Node updates so far.
    updates: u64,
    residual_passes: u64,
    /// Residual passes in a row without progress.
    stalls: u64,
    /// Residuals of the last three rounds, the last one first.
    residuals: [f64; 3],
    /// Whether the values are expected to be good enough.
    expects_done: bool,
    /// Whether sweeps are slow, because the hopper lingers.
    lingers: bool,
    /// Whether the correction keeps the best hops, so that its equation is linear.
    is_linear: bool,
    /// Whether only double precision is of use.
    in_double: bool,
    /// Change of the last round of shifted sweeps around a goal inside.
    change: f32,
}

impl Rounds {
    fn new(task: &Task<'_>) -> Self {
        Self {
            updates: 0,
            residual_passes: 0,
            stalls: 0,
            residuals: [f64::INFINITY; 3],
            expects_done: false,
            lingers: false,
            is_linear: false,
            in_double: task.afterstate_max > SINGLE_MAX,
            change: f32::INFINITY,
        }
    }

    fn updates_left(&self, task: &Task<'_>) -> u64 {
        task.updates_max.saturating_sub(self.updates)
    }

    /// Takes in the residual of another round.
    fn record(&mut self, residual: f64) {
        let [last, before, _] = self.residuals;
        self.stalls = if residual > 0.5 * last { self.stalls + 1 } else { 0 };
        self.residuals = [residual, last, before];
        self.in_double |= self.residual_passes >= RESIDUAL_PASSES_MAX;
    }
}

impl SolveStatus {
    /// Whether more sweeps would not give a better bound: the budget did not end first.
    #[must_use]
    pub fn is_converged(self) -> bool {
        matches!(self, SolveStatus::Solved | SolveStatus::AtLimit)
    }
}

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

    /// This solver with a second thread in wavefronts over large worlds, if `threads` is more than
    /// one. The values are the same bit for bit.
    #[must_use]
    pub fn with_threads(mut self, threads: usize) -> Self {
        self.planes.threads = threads;
        self
    }

    /// Value of each node of the world solved last, row-major: 0 at a goal, the loss where lost.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Solves `world` from nothing. The result depends on the world and the effort alone.
    pub fn solve(&mut self, world: &GridWorld, effort: &Effort) -> Solution {
        self.solve_with(world, effort, &|| ())
    }

    /// [`Solver::solve`], calling `pulse` every few dozen sweeps.
    pub fn solve_with(&mut self, world: &GridWorld, effort: &Effort, pulse: &dyn Fn()) -> Solution {
        let extent = Extent::of(self.simd, world);
        let task = Task::new(&extent, world, effort, pulse);
        self.load(&task, extent.best_goal);
        let mut rounds = Rounds::new(&task);
        loop {
            let single = task.single_change(rounds.lingers);
            pulse();
            if !rounds.in_double && !rounds.expects_done && rounds.residuals[0] > SWEEP_AGAIN * single {
                self.sweep_values(&task, &mut rounds, single as f32);
            }
            pulse();
            // Without updates for another sweep, the next residual pass is the last.
            let is_last = rounds.updates_left(&task) < task.nodes;
            let mut residual = f64::INFINITY;
            if !rounds.in_double && !rounds.expects_done && !is_last {
                residual = self.measure_residuals(&task, &mut rounds);
            }
            if rounds.in_double || rounds.expects_done || is_last || residual <= task.residual_max {
                let certificate = self.certify(&task, &mut rounds);
                let bound = certificate.error_bound;
                let is_converged = bound <= task.error_max;
                if is_converged || is_last {
                    let status = if bound.is_finite() && bound <= effort.error_max {
                        SolveStatus::Solved
                    } else if is_converged {
                        SolveStatus::AtLimit
                    } else {
                        SolveStatus::Cut
                    };
                    let sweeps = rounds.updates.div_ceil(task.nodes);
                    let residual_passes = rounds.residual_passes;
                    return Solution { certificate, status, sweeps, residual_passes };
                }
                if rounds.expects_done {
                    // Close, but not there: another residual pass, for the correction this time.
                    rounds.expects_done = false;
                    continue;
                }
                residual = certificate.residual;
            }
            rounds.record(residual);
            self.correct(&task, &mut rounds, single);
        }
    }

    /// Lays the world out, every free node at the worst value.
    fn load(&mut self, task: &Task<'_>, goal: Option<usize>) {
        if self.skew.fit(task.world, goal) {
            self.planes.reset(self.skew.len);
            self.values = Vec::new();
            self.values = pages::filled(0.0, task.world.nodes());
        }
        self.planes.load_uniform(self.simd, &self.skew, task.world, task.value_min);
    }

    /// Sweeps afterstate values in single precision while that pays.
    fn sweep_values(&mut self, task: &Task<'_>, rounds: &mut Rounds, change_max: f32) {
        let sweeps_max = rounds.updates_left(task) / task.nodes;
        let is_first = rounds.residual_passes == 0;
        let (sweeps, settled) = if task.goal_is_inside && is_first {
            self.sweep_around(task, change_max, sweeps_max)
        } else {
            self.sweep(task.world, change_max, sweeps_max, is_first)
        };
        rounds.updates += sweeps * task.nodes;
        rounds.lingers |= !settled;
    }

    /// Measures the residuals and prepares the equation of the correction; the largest.
    fn measure_residuals(&mut self, task: &Task<'_>, rounds: &mut Rounds) -> f64 {
        let Self { planes, skew, simd, .. } = self;
        let linear = rounds.lingers || (rounds.residual_passes == 0 && task.is_small);
        if rounds.is_linear && !linear {
            planes.resume(*simd, skew, task.world);
        }
        rounds.is_linear = linear;
        rounds.residual_passes += 1;
        if linear {
            planes.linear_residuals(*simd, skew, task.world)
        } else {
            planes.hop_residuals(*simd, skew, task.world)
        }
    }

    /// Hands the values out and measures them from the definition.
    fn certify(&mut self, task: &Task<'_>, rounds: &mut Rounds) -> Certificate {
        let Self { planes, skew, values, simd, .. } = self;
        planes.read_values(*simd, skew, task.world, values);
        let measured = measure::run(*simd, task.world, values);
        rounds.residual_passes += 1;
        Certificate::new(measured.residual, task.world.rules().discount, measured.afterstate_max)
    }

    /// Corrects the values by their residuals.
    fn correct(&mut self, task: &Task<'_>, rounds: &mut Rounds, single: f64) {
        let left = rounds.updates_left(task);
        let [residual, _, two_before] = rounds.residuals;
        let change_max = (SETTLED * task.residual_max) as f32;
        if rounds.in_double || rounds.stalls >= STALLS_MAX || !residual.is_finite() {
            let sweeps = DOUBLE_SWEEPS.min(left / task.nodes);
            self.sweep_in_double(task, sweeps);
            rounds.is_linear = false;
            rounds.updates += sweeps * task.nodes;
            rounds.stalls = 0;
        } else if rounds.is_linear {
            let Self { planes, skew, krylov, simd, .. } = self;
            let updates_max = left.saturating_mul(4);
            let (updates, settled) = planes.correct(*simd, skew, krylov, task.order, change_max, updates_max);
            rounds.updates += updates.div_ceil(4);
            rounds.expects_done = settled && residual < LAST_CORRECTION * single;
            planes.add(*simd);
        } else if task.goal_is_inside {
            let (sweeps, change) = self.sweep_both_ways(task.world, true, left / task.nodes);
            rounds.updates += sweeps * task.nodes;
            rounds.lingers |= residual > SLOW_ROUNDS * two_before;
            rounds.expects_done = sweeps > 0 && change.max(rounds.change) <= change_max;
            rounds.change = change;
            self.planes.add(self.simd);
            self.flip_layout(task.world);
        } else {
            let (sweeps, settled) = self.sweep_shifted(task.world, change_max, left / task.nodes);
            rounds.updates += sweeps * task.nodes;
            rounds.lingers |= !settled;
            rounds.expects_done = settled;
            self.planes.add(self.simd);
        }
    }

    /// Sweeps in double precision.
    fn sweep_in_double(&mut self, task: &Task<'_>, sweeps: u64) {
        let Self { planes, skew, values, simd, .. } = self;
        planes.read_values(*simd, skew, task.world, values);
        // A sweep does not contract from values that are not finite.
        values.iter_mut().filter(|value| !value.is_finite()).for_each(|value| *value = task.value_min);
        for sweep in 0..sweeps {
            sweep_once_in_double(task.world, values, sweep % 2 == 1);
            (task.pulse)();
        }
        planes.load_values(*simd, skew, task.world, values);
    }

    /// Sweeps in single precision while that pays; sweeps made, and whether they reached `change_max`.
    fn sweep(&mut self, world: &GridWorld, change_max: f32, sweeps_max: u64, is_first: bool) -> (u64, bool) {
        let Self { simd, skew, planes, .. } = self;
        if !is_first {
            planes.resume(*simd, skew, world);
        }
        let leaving = world.rules().leaving;
        let counts = sweep_counts(world);
        let mut convergence = Convergence::default();
        let mut sweeps = 0;
        loop {
            let backwards = !is_first && convergence.wavefronts % 2 == 1;
            let wanted = match (is_first, convergence.wavefronts) {
                _ if backwards => 1,
                (true, 0) => counts.first,
                (true, _) => counts.next,
                (false, 0) => FIRST_SLOW,
                (false, _) => counts.slow,
            };
            let wavefront = Wavefront { sweeps: wanted.min(sweeps_max - sweeps) as usize, backwards };
            let mut change = [0.0_f32; SINGLE_LANES];
            if wavefront.sweeps > 0 {
                planes.relax(*simd, skew, leaving, false, wavefront, &mut change);
            }
            sweeps += wavefront.sweeps as u64;
            let settled = convergence.record(largest(&change), change_max);
            let stalled =
                if is_first { convergence.slow > 1 } else { convergence.wavefronts == WAVEFRONTS_MAX };
            if settled || stalled || wavefront.sweeps == 0 {
                planes.adopt(*simd, skew);
                return (sweeps, settled && wavefront.sweeps > 0);
            }
        }
    }

    /// Sweeps in single precision around a goal inside the grid while that pays; sweeps made, and whether they
    /// reached `change_max`.
    fn sweep_around(&mut self, task: &Task<'_>, change_max: f32, sweeps_max: u64) -> (u64, bool) {
        let mut convergence = Convergence::default();
        let mut sweeps = 0;
        let mut change_before = f32::INFINITY;
        loop {
            let (more, change) = self.sweep_both_ways(task.world, false, sweeps_max - sweeps);
            sweeps += more;
            self.planes.adopt(self.simd, &self.skew);
            self.flip_layout(task.world);
            (task.pulse)();
            // The diagonals of either layout show the change in two quadrants.
            let settled = convergence.record(change.max(change_before), change_max);
            change_before = change;
            if settled || convergence.slow > 2 || more == 0 {
                return (sweeps, settled && more > 0);
            }
        }
    }

    /// A wavefront outwards and one back, for the correction where `shifted`; sweeps made, and the change they ended
    /// with.
    fn sweep_both_ways(&mut self, world: &GridWorld, shifted: bool, sweeps_max: u64) -> (u64, f32) {
        let Self { simd, skew, planes, .. } = self;
        let sweeps = sweep_counts(world).around.min(sweeps_max / 2) as usize;
        let leaving = world.rules().leaving;
        let mut change = [0.0_f32; SINGLE_LANES];
        if sweeps > 0 {
            for backwards in [false, true] {
                change = [0.0; SINGLE_LANES];
                planes.relax(*simd, skew, leaving, shifted, Wavefront { sweeps, backwards }, &mut change);
            }
        }
        (2 * sweeps as u64, largest(&change))
    }

    /// Lays the values out along the other kind of diagonals.
    fn flip_layout(&mut self, world: &GridWorld) {
        let Self { simd, skew, planes, values, .. } = self;
        planes.read_values(*simd, skew, world, values);
        skew.flip_j();
        planes.load_values(*simd, skew, world, values);
    }

    /// Sweeps for the correction while that pays; sweeps made, and whether they reached `change_max`.
    fn sweep_shifted(&mut self, world: &GridWorld, change_max: f32, sweeps_max: u64) -> (u64, bool) {
        let Self { simd, skew, planes, .. } = self;
        let leaving = world.rules().leaving;
        let mut convergence = Convergence::default();
        let mut sweeps = 0;
        loop {
            let sweeps_here = sweep_counts(world).next.min(sweeps_max - sweeps) as usize;
            if sweeps_here == 0 {
                return (sweeps, false);
            }
            let wavefront = Wavefront { sweeps: sweeps_here, backwards: false };
            let mut change = [0.0_f32; SINGLE_LANES];
            planes.relax(*simd, skew, leaving, true, wavefront, &mut change);
            sweeps += wavefront.sweeps as u64;
            let settled = convergence.record(largest(&change), change_max);
            if settled || convergence.slow > 1 {
                return (sweeps, settled);
            }
        }
    }
}

/// Whether a goal lies in a corner of the grid, so that changes at it travel one way.
fn is_in_corner(world: &GridWorld, goal: usize) -> bool {
    let (x, y) = (goal % world.width(), goal / world.width());
    x.min(world.width() - 1 - x).max(y.min(world.height() - 1 - y)) <= CORNER
}

/// Whether a goal lies further from every side of the grid than a change at it travels in the first wavefront.
fn is_inside(world: &GridWorld, goal: usize) -> bool {
    let (x, y) = (goal % world.width(), goal / world.width());
    x.min(world.width() - 1 - x).min(y.min(world.height() - 1 - y)) > INSIDE
}

fn sweep_counts(world: &GridWorld) -> SweepCounts {
    if world.nodes() <= SMALL { SWEEPS_SMALL } else { SWEEPS_LARGE }
}

/// How the change falls from wavefront to wavefront.
#[derive(Clone, Copy, Debug, Default)]
struct Convergence {
    wavefronts: usize,
    /// Least change that a wavefront's last sweep ended with.
    least: f32,
    /// Slow wavefronts since it last fell: where sweeps cycle, changes grow and shrink for ever.
    slow: usize,
}

impl Convergence {
    /// Takes in the change that another wavefront ended with; whether it is small enough.
    fn record(&mut self, change: f32, change_max: f32) -> bool {
        let falls = self.wavefronts == 0 || change <= STALL * self.least;
        self.slow = if falls { 0 } else { self.slow + 1 };
        self.least = if self.wavefronts > 0 { change.min(self.least) } else { change };
        self.wavefronts += 1;
        change <= change_max
    }
}

/// One Gauss–Seidel sweep in double precision.
fn sweep_once_in_double(world: &GridWorld, values: &mut [f64], backwards: bool) {
    for index in 0..values.len() {
        let node = if backwards { values.len() - 1 - index } else { index };
        if world.kind(node) == Kind::Free {
            values[node] = backup(world, values, node);
        }
    }
}

/// The value of a free node under its neighbours' values, with the share that stays at the node solved for:
/// V = a + b V is V = a / (1 − b), which keeps the fixed point.
fn backup(world: &GridWorld, values: &[f64], node: usize) -> f64 {
    let rules = world.rules();
    let soil = world.soil(node);
    let (payoff, discount) = (world.payoff(node), soil.discount(rules.discount));
    let around =
        Hop::ALL.map(|hop| (world.neighbour(node, hop)).map(|to| world.afterstate_value(values, to)));
    let value = |hop: Hop| {
        let Scatter { intended, stayed, left, right } = world.scatter(node, hop);
        let mut stays = stayed;
        let mut leaves = 0.0;
        for (probability, towards) in [(intended, hop), (left, hop.left()), (right, hop.right())] {
            match (around[towards as usize], rules.leaving) {
                (Some(landed), _) => leaves += probability * landed,
                (None, Leaving::Stays) => stays += probability,
                (None, Leaving::Loses) => leaves += probability * rules.loss,
            }
        }
        (rules.discount * soil.wait * payoff + discount * (leaves + stays * payoff))
            / (1.0 - discount * stays)
    };
    Hop::ALL.into_iter().map(value).fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_that_grow_and_shrink_for_ever_count_as_slow() {
        let mut convergence = Convergence::default();
        for index in 0..12 {
            assert!(!convergence.record([1.0, 0.5, 0.9, 0.45][index % 4], 1e-9));
        }
        assert!(convergence.slow > 2, "{convergence:?}");
        assert!(!convergence.record(f32::NAN, 1e-9) && convergence.slow > 3, "{convergence:?}");
        assert!(!convergence.record(0.2, 1e-9) && convergence.slow == 0, "{convergence:?}");
    }
}
