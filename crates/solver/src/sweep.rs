//! Gauss–Seidel sweeps of Bellman's operator in single precision, a diagonal at a time.
//!
//! The kernel works on worths w = r + V, with the share of a hop that ends where it began solved for:
//! V = a + bV is V = a / (1 − b). With g the discount between departure and landing, λ the wait, and
//! D = 1 − g · stuck, a node carries ρ = r (1 + γλ) / D, a = g · intended / D, c = g · sideways / D and its
//! slopes. Both hops along one axis slip to the same two sides with the same probabilities, so with
//! B = ρ + c [(w₋ + w₊) + s (w₊ − w₋)] over the other axis, and t = |slope| along the hop's own axis,
//!
//! - downhill (or on the flat) a hop is worth B + a w_down,
//! - uphill (B + a (1 − t) w_up) / (1 − a t).
//!
//! The two uphill candidates are compared by cross-multiplication, so that one division serves both.
//! A goal and a node where the hopper is lost carry a = c = 0: their worth is ρ, whatever surrounds them.
//! Beyond the map lies the loss, or, where leaving counts as staying, the last worth of the border node
//! itself: the same fixed point, approached from one sweep to the next.

use crate::simd::{Simd, dispatch};
use crate::skew::{Ground, LANES, Skew, chunk};
use crate::window::Diagonals;
use crate::{Leaving, Rules, World};

/// What lies in the entries of a layout, used by one kernel at a time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Planes {
    /// What is solved for: worths here, corrections in the linear solve.
    pub unknown: Vec<f32>,
    /// What each node has of its own, here ρ, a, c and the slopes along i and j; a chunk each.
    pub ground: Vec<Ground>,
}

impl Planes {
    /// `len` entries of zeros. Coefficients beside the grid are never written after.
    pub fn reset(&mut self, len: usize) {
        self.unknown.clear();
        self.unknown.resize(len, 0.0);
        self.ground.clear();
        self.ground.resize(len / LANES, Ground::NONE);
    }

    /// Sets what the node at an entry has of its own.
    #[inline(always)]
    pub fn set(&mut self, at: usize, own: [f32; 5]) {
        let ground = &mut self.ground[at / LANES].0;
        for part in 0..5 {
            ground[part][at % LANES] = own[part];
        }
    }

    /// Fills in `world` with the worths that `values` imply.
    pub fn load(&mut self, skew: &Skew, world: &World, values: &[f64]) {
        let rules = world.rules();
        let soils = soils(world);
        let sign = skew.flip.map(|flip| if flip { -1.0 } else { 1.0 });
        skew.visit(|columns, y| {
            let (payoffs, east, north, classes) = world.row(y);
            let values = &values[y * skew.width..];
            for (x, at) in columns.clone().zip(skew.entries(columns, y)) {
                let class = classes[x];
                if class.is_free() {
                    let [per_payoff, a, c] = soils[class.soil()];
                    self.unknown[at] = (payoffs[x] + values[x]) as f32;
                    let own = (payoffs[x] * per_payoff) as f32;
                    let slopes = [(east[x] * sign[0]) as f32, (north[x] * sign[1]) as f32];
                    self.set(at, [own, a as f32, c as f32, slopes[0], slopes[1]]);
                } else {
                    let worth = if class.is_lost() { rules.loss } else { payoffs[x] } as f32;
                    self.unknown[at] = worth;
                    self.set(at, [worth, 0.0, 0.0, 0.0, 0.0]);
                }
            }
        });
        self.halo(skew, rules);
    }

    /// Takes the values out again.
    pub fn store(&self, skew: &Skew, world: &World, values: &mut [f64]) {
        skew.visit(|columns, y| {
            let (payoffs, _, _, classes) = world.row(y);
            let values = &mut values[y * skew.width..];
            for (x, at) in columns.clone().zip(skew.entries(columns, y)) {
                if classes[x].is_free() {
                    values[x] = f64::from(self.unknown[at]) - payoffs[x];
                }
            }
        });
    }

    /// Fills the halo: with the loss, or with the worths of the border.
    fn halo(&mut self, skew: &Skew, rules: &Rules) {
        for diagonal in skew.diagonals() {
            let (first, nodes) = skew.run(diagonal);
            for (at, step) in skew.rim(diagonal, first, first + nodes - 1, skew.steps(diagonal)) {
                if step != 0 {
                    let beyond = at.wrapping_add_signed(step);
                    let stays = rules.leaving == Leaving::Stays;
                    self.unknown[beyond] = if stays { self.unknown[at] } else { rules.loss as f32 };
                    self.ground[beyond / LANES].0[0][beyond % LANES] = self.unknown[beyond];
                }
            }
        }
    }

    /// Updates the worths of some diagonals, outwards or back; the largest change, lane by lane, goes into
    /// `change` for diagonals below `leaves`.
    pub fn relax(
        &mut self,
        simd: Simd,
        skew: &Skew,
        leaving: Leaving,
        diagonals: Diagonals,
        change: &mut [f32; LANES],
    ) {
        let Self { unknown, ground } = self;
        relax(simd, unknown, ground, skew, leaving == Leaving::Stays, diagonals, change);
    }
}

/// For each soil: ρ per payoff, a and c.
fn soils(world: &World) -> [[f64; 3]; World::SOILS_MAX] {
    let mut table = [[0.0; 3]; World::SOILS_MAX];
    let discount = world.rules().discount;
    for (entry, soil) in table.iter_mut().zip(&world.rules().soils) {
        let landing = soil.discount(discount);
        let moves = 1.0 - landing * soil.stuck;
        *entry = [
            (1.0 + discount * soil.wait) / moves,
            landing * soil.intended / moves,
            landing * soil.sideways / moves,
        ];
    }
    table
}

dispatch! {
    /// Updates the worths of some diagonals.
    fn relax(
        worths: &mut [f32], ground: &mut [Ground], skew: &Skew, stays: bool,
        diagonals: Diagonals, change: &mut [f32; LANES],
    ) = relax_lanes
}

#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "a kernel takes its planes one by one")]
fn relax_lanes(
    worths: &mut [f32],
    ground: &mut [Ground],
    skew: &Skew,
    stays: bool,
    diagonals: Diagonals,
    change: &mut [f32; LANES],
) {
    // No closures in here: they would be compiled without the vector instructions, and be called.
    let mut ignored = [0.0; LANES];
    for index in 0..diagonals.len() {
        let diagonal = diagonals.at(index);
        let (first, nodes) = skew.run(diagonal);
        let steps = skew.steps(diagonal);
        if diagonal < diagonals.leaves {
            relax_run(worths, ground, first, nodes, steps, change);
        } else {
            relax_run(worths, ground, first, nodes, steps, &mut ignored);
        }
        if stays {
            let last = first + nodes - 1;
            for (at, step) in skew.rim(diagonal, first, last, steps) {
                if step != 0 {
                    let beyond = at.wrapping_add_signed(step);
                    worths[beyond] = worths[at];
                    ground[beyond / LANES].0[0][beyond % LANES] = worths[at];
                }
            }
        }
    }
}

#[inline(always)]
fn relax_run(
    worths: &mut [f32],
    ground: &[Ground],
    first: usize,
    nodes: usize,
    steps: [isize; 4],
    change: &mut [f32; LANES],
) {
    for at in (first..first + nodes).step_by(LANES) {
        let low_i = chunk(worths, at.wrapping_add_signed(steps[0]));
        let low_j = chunk(worths, at.wrapping_add_signed(steps[1]));
        let high_i = chunk(worths, at.wrapping_add_signed(steps[2]));
        let high_j = chunk(worths, at.wrapping_add_signed(steps[3]));
        let old = chunk(worths, at);
        let [own, ahead, beside, slope_i, slope_j] = &ground[at / LANES].0;
        let mut new = [0.0_f32; LANES];
        for lane in 0..LANES {
            let (a, c) = (ahead[lane], beside[lane]);
            let (s, t) = (slope_i[lane], slope_j[lane]);
            let along_i = own[lane] + c * ((low_j[lane] + high_j[lane]) + t * (high_j[lane] - low_j[lane]));
            let along_j = own[lane] + c * ((low_i[lane] + high_i[lane]) + s * (high_i[lane] - low_i[lane]));
            let (up_i, down_i) =
                if s > 0.0 { (high_i[lane], low_i[lane]) } else { (low_i[lane], high_i[lane]) };
            let (up_j, down_j) =
                if t > 0.0 { (high_j[lane], low_j[lane]) } else { (low_j[lane], high_j[lane]) };
            let (lost_i, lost_j) = (a * s.abs(), a * t.abs());
            let (over_i, over_j) = (along_i + (a - lost_i) * up_i, along_j + (a - lost_j) * up_j);
            let (under_i, under_j) = (1.0 - lost_i, 1.0 - lost_j);
            let first = over_i * under_j > over_j * under_i;
            let over = if first { over_i } else { over_j };
            let under = if first { under_i } else { under_j };
            let uphill = over / under;
            let downhill_i = along_i + a * down_i;
            let downhill_j = along_j + a * down_j;
            let downhill = if downhill_i > downhill_j { downhill_i } else { downhill_j };
            new[lane] = if uphill > downhill { uphill } else { downhill };
        }
        for lane in 0..LANES {
            let moved = (new[lane] - old[lane]).abs();
            change[lane] = if moved > change[lane] { moved } else { change[lane] };
        }
        worths[at..at + LANES].copy_from_slice(&new);
    }
}
