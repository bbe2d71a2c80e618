//! The correction e from the linear equation of a policy, in single precision.
//!
//! e = constant + Σ c_k e_k over the four neighbours, solved by Gauss–Seidel sweeps in wavefronts: outwards from a goal
//! in a corner, alternating where it lies elsewhere. Where those converge slowly, [`super::krylov`] takes over.

use std::cell::Cell;

use super::krylov::Krylov;
use super::planes::Planes;
use super::skew::{Diagonal, Lanes, PARTS, Skew, Stencil, chunk, part_at};
use super::wavefront::{Wavefront, largest};
use crate::simd::{SINGLE_LANES as LANES, Simd, dispatch};

/// Directions of the sweeps of a linear solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SweepOrder {
    /// Always away from the corner that the goal is in.
    Outwards,
    /// Outwards and back in turn, to reach all sides of a goal.
    Alternating,
}

/// The limits of sweeps before the Krylov method takes over.
struct PassLimits {
    /// Sweeps per pass, at least 1.
    sweeps: usize,
    /// Slow passes in all that are tolerated.
    slow_max: usize,
}

impl SweepOrder {
    fn pass_limits(self) -> PassLimits {
        match self {
            Self::Outwards => PassLimits { sweeps: 5, slow_max: 0 },
            // Changes that have to go round a corner take some passes before any gets smaller.
            Self::Alternating => PassLimits { sweeps: 4, slow_max: 3 },
        }
    }
}

impl Planes {
    /// Solves for the correction until it changes by no more than `change_max` a sweep, or by no more than
    /// [`REDUCTION`] of its first change; the node updates made, and whether the former was reached.
    pub fn correct(
        &mut self,
        simd: Simd,
        skew: &Skew,
        krylov: &mut Krylov,
        order: SweepOrder,
        change_max: f32,
        updates_max: u64,
    ) -> (u64, bool) {
        let nodes = (skew.width * skew.height) as u64;
        let PassLimits { sweeps, slow_max } = order.pass_limits();
        let alternates = order == SweepOrder::Alternating;
        let (mut updates, mut slow) = (0, 0);
        let mut first = 0.0_f32;
        // Changes of the last two passes, the older one first.
        let mut lasts = [f32::INFINITY; 2];
        for pass in 0..PASSES_MAX {
            // Fewer at the end of the budget.
            let sweeps = sweeps.min(((updates_max - updates) / nodes) as usize);
            if sweeps == 0 {
                break;
            }
            let wavefront = Wavefront { sweeps, backwards: alternates && pass % 2 == 1 };
            let mut change = [0.0_f32; LANES];
            updates += nodes * sweeps as u64;
            correct(simd, self.unknown.all_mut(), self.coefficients.all(), skew, wavefront, &mut change);
            let change = largest(&change);
            if pass == 0 {
                first = change;
            }
            let enough = change_max.max(first * REDUCTION);
            // The change of one direction says nothing about the other.
            let (before, both) =
                if alternates { (lasts[0], change.max(lasts[1])) } else { (lasts[1], change) };
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
}

/// Most passes before the solve ends unsettled.
const PASSES_MAX: usize = 12;
/// Share of the flow back outwards that an update anticipates.
const OVER_RELAXATION: f32 = 0.7;
/// Most that counts as flow back outwards. Where the best hop leads outwards, all of it would.
const OUTER_MAX: f32 = 0.15;
/// Reduction of the change at which a linear solve by sweeps ends.
const REDUCTION: f32 = 1e-5;
/// Reduction from pass to pass in one direction that counts as slow.
const SLOW: f32 = 0.75;
dispatch! {
    /// Updates the corrections in a wavefront; the largest change of its last sweep, lane by lane, goes into `change`.
    fn correct(unknown: &mut [f32], coefficients: &[f32], skew: &Skew, wavefront: Wavefront, change: &mut Lanes) = correct_lanes
}

#[inline(always)]
fn correct_lanes(
    unknown: &mut [f32],
    coefficients: &[f32],
    skew: &Skew,
    wavefront: Wavefront,
    change: &mut Lanes,
) {
    let unknown = Cell::from_mut(unknown).as_slice_of_cells();
    let diagonals = skew.diagonals();
    let count = diagonals.len();
    for step in 0..wavefront.steps(count) {
        for sweep in wavefront.at(count, step) {
            let diagonal = &diagonals[wavefront.diagonal(count, step, sweep)];
            if sweep + 1 == wavefront.sweeps {
                correct_diagonal::<true>(unknown, coefficients, diagonal, change);
            } else {
                correct_diagonal::<false>(unknown, coefficients, diagonal, change);
            }
        }
    }
}

/// Updates a diagonal; the largest change goes into `change` in the `LAST` sweep.
#[inline(always)]
fn correct_diagonal<const LAST: bool>(
    unknown: &[Cell<f32>],
    coefficients: &[f32],
    diagonal: &Diagonal,
    change: &mut Lanes,
) {
    let stencil = Stencil::new(unknown, diagonal);
    let coefficients =
        &coefficients[part_at(diagonal.first(), 0)..].as_chunks::<{ PARTS * LANES }>().0[..stencil.chunks()];
    for (index, parts) in coefficients.iter().enumerate() {
        let [low_i, low_j, high_i, high_j, old] = stencil.chunk(index);
        let (constant, c_low_i, c_low_j) = (chunk(parts, 0), chunk(parts, LANES), chunk(parts, 2 * LANES));
        let (c_i, c_j) = (chunk(parts, 3 * LANES), chunk(parts, 4 * LANES));
        let mut new = [0.0; LANES];
        for lane in 0..LANES {
            let inner = c_low_i[lane] * low_i[lane] + c_low_j[lane] * low_j[lane];
            new[lane] = constant[lane] + (inner + (c_i[lane] * high_i[lane] + c_j[lane] * high_j[lane]));
        }
        let mut next = [0.0; LANES];
        for lane in 0..LANES {
            let outer = c_i[lane] + c_j[lane];
            let anticipated = if outer < OUTER_MAX { outer } else { OUTER_MAX };
            next[lane] = new[lane] + OVER_RELAXATION * anticipated * (new[lane] - old[lane]);
        }
        if LAST {
            for lane in 0..LANES {
                let moved = (new[lane] - old[lane]).abs();
                change[lane] = if moved > change[lane] { moved } else { change[lane] };
            }
        }
        stencil.set(index, &next);
    }
}
