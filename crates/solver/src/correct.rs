//! The correction e that a policy's linear equation asks for, in single precision.
//!
//! e = own + Σ c_k e_k over the four neighbours, solved by Gauss–Seidel sweeps in windows of diagonals.
//! Where those converge slowly, because the policy lingers somewhere, BiCGStab (van der Vorst 1992) takes
//! over, preconditioned from the right by a sweep outwards and one back: lingering makes one eigenvalue
//! near 1 for every place that is lingered at, all close together, which a Krylov method removes at once.

use std::ops::Range;

use crate::World;
use crate::simd::{Simd, dispatch};
use crate::skew::{LANES, Skew, chunk};
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
}

impl Planes {
    /// Fills in one row of a panel of a policy's equation: coefficients in the order of [`Skew::steps`].
    pub fn load_row(&mut self, skew: &Skew, columns: Range<usize>, y: usize, row: &Row) {
        let [north, east, south, west] = &row.landings;
        let (low_i, high_i) = if skew.flip[0] { (east, west) } else { (west, east) };
        let (low_j, high_j) = if skew.flip[1] { (north, south) } else { (south, north) };
        let Self { own, coefficients: [c_low_i, c_low_j, c_high_i, c_high_j], .. } = self;
        let mut entries = skew.entries(columns.clone(), y);
        for x in 0..columns.len() {
            let at = entries.next().expect("an entry a node");
            own[at] = row.own[x];
            c_low_i[at] = low_i[x];
            c_low_j[at] = low_j[x];
            c_high_i[at] = high_i[x];
            c_high_j[at] = high_j[x];
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
    pub fn correct(&mut self, simd: Simd, skew: &Skew, krylov: &mut Krylov, change_max: f32) -> (u64, bool) {
        let nodes = (skew.width * skew.height) as u64;
        let mut updates = 0;
        let mut first = 0.0_f32;
        let mut last = f32::INFINITY;
        let window = Window::default();
        for pass in 0..PASSES_MAX {
            let mut change = [0.0_f32; LANES];
            updates += nodes * window.visits();
            window.pass(skew.diagonals(), |diagonals| {
                correct(simd, &mut self.unknown, &self.own, &self.coefficients, skew, diagonals, &mut change);
            });
            let change = largest(&change);
            if pass == 0 {
                first = change;
            }
            if change <= change_max.max(first * REDUCTION) {
                return (updates, change <= change_max);
            }
            if pass > 0 && change > SLOW * last {
                return (updates + self.krylov(simd, skew, krylov), false);
            }
            last = change;
        }
        (updates, false)
    }

    /// BiCGStab for e from 0; the entries beyond the grid are 0 throughout, as their coefficients are.
    fn krylov(&mut self, simd: Simd, skew: &Skew, krylov: &mut Krylov) -> u64 {
        let Self { unknown: solution, own, coefficients } = self;
        let Krylov { residual, shadow, direction, image, preconditioned, image_half } = krylov;
        for plane in [&mut *residual, shadow, direction] {
            plane.clear();
            plane.extend_from_slice(own);
        }
        for plane in [&mut *image, preconditioned, image_half] {
            plane.clear();
            plane.resize(own.len(), 0.0);
        }
        solution.fill(0.0);
        let precondition = |of: &[f32], into: &mut [f32]| {
            into.fill(0.0);
            let mut ignored = [0.0; LANES];
            for back in [false, true] {
                let diagonals = Diagonals::all(skew.diagonals(), back);
                correct(simd, into, of, coefficients, skew, diagonals, &mut ignored);
            }
        };
        let apply = |to: &[f32], into: &mut [f32]| apply(simd, into, to, coefficients, skew);
        let nodes = (skew.width * skew.height) as u64;
        let start = dot(simd, residual, residual);
        let mut rho = start;
        let mut updates = 0;
        for _ in 0..ITERATIONS_MAX {
            if rho == 0.0 || !rho.is_finite() {
                break;
            }
            precondition(direction, preconditioned);
            apply(preconditioned, image);
            let alpha = rho / dot(simd, shadow, image);
            axpy(simd, solution, alpha as f32, preconditioned);
            axpy(simd, residual, -alpha as f32, image);
            precondition(residual, preconditioned);
            apply(preconditioned, image_half);
            let omega = dot(simd, image_half, residual) / dot(simd, image_half, image_half);
            updates += 6 * nodes;
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
const SLOW: f32 = 0.5;
/// Most iterations of BiCGStab in one round.
const ITERATIONS_MAX: usize = 12;
/// Reduction of the residual's norm at which BiCGStab ends.
const KRYLOV_REDUCTION: f64 = 0.03;

dispatch! {
    /// Updates the corrections of some diagonals; the largest change, lane by lane, goes into `change` for
    /// diagonals that the window leaves behind.
    fn correct(
        unknown: &mut [f32], own: &[f32], coefficients: &[Vec<f32>; 4], skew: &Skew, diagonals: Diagonals,
        change: &mut [f32; LANES],
    ) = correct_lanes
}

#[inline(always)]
fn correct_lanes(
    unknown: &mut [f32],
    own: &[f32],
    coefficients: &[Vec<f32>; 4],
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
            let new = landed(unknown, own, coefficients, at, steps, 1.0);
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

/// own + sign · Σ c e over the neighbours.
#[inline(always)]
fn landed(
    e: &[f32],
    own: &[f32],
    coefficients: &[Vec<f32>; 4],
    at: usize,
    steps: [isize; 4],
    sign: f32,
) -> [f32; LANES] {
    let mut sum = [0.0_f32; LANES];
    for side in 0..4 {
        let (e, c) = (chunk(e, at.wrapping_add_signed(steps[side])), chunk(&coefficients[side], at));
        for lane in 0..LANES {
            sum[lane] += c[lane] * e[lane];
        }
    }
    let own = chunk(own, at);
    for lane in 0..LANES {
        sum[lane] = own[lane] + sign * sum[lane];
    }
    sum
}

dispatch! {
    /// e − Σ c e over the neighbours.
    fn apply(into: &mut [f32], e: &[f32], coefficients: &[Vec<f32>; 4], skew: &Skew) = apply_lanes
}

#[inline(always)]
fn apply_lanes(into: &mut [f32], e: &[f32], coefficients: &[Vec<f32>; 4], skew: &Skew) {
    for diagonal in skew.diagonals() {
        let (first, nodes) = skew.run(diagonal);
        let steps = skew.steps(diagonal);
        for at in (first..first + nodes).step_by(LANES) {
            let image = landed(e, e, coefficients, at, steps, -1.0);
            into[at..at + LANES].copy_from_slice(&image);
        }
    }
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
