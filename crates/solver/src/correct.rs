//! The correction e that a policy's linear equation asks for, in single precision.
//!
//! e = own + Σ c_k e_k over the four neighbours, solved by Gauss–Seidel sweeps in windows of diagonals.
//! Where those converge slowly, because the policy lingers somewhere, BiCGStab (van der Vorst 1992) takes
//! over, preconditioned from the right by a sweep outwards and one back: lingering makes one eigenvalue
//! near 1 for every place that is lingered at, all close together, which a Krylov method removes at once.

use std::ops::Range;

use crate::World;
use crate::simd::{Simd, dispatch};
use crate::skew::{Ground, LANES, Skew, chunk};
use crate::survey::Row;
use crate::sweep::Planes;
use crate::window::{Diagonals, Window, largest};

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

impl Planes {
    /// Begins a policy's equation: zeros wherever no row will be filled in.
    pub fn begin(&mut self, skew: &Skew) {
        self.unknown.fill(0.0);
        // The halo may hold worths.
        for diagonal in skew.diagonals() {
            let (first, nodes) = skew.run(diagonal);
            for (at, step) in skew.rim(diagonal, first, first + nodes - 1, skew.steps(diagonal)) {
                if step != 0 {
                    self.set(at.wrapping_add_signed(step), [0.0; 5]);
                }
            }
        }
    }

    /// Fills in one row of a panel of a policy's equation: coefficients in the order of [`Skew::steps`].
    pub fn load_row(&mut self, skew: &Skew, columns: Range<usize>, y: usize, row: &Row) {
        let [north, east, south, west] = &row.landings;
        let (low_i, high_i) = if skew.flip[0] { (east, west) } else { (west, east) };
        let (low_j, high_j) = if skew.flip[1] { (north, south) } else { (south, north) };
        let mut entries = skew.entries(columns.clone(), y);
        for x in 0..columns.len() {
            let at = entries.next().expect("an entry a node");
            self.set(at, [row.own[x], low_i[x], low_j[x], high_i[x], high_j[x]]);
        }
    }

    /// Adds the corrections to the values.
    pub fn add_to(&self, skew: &Skew, world: &World, values: &mut [f64]) {
        skew.visit(|columns, y| {
            let values = &mut values[y * skew.width..][columns.clone()];
            let classes = &world.row(y).3[columns.clone()];
            for ((value, class), at) in values.iter_mut().zip(classes).zip(skew.entries(columns, y)) {
                let correction = f64::from(self.unknown[at]);
                *value += if class.is_free() { correction } else { 0.0 };
            }
        });
    }

    /// Solves for the correction until it changes by no more than `change_max` a sweep, or by no more than
    /// [`REDUCTION`] of its first change; work in updates of nodes, and whether the former was reached.
    pub fn correct(
        &mut self,
        simd: Simd,
        skew: &Skew,
        krylov: &mut Krylov,
        change_max: f32,
        updates_max: u64,
    ) -> (u64, bool) {
        let nodes = (skew.width * skew.height) as u64;
        let mut updates = 0;
        let mut first = 0.0_f32;
        let mut last = f32::INFINITY;
        let window = Window::default();
        for pass in 0..PASSES_MAX {
            if updates_max - updates < nodes * window.visits() {
                break;
            }
            let mut change = [0.0_f32; LANES];
            updates += nodes * window.visits();
            window.pass(skew.diagonals(), |diagonals| {
                correct(simd, &mut self.unknown, &self.ground, skew, diagonals, &mut change);
            });
            let change = largest(&change);
            if pass == 0 {
                first = change;
            }
            if change <= change_max.max(first * REDUCTION) {
                return (updates, change <= change_max);
            }
            if pass > 0 && change > SLOW * last {
                return (updates + self.krylov(simd, skew, krylov, updates_max - updates), false);
            }
            last = change;
        }
        (updates, false)
    }

    /// BiCGStab for e from 0; the entries beyond the grid are 0 throughout, as their coefficients are.
    fn krylov(&mut self, simd: Simd, skew: &Skew, krylov: &mut Krylov, updates_max: u64) -> u64 {
        let Self { unknown: solution, ground } = self;
        let Krylov { residual, shadow, direction, image, preconditioned, image_half, halfway } = krylov;
        for plane in [&mut *residual, shadow, direction] {
            plane.clear();
            plane.extend(ground.iter().flat_map(|ground| ground.0[0]));
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
/// Reduction of the change at which a linear solve by sweeps ends.
const REDUCTION: f32 = 1e-4;
/// Reduction from pass to pass that counts as slow.
const SLOW: f32 = 0.75;
/// Most iterations of BiCGStab in one round.
const ITERATIONS_MAX: usize = 30;
/// Reduction of the residual's norm at which BiCGStab ends.
const KRYLOV_REDUCTION: f64 = 0.01;

dispatch! {
    /// Updates the corrections of some diagonals; the largest change, lane by lane, goes into `change` for
    /// diagonals that the window leaves behind.
    fn correct(
        unknown: &mut [f32], ground: &[Ground], skew: &Skew, diagonals: Diagonals,
        change: &mut [f32; LANES],
    ) = correct_lanes
}

#[inline(always)]
fn correct_lanes(
    unknown: &mut [f32],
    ground: &[Ground],
    skew: &Skew,
    diagonals: Diagonals,
    change: &mut [f32; LANES],
) {
    for index in 0..diagonals.len() {
        let diagonal = diagonals.at(index);
        let (first, nodes) = skew.run(diagonal);
        let steps = skew.steps(diagonal);
        let counts = diagonal < diagonals.leaves;
        for at in (first..first + nodes).step_by(LANES) {
            let new = landed(unknown, &ground[at / LANES], at, steps);
            if counts {
                let old = chunk(unknown, at);
                for lane in 0..LANES {
                    let moved = (new[lane] - old[lane]).abs();
                    change[lane] = if moved > change[lane] { moved } else { change[lane] };
                }
            }
            unknown[at..at + LANES].copy_from_slice(&new);
        }
    }
}

/// own + Σ c e over the neighbours.
#[inline(always)]
fn landed(e: &[f32], ground: &Ground, at: usize, steps: [isize; 4]) -> [f32; LANES] {
    let [low_i, low_j, high_i, high_j] = steps;
    let inner = halves(e, at, [low_i, low_j], ground, 1);
    let outer = halves(e, at, [high_i, high_j], ground, 3);
    let mut sum = [0.0_f32; LANES];
    for lane in 0..LANES {
        sum[lane] = ground.0[0][lane] + (inner[lane] + outer[lane]);
    }
    sum
}

dispatch! {
    /// Half the preconditioner, (I − L) e = p: a sweep outwards, L the two landings that lie inwards.
    fn outwards(e: &mut [f32], p: &[f32], ground: &[Ground], skew: &Skew) = outwards_lanes
}

#[inline(always)]
fn outwards_lanes(e: &mut [f32], p: &[f32], ground: &[Ground], skew: &Skew) {
    for diagonal in skew.diagonals() {
        let (first, nodes) = skew.run(diagonal);
        let [low_i, low_j, _, _] = skew.steps(diagonal);
        for at in (first..first + nodes).step_by(LANES) {
            let p = chunk(p, at);
            let inner = halves(e, at, [low_i, low_j], &ground[at / LANES], 1);
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
    fn back(f: &mut [f32], image: &mut [f32], e: &[f32], ground: &[Ground], skew: &Skew) = back_lanes
}

#[inline(always)]
fn back_lanes(f: &mut [f32], image: &mut [f32], e: &[f32], ground: &[Ground], skew: &Skew) {
    let Range { start, end } = skew.diagonals();
    for index in 0..=end - start {
        // At the end there is nothing left to know, but one image to take.
        if index < end - start {
            let diagonal = end - 1 - index;
            let (first, nodes) = skew.run(diagonal);
            let [_, _, high_i, high_j] = skew.steps(diagonal);
            for at in (first..first + nodes).step_by(LANES) {
                let e = chunk(e, at);
                let outer = halves(f, at, [high_i, high_j], &ground[at / LANES], 3);
                let mut new = [0.0_f32; LANES];
                for lane in 0..LANES {
                    new[lane] = e[lane] + outer[lane];
                }
                f[at..at + LANES].copy_from_slice(&new);
            }
        }
        if index > 0 {
            let diagonal = end - index;
            let (first, nodes) = skew.run(diagonal);
            let [low_i, low_j, _, _] = skew.steps(diagonal);
            for at in (first..first + nodes).step_by(LANES) {
                let e = chunk(e, at);
                let inner = halves(f, at, [low_i, low_j], &ground[at / LANES], 1);
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
fn halves(e: &[f32], at: usize, steps: [isize; 2], ground: &Ground, part: usize) -> [f32; LANES] {
    let (a, b) = (chunk(e, at.wrapping_add_signed(steps[0])), chunk(e, at.wrapping_add_signed(steps[1])));
    let (c_a, c_b) = (&ground.0[part], &ground.0[part + 1]);
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
