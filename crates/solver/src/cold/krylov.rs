//! BiCGStab for a policy's linear equation, where sweeps converge slowly because the hopper lingers.
//!
//! (van der Vorst 1992, preconditioned from the right.) The preconditioner is a sweep outwards and one back:
//! (I − L)(I − U), L the two landings that lie inwards, U the two that lie outwards. Each place where the hopper
//! lingers makes one eigenvalue near 1. They lie close together, and a Krylov method removes them at once.

use super::planes::Planes;
use super::skew::{Lanes, PARTS, Skew, chunk, part_at};
use crate::simd::{SINGLE_LANES as LANES, Simd, dispatch};

/// Vectors of the iteration, one number per entry; empty until the method is first needed.
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

/// Most iterations of BiCGStab in one round.
const ITERATIONS_MAX: usize = 30;
/// Reduction of the residual's norm at which BiCGStab ends.
const KRYLOV_REDUCTION: f64 = 0.01;

impl Planes {
    /// Solves for e from 0 and returns the node updates made. Entries outside the grid stay 0, as their coefficients are.
    pub fn krylov(&mut self, simd: Simd, skew: &Skew, krylov: &mut Krylov, updates_max: u64) -> u64 {
        let (solution, coefficients) = (self.unknown.all_mut(), self.coefficients.all());
        let Krylov { residual, shadow, direction, image, preconditioned, image_half, halfway } = krylov;
        for plane in [&mut *residual, shadow, direction] {
            plane.clear();
            let coefficients = &coefficients[..PARTS * solution.len()];
            plane.extend(coefficients.chunks_exact(PARTS * LANES).flat_map(|parts| &parts[..LANES]));
        }
        for plane in [&mut *image, preconditioned, image_half, halfway] {
            plane.clear();
            plane.resize(solution.len(), 0.0);
        }
        if updates_max < 4 * (skew.width * skew.height) as u64 {
            // Keeps the correction that the sweeps made.
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
            solve_lower(simd, halfway, direction, coefficients, skew);
            solve_upper(simd, preconditioned, image, halfway, coefficients, skew);
            let alpha = rho / dot(simd, shadow, image);
            axpy(simd, solution, alpha as f32, preconditioned);
            axpy(simd, residual, -alpha as f32, image);
            solve_lower(simd, halfway, residual, coefficients, skew);
            solve_upper(simd, preconditioned, image_half, halfway, coefficients, skew);
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
            update_direction(simd, direction, residual, image, beta as f32, omega as f32);
        }
        if solution.iter().any(|e| !e.is_finite()) {
            solution.fill(0.0);
        }
        updates
    }
}

dispatch! {
    /// Solves (I − L) e = p by a sweep outwards.
    fn solve_lower(e: &mut [f32], p: &[f32], coefficients: &[f32], skew: &Skew) = solve_lower_lanes
}

#[inline(always)]
fn solve_lower_lanes(e: &mut [f32], p: &[f32], coefficients: &[f32], skew: &Skew) {
    for diagonal in skew.diagonals() {
        let [low_i, low_j, _, _] = diagonal.steps();
        for at in (diagonal.first()..diagonal.first() + diagonal.nodes()).step_by(LANES) {
            let p = chunk(p, at);
            let inner = halves(e, at, [low_i, low_j], coefficients, 1);
            let mut new = [0.0_f32; LANES];
            for lane in 0..LANES {
                new[lane] = p[lane] + inner[lane];
            }
            e[at..at + LANES].copy_from_slice(&new);
        }
    }
}

dispatch! {
    /// Solves (I − U) f = e by a sweep back, and computes the image of f, (I − L − U) f = e − L f, diagonal by diagonal
    /// as f becomes known (Eisenstat 1981).
    fn solve_upper(f: &mut [f32], image: &mut [f32], e: &[f32], coefficients: &[f32], skew: &Skew) = solve_upper_lanes
}

#[inline(always)]
fn solve_upper_lanes(f: &mut [f32], image: &mut [f32], e: &[f32], coefficients: &[f32], skew: &Skew) {
    let diagonals = skew.diagonals();
    for known in (0..=diagonals.len()).rev() {
        // At the end f is complete, and one image is left to compute.
        if known > 0 {
            let diagonal = &diagonals[known - 1];
            let [_, _, high_i, high_j] = diagonal.steps();
            for at in (diagonal.first()..diagonal.first() + diagonal.nodes()).step_by(LANES) {
                let e = chunk(e, at);
                let outer = halves(f, at, [high_i, high_j], coefficients, 3);
                let mut new = [0.0_f32; LANES];
                for lane in 0..LANES {
                    new[lane] = e[lane] + outer[lane];
                }
                f[at..at + LANES].copy_from_slice(&new);
            }
        }
        if known < diagonals.len() {
            let diagonal = &diagonals[known];
            let [low_i, low_j, _, _] = diagonal.steps();
            for at in (diagonal.first()..diagonal.first() + diagonal.nodes()).step_by(LANES) {
                let e = chunk(e, at);
                let inner = halves(f, at, [low_i, low_j], coefficients, 1);
                let mut new = [0.0_f32; LANES];
                for lane in 0..LANES {
                    new[lane] = e[lane] - inner[lane];
                }
                image[at..at + LANES].copy_from_slice(&new);
            }
        }
    }
}

/// Two of the four terms of Σ c e, with the factors `first` and `first + 1`.
#[inline(always)]
fn halves(e: &[f32], at: usize, steps: [isize; 2], coefficients: &[f32], first: usize) -> Lanes {
    let (a, b) = (chunk(e, at.wrapping_add_signed(steps[0])), chunk(e, at.wrapping_add_signed(steps[1])));
    let (c_a, c_b) = (chunk(coefficients, part_at(at, first)), chunk(coefficients, part_at(at, first + 1)));
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
    fn update_direction(p: &mut [f32], r: &[f32], v: &[f32], beta: f32, omega: f32) = update_direction_lanes
}

#[inline(always)]
fn update_direction_lanes(p: &mut [f32], r: &[f32], v: &[f32], beta: f32, omega: f32) {
    for ((p, r), v) in p.iter_mut().zip(r).zip(v) {
        *p = r + beta * (*p - omega * v);
    }
}
