//! The correction e that a policy's linear equation asks for, in single precision.
//!
//! e = own + Σ c_k e_k over the four neighbours, solved by Gauss–Seidel sweeps in waves: outwards from a goal in a
//! corner, there and back where it lies elsewhere. Where those converge slowly, because the policy lingers somewhere,
//! BiCGStab (van der Vorst 1992) takes over, preconditioned from the right by a sweep outwards and one back: lingering
//! makes one eigenvalue near 1 for every place that is lingered at, all close together, which a Krylov method removes
//! at once.

use std::cell::Cell;

use crate::simd::{Simd, dispatch};
use crate::skew::{Around, LANES, Lanes, PARTS, Run, Skew, chunk, part};
use crate::sweep::Planes;
use crate::wave::{Wave, largest};

/// The linear solve's additional planes; empty until lingering is met.
#[derive(Clone, Debug, Default)]
pub(crate) struct Krylov {
    residual: Vec<f32>,
    shadow: Vec<f32>,
    direction: Vec<f32>,
    image: Vec<f32>,
    preconditioned: Vec<f32>,
    image_half: Vec<f32>,
    halfway: Vec<f32>,
}

/// Where a linear solve's sweeps go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Course {
    /// All the way from the corner that the goal is in.
    Outwards,
    /// There and back, to reach all that lies around a goal.
    Around,
}

/// How long sweeps go on.
struct Patience {
    /// Sweeps a pass.
    sweeps: usize,
    /// Slow passes, in all, before a Krylov method takes over.
    slow_max: usize,
}

impl Course {
    fn patience(self) -> Patience {
        match self {
            Self::Outwards => Patience { sweeps: 5, slow_max: 0 },
            // What has to turn corners takes some passes before any change gets smaller.
            Self::Around => Patience { sweeps: 4, slow_max: 3 },
        }
    }
}

impl Planes {
    /// Solves for the correction until it changes by no more than `change_max` a sweep, or by no more than
    /// [`REDUCTION`] of its first change; work in updates of nodes, and whether the former was reached.
    pub fn correct(
        &mut self,
        simd: Simd,
        skew: &Skew,
        krylov: &mut Krylov,
        course: Course,
        change_max: f32,
        updates_max: u64,
    ) -> (u64, bool) {
        let nodes = (skew.width * skew.height) as u64;
        let Patience { sweeps, slow_max } = course.patience();
        let there_and_back = course == Course::Around;
        let (mut updates, mut slow) = (0, 0);
        let mut first = 0.0_f32;
        // Changes of the last two passes, the older one first.
        let mut lasts = [f32::INFINITY; 2];
        for pass in 0..PASSES_MAX {
            // Fewer where the budget has no more.
            let sweeps = sweeps.min(((updates_max - updates) / nodes) as usize);
            if sweeps == 0 {
                break;
            }
            let wave = Wave { sweeps, back: there_and_back && pass % 2 == 1 };
            let mut change = [0.0_f32; LANES];
            updates += nodes * sweeps as u64;
            correct(simd, self.unknown.all_mut(), self.ground.all(), skew, wave, &mut change);
            let change = largest(&change);
            if pass == 0 {
                first = change;
            }
            let enough = change_max.max(first * REDUCTION);
            // A pass in one direction tells nothing of the other.
            let (before, both) =
                if there_and_back { (lasts[0], change.max(lasts[1])) } else { (lasts[1], change) };
            if both <= enough {
                return (updates, both <= change_max);
            }
            slow += usize::from(change > SLOW * before);
            if slow > slow_max {
                return (updates + self.krylov(simd, skew, krylov, updates_max - updates), false);
            }
            lasts = [lasts[1], change];
        }
        (updates, false)
    }

    /// BiCGStab for e from 0; the entries beyond the grid are 0 throughout, as their coefficients are.
    fn krylov(&mut self, simd: Simd, skew: &Skew, krylov: &mut Krylov, updates_max: u64) -> u64 {
        let (solution, ground) = (self.unknown.all_mut(), self.ground.all());
        let Krylov { residual, shadow, direction, image, preconditioned, image_half, halfway } = krylov;
        for plane in [&mut *residual, shadow, direction] {
            plane.clear();
            let ground = &ground[..PARTS * solution.len()];
            plane.extend(ground.chunks_exact(PARTS * LANES).flat_map(|parts| &parts[..LANES]));
        }
        for plane in [&mut *image, preconditioned, image_half, halfway] {
            plane.clear();
            plane.resize(solution.len(), 0.0);
        }
        if updates_max < 4 * (skew.width * skew.height) as u64 {
            // The sweeps' correction is better than none.
            return 0;
        }
        solution.fill(0.0);
        let nodes = (skew.width * skew.height) as u64;
        let start = dot(simd, residual, residual);
        let mut rho = start;
        let mut updates = 0;
        for _ in 0..ITERATIONS_MAX {
            if rho == 0.0 || !rho.is_finite() || updates_max - updates < 4 * nodes {
                break;
            }
            outwards(simd, halfway, direction, ground, skew);
            back(simd, preconditioned, image, halfway, ground, skew);
            let alpha = rho / dot(simd, shadow, image);
            axpy(simd, solution, alpha as f32, preconditioned);
            axpy(simd, residual, -alpha as f32, image);
            outwards(simd, halfway, residual, ground, skew);
            back(simd, preconditioned, image_half, halfway, ground, skew);
            let omega = dot(simd, image_half, residual) / dot(simd, image_half, image_half);
            updates += 4 * nodes;
            if !alpha.is_finite() || !omega.is_finite() {
                break;
            }
            axpy(simd, solution, omega as f32, preconditioned);
            axpy(simd, residual, -omega as f32, image_half);
            if dot(simd, residual, residual) <= start * KRYLOV_REDUCTION * KRYLOV_REDUCTION {
                break;
            }
            let rho_next = dot(simd, shadow, residual);
            let beta = rho_next / rho * alpha / omega;
            rho = rho_next;
            // direction = residual + β (direction − ω image)
            turn(simd, direction, residual, image, beta as f32, omega as f32);
        }
        if solution.iter().any(|e| !e.is_finite()) {
            solution.fill(0.0);
        }
        updates
    }
}

/// Most passes of a linear solve.
const PASSES_MAX: usize = 12;
/// Share of what flows back outwards that is anticipated.
const OVER: f32 = 0.7;
/// What counts at most as flowing back outwards: where the best hop leads outwards, all of it would.
const OUTER_MAX: f32 = 0.15;
/// Reduction of the change at which a linear solve by sweeps ends.
const REDUCTION: f32 = 1e-5;
/// Reduction from pass to pass in one direction that counts as slow.
const SLOW: f32 = 0.75;
/// Most iterations of BiCGStab in one round.
const ITERATIONS_MAX: usize = 30;
/// Reduction of the residual's norm at which BiCGStab ends.
const KRYLOV_REDUCTION: f64 = 0.01;

dispatch! {
    /// Updates the corrections in a wave; the largest change of its last sweep, lane by lane, goes into `change`.
    fn correct(unknown: &mut [f32], ground: &[f32], skew: &Skew, wave: Wave, change: &mut Lanes) = correct_lanes
}

#[inline(always)]
fn correct_lanes(unknown: &mut [f32], ground: &[f32], skew: &Skew, wave: Wave, change: &mut Lanes) {
    let unknown = Cell::from_mut(unknown).as_slice_of_cells();
    let runs = skew.runs();
    let diagonals = runs.len();
    for step in 0..wave.steps(diagonals) {
        for sweep in wave.at(diagonals, step) {
            let run = &runs[wave.diagonal(diagonals, step, sweep)];
            if sweep + 1 == wave.sweeps {
                correct_run::<true>(unknown, ground, run, change);
            } else {
                correct_run::<false>(unknown, ground, run, change);
            }
        }
    }
}

/// Updates a diagonal; the largest change goes into `change` in the `LAST` sweep.
#[inline(always)]
fn correct_run<const LAST: bool>(unknown: &[Cell<f32>], ground: &[f32], run: &Run, change: &mut Lanes) {
    let around = Around::new(unknown, run);
    let ground = &ground[part(run.first(), 0)..].as_chunks::<{ PARTS * LANES }>().0[..around.chunks()];
    for (index, parts) in ground.iter().enumerate() {
        let [low_i, low_j, high_i, high_j, old] = around.chunk(index);
        let (own, c_low_i, c_low_j) = (chunk(parts, 0), chunk(parts, LANES), chunk(parts, 2 * LANES));
        let (c_i, c_j) = (chunk(parts, 3 * LANES), chunk(parts, 4 * LANES));
        let mut new = [0.0; LANES];
        for lane in 0..LANES {
            let inner = c_low_i[lane] * low_i[lane] + c_low_j[lane] * low_j[lane];
            new[lane] = own[lane] + (inner + (c_i[lane] * high_i[lane] + c_j[lane] * high_j[lane]));
        }
        let mut next = [0.0; LANES];
        for lane in 0..LANES {
            let outer = c_i[lane] + c_j[lane];
            let anticipated = if outer < OUTER_MAX { outer } else { OUTER_MAX };
            next[lane] = new[lane] + OVER * anticipated * (new[lane] - old[lane]);
        }
        if LAST {
            for lane in 0..LANES {
                let moved = (new[lane] - old[lane]).abs();
                change[lane] = if moved > change[lane] { moved } else { change[lane] };
            }
        }
        around.set(index, &next);
    }
}

dispatch! {
    /// Half the preconditioner, (I − L) e = p: a sweep outwards, L the two landings that lie inwards.
    fn outwards(e: &mut [f32], p: &[f32], ground: &[f32], skew: &Skew) = outwards_lanes
}

#[inline(always)]
fn outwards_lanes(e: &mut [f32], p: &[f32], ground: &[f32], skew: &Skew) {
    for run in skew.runs() {
        let [low_i, low_j, _, _] = run.steps();
        for at in (run.first()..run.first() + run.nodes()).step_by(LANES) {
            let p = chunk(p, at);
            let inner = halves(e, at, [low_i, low_j], ground, 1);
            let mut new = [0.0_f32; LANES];
            for lane in 0..LANES {
                new[lane] = p[lane] + inner[lane];
            }
            e[at..at + LANES].copy_from_slice(&new);
        }
    }
}

dispatch! {
    /// The other half, (I − U) f = e: a sweep back, U the two landings that lie outwards; and with it the
    /// image of f, (I − L − U) f = e − L f, diagonal by diagonal as f becomes known (Eisenstat 1981).
    fn back(f: &mut [f32], image: &mut [f32], e: &[f32], ground: &[f32], skew: &Skew) = back_lanes
}

#[inline(always)]
fn back_lanes(f: &mut [f32], image: &mut [f32], e: &[f32], ground: &[f32], skew: &Skew) {
    let runs = skew.runs();
    for known in (0..=runs.len()).rev() {
        // At the end there is nothing left to know, but one image to take.
        if known > 0 {
            let run = &runs[known - 1];
            let [_, _, high_i, high_j] = run.steps();
            for at in (run.first()..run.first() + run.nodes()).step_by(LANES) {
                let e = chunk(e, at);
                let outer = halves(f, at, [high_i, high_j], ground, 3);
                let mut new = [0.0_f32; LANES];
                for lane in 0..LANES {
                    new[lane] = e[lane] + outer[lane];
                }
                f[at..at + LANES].copy_from_slice(&new);
            }
        }
        if known < runs.len() {
            let run = &runs[known];
            let [low_i, low_j, _, _] = run.steps();
            for at in (run.first()..run.first() + run.nodes()).step_by(LANES) {
                let e = chunk(e, at);
                let inner = halves(f, at, [low_i, low_j], ground, 1);
                let mut new = [0.0_f32; LANES];
                for lane in 0..LANES {
                    new[lane] = e[lane] - inner[lane];
                }
                image[at..at + LANES].copy_from_slice(&new);
            }
        }
    }
}

/// Two of the four terms of Σ c e, those of the coefficients from `part` on.
#[inline(always)]
fn halves(e: &[f32], at: usize, steps: [isize; 2], ground: &[f32], first: usize) -> Lanes {
    let (a, b) = (chunk(e, at.wrapping_add_signed(steps[0])), chunk(e, at.wrapping_add_signed(steps[1])));
    let (c_a, c_b) = (chunk(ground, part(at, first)), chunk(ground, part(at, first + 1)));
    let mut sum = [0.0_f32; LANES];
    for lane in 0..LANES {
        sum[lane] = c_a[lane] * a[lane] + c_b[lane] * b[lane];
    }
    sum
}

dispatch! {
    /// Σ a b, summed lane by lane in double precision.
    fn dot(a: &[f32], b: &[f32]) -> f64 = dot_lanes
}

#[inline(always)]
fn dot_lanes(a: &[f32], b: &[f32]) -> f64 {
    let mut sum = [0.0_f64; LANES];
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        for lane in 0..LANES {
            sum[lane] += f64::from(a[lane]) * f64::from(b[lane]);
        }
    }
    sum.into_iter().sum()
}

dispatch! {
    /// y += a x.
    fn axpy(y: &mut [f32], a: f32, x: &[f32]) = axpy_lanes
}

#[inline(always)]
fn axpy_lanes(y: &mut [f32], a: f32, x: &[f32]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

dispatch! {
    /// p = r + β (p − ω v).
    fn turn(p: &mut [f32], r: &[f32], v: &[f32], beta: f32, omega: f32) = turn_lanes
}

#[inline(always)]
fn turn_lanes(p: &mut [f32], r: &[f32], v: &[f32], beta: f32, omega: f32) {
    for ((p, r), v) in p.iter_mut().zip(r).zip(v) {
        *p = r + beta * (*p - omega * v);
    }
}
