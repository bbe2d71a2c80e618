//! Gauss–Seidel sweeps of Bellman's operator in single precision, one diagonal at a time.
//!
//! The kernel works on afterstate values w = r + V, with the share of a hop that ends where it began solved for:
//! V = a + bV gives V = a / (1 − b). With g the discount between departure and landing, λ the wait, and
//! D = 1 − g · stuck, a node carries ρ = r (1 + γλ) / D, a = g · intended / D, c = g · sideways / D and its
//! slopes. Both hops along one axis slip to the same two sides with the same probabilities, so with
//! B = ρ + c [(w₋ + w₊) + s (w₊ − w₋)] over the other axis, and t = |slope| along the hop's own axis, the value of
//! a hop is
//!
//! - B + a w_down downhill or on the flat,
//! - (B + a (1 − t) w_up) / (1 − a t) uphill.
//!
//! The two uphill candidates are compared by cross-multiplication, so that one division serves both.
//! A goal and a node where the hopper is lost have a = c = 0: their afterstate value is ρ, whatever surrounds them.
//!
//! **Over-relaxation.** Where an afterstate value grows, those of the nodes further out will grow likewise, and the
//! share c of that growth returns through slips. So an update goes beyond Bellman's by [`OVER_RELAXATION`] c of its
//! change (successive over-relaxation, with a factor of its own at each node). This keeps the fixed point and
//! reduces a smooth error several times faster. The full factor 1 overshoots, and a value that is too high
//! comes down only by γ per sweep.
//!
//! **Shifted.** With W the present afterstate values and e a correction to them, T(W + e) − W has the same form,
//! except that each of the four candidates has its own shift δ / D in place of ρ, δ the residual of that hop under W
//! ([`super::residual`]). So the same kernel sweeps for corrections, choosing the best hops again, and the seven
//! digits of single precision then hold the correction instead of the afterstate values.
//!
//! **Border.** The halo holds the loss, or, where leaving counts as staying, the border node's own value from the
//! sweep before: the fixed point is the same.

use std::cell::Cell;

use super::pair::{LeaderProgress, Shared, ThreadRole};
use super::planes::{Planes, split};
use super::skew::{BorderStep, Diagonal, HOPS, Lanes, PARTS, Skew, Stencil, constant_at, part_at, shift_at};
use super::wavefront::Wavefront;
use crate::Leaving;
use crate::simd::{SINGLE_LANES as LANES, Simd, dispatch};

/// Nodes of a world from which on a second thread pays.
const PAIR_NODES_MIN: usize = 10_000;

/// Share of the growth returned by slips that an update anticipates.
const OVER_RELAXATION: f32 = 0.6;

impl Planes {
    /// Updates the unknowns in a wavefront: afterstate values, or corrections where `shifted`. The largest change of
    /// the last sweep, lane by lane, goes into `change`.
    pub fn relax(
        &mut self,
        simd: Simd,
        skew: &Skew,
        leaving: Leaving,
        shifted: bool,
        wavefront: Wavefront,
        change: &mut Lanes,
    ) {
        let stays = leaving == Leaving::Stays;
        let Self { threads, unknown, coefficients, .. } = self;
        let (coefficients, shifts) = split(coefficients.all_mut());
        let [unknown, coefficients, shifts] = [unknown.all_mut(), coefficients, shifts].map(Shared::new);
        let planes = Swept { unknown, coefficients, shifts };
        let sweep = move |wavefront, role: ThreadRole<'_>, change: &mut Lanes| {
            let relax = if shifted { relax_shifted } else { relax };
            relax(simd, planes, skew, stays, wavefront, role, change);
        };
        if *threads < 2 || wavefront.sweeps < 2 || skew.width * skew.height < PAIR_NODES_MIN {
            return sweep(wavefront, ThreadRole::Alone, change);
        }
        let progress = LeaderProgress::default();
        let first = Wavefront { sweeps: wavefront.sweeps / 2, ..wavefront };
        let last = Wavefront { sweeps: wavefront.sweeps - first.sweeps, ..wavefront };
        #[allow(clippy::disallowed_methods, reason = "on request; the values are the same in one thread")]
        std::thread::scope(|scope| {
            let leader = ThreadRole::Leader(&progress);
            let lead = move || sweep(first, leader, &mut [0.0; LANES]);
            if std::thread::Builder::new().spawn_scoped(scope, lead).is_err() {
                // No second thread is to be had: one after the other.
                lead();
            }
            sweep(last, ThreadRole::Follower(&progress), change);
        });
    }
}

/// What a sweep in single precision reads and writes.
#[derive(Clone, Copy, Debug)]
struct Swept<'a> {
    unknown: Shared<'a>,
    coefficients: Shared<'a>,
    shifts: Shared<'a>,
}

dispatch! {
    /// Updates the afterstate values in a wavefront.
    fn relax(planes: Swept<'_>, skew: &Skew, stays: bool, wavefront: Wavefront, role: ThreadRole<'_>, change: &mut Lanes)
        = relax_lanes::<false>
}

dispatch! {
    /// Updates the corrections in a wavefront.
    fn relax_shifted(planes: Swept<'_>, skew: &Skew, stays: bool, wavefront: Wavefront, role: ThreadRole<'_>, change: &mut Lanes)
        = relax_lanes::<true>
}

#[inline(always)]
fn relax_lanes<const SHIFTED: bool>(
    planes: Swept<'_>,
    skew: &Skew,
    stays: bool,
    wavefront: Wavefront,
    role: ThreadRole<'_>,
    change: &mut Lanes,
) {
    let [unknown, coefficients, shifts] =
        [planes.unknown, planes.coefficients, planes.shifts].map(Shared::cells);
    // No closures here: they would be compiled without the vector instructions, as functions of their own.
    let diagonals = skew.diagonals();
    let count = diagonals.len();
    for step in 0..wavefront.steps(count) {
        role.begin(step, count);
        for sweep in wavefront.at(count, step) {
            let diagonal = &diagonals[wavefront.diagonal(count, step, sweep)];
            if stays && step == 2 * sweep {
                fill_halo::<SHIFTED>(unknown, coefficients, shifts, skew.border_of(diagonal));
            }
            if sweep + 1 == wavefront.sweeps {
                relax_diagonal::<SHIFTED, true>(unknown, coefficients, shifts, diagonal, change);
            } else {
                relax_diagonal::<SHIFTED, false>(unknown, coefficients, shifts, diagonal, change);
            }
            // One step ahead, so that no read waits for these writes.
            if stays && step - 2 * sweep + 1 < count {
                let next = &diagonals[wavefront.diagonal(count, step + 1, sweep)];
                fill_halo::<SHIFTED>(unknown, coefficients, shifts, skew.border_of(next));
            }
        }
        role.finish((step + 1).saturating_sub(2 * (wavefront.sweeps - 1)));
    }
}

/// Copies the border's unknowns into the halo beside a diagonal.
#[inline(always)]
fn fill_halo<const SHIFTED: bool>(
    unknown: &[Cell<f32>],
    coefficients: &[Cell<f32>],
    shifts: &[Cell<f32>],
    border: &[BorderStep],
) {
    for &BorderStep { at, beyond, .. } in border {
        unknown[beyond].set(unknown[at].get());
        // Padding lanes of a chunk have no coefficients but the constant, so that the halo keeps its value.
        if SHIFTED {
            for index in 0..HOPS {
                shifts[shift_at(beyond, index)].set(unknown[at].get());
            }
        } else {
            coefficients[constant_at(beyond)].set(unknown[at].get());
        }
    }
}

/// Updates a diagonal; the largest change goes into `change` in the `LAST` sweep.
#[inline(always)]
fn relax_diagonal<const SHIFTED: bool, const LAST: bool>(
    unknown: &[Cell<f32>],
    coefficients: &[Cell<f32>],
    shifts: &[Cell<f32>],
    diagonal: &Diagonal,
    change: &mut Lanes,
) {
    let stencil = Stencil::new(unknown, diagonal);
    let chunks = stencil.chunks();
    let coefficients =
        &coefficients[part_at(diagonal.first(), 0)..].as_chunks::<{ PARTS * LANES }>().0[..chunks];
    let shifts = if SHIFTED { &shifts[shift_at(diagonal.first(), 0)..].as_chunks().0[..chunks] } else { &[] };
    for (index, parts) in coefficients.iter().enumerate() {
        let [low_i, low_j, high_i, high_j, old] = stencil.chunk(index);
        let (ahead, beside) = (cells(parts, LANES), cells(parts, 2 * LANES));
        let (slope_i, slope_j) = (cells(parts, 3 * LANES), cells(parts, 4 * LANES));
        // For the hops up and down along i, up and down along j.
        let constants = if SHIFTED {
            let shifts: &[Cell<f32>; HOPS * LANES] = &shifts[index];
            [cells(shifts, 0), cells(shifts, LANES), cells(shifts, 2 * LANES), cells(shifts, 3 * LANES)]
        } else {
            [cells(parts, 0); HOPS]
        };
        let mut new = [0.0_f32; LANES];
        for lane in 0..LANES {
            let (a, c) = (ahead[lane], beside[lane]);
            let (s, t) = (slope_i[lane], slope_j[lane]);
            let along_i = c * ((low_j[lane] + high_j[lane]) + t * (high_j[lane] - low_j[lane]));
            let along_j = c * ((low_i[lane] + high_i[lane]) + s * (high_i[lane] - low_i[lane]));
            let (up_i, down_i) =
                if s > 0.0 { (high_i[lane], low_i[lane]) } else { (low_i[lane], high_i[lane]) };
            let (up_j, down_j) =
                if t > 0.0 { (high_j[lane], low_j[lane]) } else { (low_j[lane], high_j[lane]) };
            let (uphill_i, downhill_i) = (constants[0][lane] + along_i, constants[1][lane] + along_i);
            let (uphill_j, downhill_j) = (constants[2][lane] + along_j, constants[3][lane] + along_j);
            let (lost_i, lost_j) = (a * s.abs(), a * t.abs());
            let (numerator_i, numerator_j) = (uphill_i + (a - lost_i) * up_i, uphill_j + (a - lost_j) * up_j);
            let (denominator_i, denominator_j) = (1.0 - lost_i, 1.0 - lost_j);
            let is_i = numerator_i * denominator_j > numerator_j * denominator_i;
            let numerator = if is_i { numerator_i } else { numerator_j };
            let denominator = if is_i { denominator_i } else { denominator_j };
            let uphill = numerator / denominator;
            let downhill_i = downhill_i + a * down_i;
            let downhill_j = downhill_j + a * down_j;
            let downhill = if downhill_i > downhill_j { downhill_i } else { downhill_j };
            let best = if uphill > downhill { uphill } else { downhill };
            new[lane] = best + OVER_RELAXATION * c * (best - old[lane]);
        }
        if LAST {
            for lane in 0..LANES {
                let moved = (new[lane] - old[lane]).abs();
                change[lane] = if moved > change[lane] { moved } else { change[lane] };
            }
        }
        stencil.set(index, &new);
    }
}

/// The chunk of shared numbers at an entry.
#[inline(always)]
fn cells(numbers: &[Cell<f32>], at: usize) -> Lanes {
    let numbers = &numbers[at..at + LANES];
    let mut chunk = [0.0; LANES];
    for lane in 0..LANES {
        chunk[lane] = numbers[lane].get();
    }
    chunk
}
