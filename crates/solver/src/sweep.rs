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

use crate::simd::dispatch;
use crate::skew::{LANES, Skew, chunk};
use crate::{Kind, Leaving, World};

/// The six planes of a layout, used by one kernel at a time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Planes {
    /// What is solved for: worths here, corrections in the linear solve.
    pub unknown: Vec<f32>,
    /// What a node has of its own.
    pub own: Vec<f32>,
    /// Coefficients.
    pub coefficients: [Vec<f32>; 4],
}

impl Planes {
    /// Planes of `len` zeros.
    pub fn clear(&mut self, len: usize) {
        let Self { unknown, own, coefficients } = self;
        for plane in [unknown, own].into_iter().chain(coefficients) {
            plane.clear();
            plane.resize(len, 0.0);
        }
    }

    /// Fills in `world` with the worths that `values` imply.
    pub fn load(&mut self, skew: &Skew, world: &World, values: &[f64]) {
        self.clear(skew.len);
        let rules = world.rules();
        let soils = soils(world);
        let sign = skew.flip.map(|flip| if flip { -1.0 } else { 1.0 });
        let Self { unknown, own, coefficients: [ahead, beside, slope_i, slope_j] } = self;
        for y in 0..skew.height {
            for x in 0..skew.width {
                let (node, at) = (y * skew.width + x, skew.entry(x, y));
                match world.kind(node) {
                    Kind::Free => {
                        let [per_payoff, a, c] = soils[world.soil_index(node)];
                        let [east, north] = world.slopes(node);
                        unknown[at] = (world.payoff(node) + values[node]) as f32;
                        own[at] = (world.payoff(node) * per_payoff) as f32;
                        ahead[at] = a as f32;
                        beside[at] = c as f32;
                        slope_i[at] = (east * sign[0]) as f32;
                        slope_j[at] = (north * sign[1]) as f32;
                    }
                    kind => {
                        own[at] = if kind == Kind::Goal { world.payoff(node) } else { rules.loss } as f32;
                        unknown[at] = own[at];
                    }
                }
            }
        }
        for diagonal in skew.diagonals() {
            self.halo(skew, diagonal, rules.leaving, rules.loss as f32);
        }
    }

    /// Takes the values out again.
    pub fn store(&self, skew: &Skew, world: &World, values: &mut [f64]) {
        for y in 0..skew.height {
            for x in 0..skew.width {
                let node = y * skew.width + x;
                if world.kind(node) == Kind::Free {
                    values[node] = f64::from(self.unknown[skew.entry(x, y)]) - world.payoff(node);
                }
            }
        }
    }

    /// Renews the halo beside the border nodes of a diagonal.
    fn halo(&mut self, skew: &Skew, diagonal: usize, leaving: Leaving, loss: f32) {
        let (first, nodes) = skew.run(diagonal);
        let last = first + nodes - 1;
        let [before_i, before_j, after_i, after_j] = skew.steps(diagonal);
        let (i, j) = (first - skew.base[diagonal], diagonal - (last - skew.base[diagonal]));
        let mut set = |node: usize, step: isize| {
            let at = node.wrapping_add_signed(step);
            let worth = if leaving == Leaving::Stays { self.unknown[node] } else { loss };
            self.unknown[at] = worth;
            self.own[at] = worth;
        };
        if i == 1 {
            set(first, before_i);
        }
        if diagonal - i == skew.height {
            set(first, after_j);
        }
        if j == 1 {
            set(last, before_j);
        }
        if diagonal - j == skew.width {
            set(last, after_i);
        }
    }

    /// Updates the worths of one diagonal; the largest change.
    pub fn relax(&mut self, simd: crate::simd::Simd, skew: &Skew, diagonal: usize, world: &World) -> f32 {
        let (first, nodes) = skew.run(diagonal);
        let Self { unknown, own, coefficients: [ahead, beside, slope_i, slope_j] } = self;
        let change =
            relax(simd, unknown, own, ahead, beside, slope_i, slope_j, first, nodes, skew.steps(diagonal));
        if world.rules().leaving == Leaving::Stays {
            self.halo(skew, diagonal, Leaving::Stays, 0.0);
        }
        change
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
    /// Updates a run of worths; the largest change.
    fn relax(
        worths: &mut [f32], own: &[f32], ahead: &[f32], beside: &[f32], slope_i: &[f32], slope_j: &[f32],
        first: usize, nodes: usize, steps: [isize; 4],
    ) -> f32 = relax_lanes
}

#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "a kernel takes its planes one by one")]
fn relax_lanes(
    worths: &mut [f32],
    own: &[f32],
    ahead: &[f32],
    beside: &[f32],
    slope_i: &[f32],
    slope_j: &[f32],
    first: usize,
    nodes: usize,
    steps: [isize; 4],
) -> f32 {
    let mut change = [0.0_f32; LANES];
    for at in (first..first + nodes).step_by(LANES) {
        let [low_i, low_j, high_i, high_j] = steps.map(|step| chunk(worths, at.wrapping_add_signed(step)));
        let (old, own) = (chunk(worths, at), chunk(own, at));
        let (ahead, beside) = (chunk(ahead, at), chunk(beside, at));
        let (slope_i, slope_j) = (chunk(slope_i, at), chunk(slope_j, at));
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
    change.into_iter().fold(0.0, f32::max)
}
