//! The solver: values from nothing, to a certified bound or to the end of the budget.
//!
//! 1. **Start** from below: every free node has the worst value there can be, min r / (1 − γ) or the loss.
//! 2. **Sweep** Bellman's operator in single precision (`sweep`), in waves that leave the goal (`wave`),
//!    as long as that pays: on most worlds nearly to the last bits of single precision, on worlds where
//!    lingering beats the goal until the change stalls. A wave leaves a corner. Where the goal is not in one, waves
//!    go there and back, and the diagonals are turned between them, so that news of the goal crosses each of the
//!    four quadrants around it in one sweep.
//! 3. **Survey** in double precision (`survey`): what each hop is short of at each node.
//! 4. **Correct** the values in single precision, by sweeps of the same operator shifted to where they are; or,
//!    where there is somewhere to linger, and first on small worlds, by the best hops' linear equation alone
//!    (`correct`), which sweeps solve, there and back around a goal inside, and a Krylov method where they are slow;
//!    then on to 3, or, while the residual is above what single precision can tell, to 2.
//! 5. **Measure** (`measure`) the values as they are handed out, straight from the definition, whenever they are
//!    expected to be good enough, or the budget ends: the certificate.
//!
//! Should a round of 3 and 4 not bring the residual down, sweeps in double precision, which contract by γ
//! whatever happens, take over.

use crate::certificate::rounding;
use crate::correct::{Course, Krylov};
use crate::extent::Extent;
use crate::simd::Simd;
use crate::skew::{LANES, Skew};
use crate::sweep::Planes;
use crate::wave::{Wave, largest};
use crate::{Certificate, Hop, Kind, Leaving, Scatter, World, measure, pages};

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
/// Change of a worth, relative to the largest worth there may be, at which sweeps of worths end: some 250 units
/// in the last place, so that corrections are small enough for single precision to hold them to the bound.
const SINGLE: f64 = 1.5e-5;
/// The same on small worlds without places to linger at, where the linear equation of the best hops takes over.
const SINGLE_SMALL: f64 = 1.5e-4;
/// Residuals above so many times that are swept down before they are corrected.
const ROUGH: f64 = 10.0;
/// A correction that settles, from a residual of at most so many times that, is expected to be the last.
const EXPECTED: f64 = 1e4;
/// Change, relative to the residual asked for, at which a correction has settled.
const SETTLED: f64 = 0.5;
/// Reduction of the change from pass to pass below which sweeping no longer pays.
const STALL: f32 = 0.7;
/// Waves between two surveys where there is somewhere to linger, every other one back towards the goal.
const WAVES: usize = 8;

/// How many sweeps a wave has.
struct Waves {
    /// The first.
    first: u64,
    /// Each after it.
    next: u64,
    /// Each after it where there is somewhere to linger.
    slow: u64,
    /// Each around a goal inside the grid.
    around: u64,
}

/// Where memory is what they wait for.
const WAVES_LARGE: Waves = Waves { first: 12, next: 8, slow: 8, around: 12 };
/// On small worlds, which lie in the nearest caches.
const WAVES_SMALL: Waves = Waves { first: 10, next: 3, slow: 4, around: 5 };
/// Sweeps of the first wave where there is somewhere to linger.
const FIRST_SLOW: u64 = 12;
/// Nodes between a goal and the nearest side of the grid beyond which it counts as inside.
const INSIDE: usize = 12;
/// Nodes between a goal and the sides of a corner that it counts as being in.
const CORNER: usize = 3;
/// Reduction of the residual over two turns above which there is somewhere to linger.
const SLOW_TURNS: f64 = 0.1;
/// Nodes of a small world.
const SMALL: usize = 4096;

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

    /// The same with a second thread in waves over large worlds, if `threads` is more than one. The values are the
    /// same bit for bit.
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
    pub fn solve(&mut self, world: &World, effort: &Effort) -> Solution {
        self.solve_with(world, effort, &|| ())
    }

    /// [`Solver::solve`], calling `pulse` whenever some more of the work is done: every few dozen sweeps.
    pub fn solve_with(&mut self, world: &World, effort: &Effort, pulse: &dyn Fn()) -> Solution {
        let rules = world.rules();
        let extent = Extent::of(self.simd, world);
        let worth_max = extent.worth_max(rules);
        let discount = rules.discount;
        // Below this the sweeps' own rounding may keep the residual from falling.
        let limit = 2.0 * rounding(2.0 * worth_max) / (1.0 - discount);
        let error_max = effort.error_max.max(limit);
        let residual_max = error_max * (1.0 - discount) - rounding(2.0 * worth_max);
        let nodes = world.nodes() as u64;
        let updates_max = effort.sweeps_max.saturating_mul(nodes);
        let small = world.nodes() <= SMALL;

        if self.skew.fit(world, extent.best_goal) {
            self.planes.reset(self.skew.len);
            self.values = Vec::new();
            self.values = pages::filled(0.0, world.nodes());
        }
        let worst = extent.value_min(rules);
        self.planes.start(self.simd, &self.skew, world, worst);
        let (mut updates, mut surveys, mut stalls) = (0, 0, 0);
        let [mut residual, mut last] = [f64::INFINITY; 2];
        // Whether the values are expected to be good enough.
        let mut expected = false;
        // Whether sweeps are slow, because there is somewhere to linger.
        let mut lingers = false;
        // Whether the correction is the best hops' alone.
        let mut linear = false;
        // Whether single precision has nothing to offer any more.
        let mut plain = worth_max > SINGLE_MAX;
        // Whether the goal lies so far inside that diagonals of one kind lead away from it in two quadrants only.
        let inner = extent.best_goal.is_some_and(|goal| inner(world, goal));
        // Where the sweeps of a linear correction go.
        let cornered = extent.best_goal.is_none_or(|goal| cornered(world, goal));
        let course = if cornered { Course::Outwards } else { Course::Around };
        // Change of the last turn.
        let mut turned = f32::INFINITY;
        loop {
            let single = if small && !lingers { SINGLE_SMALL } else { SINGLE };
            let single = (single * worth_max).max(residual_max);
            pulse();
            if !plain && !expected && residual > ROUGH * single {
                let left = updates_max.saturating_sub(updates) / nodes;
                let (sweeps, settled) = if inner && surveys == 0 {
                    self.sweep_around(world, single as f32, left, pulse)
                } else {
                    self.sweep(world, single as f32, left, surveys == 0)
                };
                updates += sweeps * nodes;
                lingers |= !settled;
            }
            pulse();
            let left = updates_max.saturating_sub(updates);
            // Not a sweep is left: the next survey is the last.
            let out = left < nodes;
            let mut measured = f64::INFINITY;
            if !plain && !expected && !out {
                let Self { planes, skew, simd, .. } = self;
                let best = lingers || (surveys == 0 && small);
                if linear && !best {
                    planes.resume(*simd, skew, world);
                }
                linear = best;
                measured = if linear {
                    planes.survey_best(*simd, skew, world)
                } else {
                    planes.survey(*simd, skew, world)
                };
                surveys += 1;
            }
            if plain || expected || out || measured <= residual_max {
                let Self { planes, skew, values, simd, .. } = self;
                planes.take_out(*simd, skew, world, values);
                let findings = measure::run(*simd, world, values);
                surveys += 1;
                let certificate = Certificate::new(findings.residual, discount, findings.worth_max);
                let solved = certificate.error_bound <= error_max;
                if solved || out {
                    let status = if solved { Status::Solved } else { Status::Cut };
                    return Solution { certificate, status, sweeps: updates.div_ceil(nodes), surveys };
                }
                if expected {
                    // Close, but not there: survey again, for the correction this time.
                    expected = false;
                    continue;
                }
                measured = findings.residual;
            }
            stalls = if measured > 0.5 * residual { stalls + 1 } else { 0 };
            let before = std::mem::replace(&mut last, residual);
            residual = measured;
            plain |= surveys >= SURVEYS_MAX;
            let change_max = (SETTLED * residual_max) as f32;
            let Self { planes, skew, krylov, values, simd } = self;
            if plain || stalls >= STALLS_MAX || !measured.is_finite() {
                let sweeps = PLAIN_SWEEPS.min(left / nodes);
                planes.take_out(*simd, skew, world, values);
                // From what is no number nothing contracts.
                values.iter_mut().filter(|value| !value.is_finite()).for_each(|value| *value = worst);
                for sweep in 0..sweeps {
                    sweep_plainly(world, values, sweep % 2 == 1);
                    pulse();
                }
                planes.lay(*simd, skew, world, values);
                linear = false;
                updates += sweeps * nodes;
                stalls = 0;
            } else if linear {
                let (corrected, settled) =
                    planes.correct(*simd, skew, krylov, course, change_max, left.saturating_mul(4));
                updates += corrected.div_ceil(4);
                expected = settled && residual < EXPECTED * single;
                planes.add(*simd);
            } else if inner {
                let (sweeps, change) = self.sweep_there_and_back(world, true, left / nodes);
                updates += sweeps * nodes;
                lingers |= measured > SLOW_TURNS * before;
                expected = sweeps > 0 && change.max(turned) <= change_max;
                turned = change;
                self.planes.add(self.simd);
                self.turn(world);
            } else {
                let (sweeps, settled) = self.sweep_shifted(world, change_max, left / nodes);
                updates += sweeps * nodes;
                lingers |= !settled;
                expected = settled;
                self.planes.add(self.simd);
            }
        }
    }

    /// Sweeps in single precision while that pays; sweeps made, and whether they reached `change_max`.
    fn sweep(&mut self, world: &World, change_max: f32, sweeps_max: u64, first: bool) -> (u64, bool) {
        let Self { simd, skew, planes, .. } = self;
        if !first {
            planes.resume(*simd, skew, world);
        }
        let leaving = world.rules().leaving;
        let mut progress = Progress::default();
        let mut sweeps = 0;
        loop {
            let back = !first && progress.waves % 2 == 1;
            let wanted = if back {
                1
            } else {
                match (first, progress.waves) {
                    (true, 0) => waves(world).first,
                    (true, _) => waves(world).next,
                    (false, 0) => FIRST_SLOW,
                    (false, _) => waves(world).slow,
                }
            };
            let wave = Wave { sweeps: wanted.min(sweeps_max - sweeps) as usize, back };
            let mut change = [0.0_f32; LANES];
            if wave.sweeps > 0 {
                planes.relax(*simd, skew, leaving, false, wave, &mut change);
            }
            sweeps += wave.sweeps as u64;
            let settled = progress.take(largest(&change), change_max);
            let stalled = if first { progress.slow > 1 } else { progress.waves == WAVES };
            if settled || stalled || wave.sweeps == 0 {
                planes.adopt(*simd, skew);
                return (sweeps, settled && wave.sweeps > 0);
            }
        }
    }

    /// Sweeps in single precision around a goal inside the grid while that pays; sweeps made, and whether they
    /// reached `change_max`.
    fn sweep_around(
        &mut self,
        world: &World,
        change_max: f32,
        sweeps_max: u64,
        pulse: &dyn Fn(),
    ) -> (u64, bool) {
        let mut progress = Progress::default();
        let mut sweeps = 0;
        let mut turned = f32::INFINITY;
        loop {
            let (more, change) = self.sweep_there_and_back(world, false, sweeps_max - sweeps);
            sweeps += more;
            self.planes.adopt(self.simd, &self.skew);
            self.turn(world);
            pulse();
            // Of the two kinds of diagonals each tells of its own quadrants.
            let settled = progress.take(change.max(turned), change_max);
            turned = change;
            if settled || progress.slow > 2 || more == 0 {
                return (sweeps, settled && more > 0);
            }
        }
    }

    /// A wave there and one back, for the correction where `shifted`; sweeps made, and the change they ended with.
    fn sweep_there_and_back(&mut self, world: &World, shifted: bool, sweeps_max: u64) -> (u64, f32) {
        let Self { simd, skew, planes, .. } = self;
        let sweeps = waves(world).around.min(sweeps_max / 2) as usize;
        let mut change = [0.0_f32; LANES];
        if sweeps > 0 {
            for back in [false, true] {
                change = [0.0; LANES];
                planes.relax(*simd, skew, world.rules().leaving, shifted, Wave { sweeps, back }, &mut change);
            }
        }
        (2 * sweeps as u64, largest(&change))
    }

    /// Lays the worths out across.
    fn turn(&mut self, world: &World) {
        let Self { simd, skew, planes, values, .. } = self;
        planes.take_out(*simd, skew, world, values);
        skew.turn();
        planes.lay(*simd, skew, world, values);
    }

    /// Sweeps for the correction while that pays; sweeps made, and whether they reached `change_max`.
    fn sweep_shifted(&mut self, world: &World, change_max: f32, sweeps_max: u64) -> (u64, bool) {
        let Self { simd, skew, planes, .. } = self;
        let leaving = world.rules().leaving;
        let mut progress = Progress::default();
        let mut sweeps = 0;
        loop {
            let wave = Wave { sweeps: waves(world).next.min(sweeps_max - sweeps) as usize, back: false };
            if wave.sweeps == 0 {
                return (sweeps, false);
            }
            let mut change = [0.0_f32; LANES];
            planes.relax(*simd, skew, leaving, true, wave, &mut change);
            sweeps += wave.sweeps as u64;
            let settled = progress.take(largest(&change), change_max);
            if settled || progress.slow > 1 {
                return (sweeps, settled);
            }
        }
    }
}

/// Whether a goal lies in a corner of the grid, so that news of it travels one way.
fn cornered(world: &World, goal: usize) -> bool {
    let (x, y) = (goal % world.width(), goal / world.width());
    x.min(world.width() - 1 - x).max(y.min(world.height() - 1 - y)) <= CORNER
}

/// Whether a goal lies further from every side of the grid than a first wave's sweeps carry its news.
fn inner(world: &World, goal: usize) -> bool {
    let (x, y) = (goal % world.width(), goal / world.width());
    x.min(world.width() - 1 - x).min(y.min(world.height() - 1 - y)) > INSIDE
}

/// The waves over a world of that size.
fn waves(world: &World) -> Waves {
    if world.nodes() <= SMALL { WAVES_SMALL } else { WAVES_LARGE }
}

/// How sweeps come along.
#[derive(Clone, Copy, Debug, Default)]
struct Progress {
    /// Waves made.
    waves: usize,
    /// Least change that a wave's last sweep ended with.
    least: f32,
    /// Slow waves since: where sweeps go round in circles, changes grow and shrink for ever.
    slow: usize,
}

impl Progress {
    /// Takes in the change that another wave ended with; whether it is small enough.
    fn take(&mut self, change: f32, change_max: f32) -> bool {
        let falls = self.waves == 0 || change <= STALL * self.least;
        self.slow = if falls { 0 } else { self.slow + 1 };
        self.least = if self.waves > 0 { change.min(self.least) } else { change };
        self.waves += 1;
        change <= change_max
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_that_grow_and_shrink_for_ever_count_as_slow() {
        let mut progress = Progress::default();
        for wave in 0..12 {
            assert!(!progress.take([1.0, 0.5, 0.9, 0.45][wave % 4], 1e-9));
        }
        assert!(progress.slow > 2, "{progress:?}");
        assert!(!progress.take(f32::NAN, 1e-9) && progress.slow > 3, "{progress:?}");
        assert!(!progress.take(0.2, 1e-9) && progress.slow == 0, "{progress:?}");
    }
}
