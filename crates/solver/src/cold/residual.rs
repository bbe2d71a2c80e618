//! The residual of each hop in double precision, over the skewed layout.
//!
//! Let δ_u be Bellman's right-hand side for hop u less the present value. A correction e solves Bellman's equation if
//! e = max_u (δ_u + g P_u e): sweeps of the shifted operator solve this ([`Planes::relax`]). For the best hops π alone
//! the equation is linear, e = δ_π + g P_π e, hence e = (δ_π + g Σ_{x′ ≠ x} p e(x′)) / (1 − g p_stay), which
//! [`super::correct`] solves: Newton's step for Bellman's equation, or policy iteration. Either way δ is computed in
//! double precision, so single precision is enough for the corrections.
//!
//! The hops are compared in the form of [`super::sweep`]: both hops along one axis share the slips to the sides, and
//! the share that stays on the flat is common to all four.

use super::gather::{Gathered, Nodes};
use super::planes::{Planes, Soils, soils, split};
use super::skew::{BorderStep, HOPS, PARTS, Skew, constant_at, part_at, shift_at};
use crate::grid_world::Class;
use crate::simd::{DOUBLE_LANES, SINGLE_LANES as LANES, Simd, dispatch};
use crate::{GridWorld, Leaving};

impl Planes {
    /// max |V − TV|, infinite if some value is not finite. Writes the shifts of all hops for [`Planes::relax`], and
    /// sets the corrections to 0.
    pub fn hop_residuals(&mut self, simd: Simd, skew: &Skew, world: &GridWorld) -> f64 {
        let stays = world.rules().leaving == Leaving::Stays;
        let Self { afterstates, unknown, coefficients, .. } = self;
        let (afterstates, unknown, (_, shifts)) =
            (afterstates.all_mut(), unknown.all_mut(), split(coefficients.all_mut()));
        for &BorderStep { at, beyond, .. } in skew.border() {
            afterstates[beyond] = if stays { afterstates[at] } else { world.rules().loss };
            unknown[beyond] = 0.0;
            for hop in 0..HOPS {
                shifts[shift_at(beyond, hop)] = 0.0;
            }
        }
        hop_residuals(simd, afterstates, unknown, shifts, skew, world, &soils(world))
    }

    /// Computes residuals, but writes the linear equation of the best hops' correction in their
    /// place, its four factors in the order of [`Diagonal::steps`](super::skew::Diagonal::steps).
    pub fn linear_residuals(&mut self, simd: Simd, skew: &Skew, world: &GridWorld) -> f64 {
        let rules = world.rules();
        let stays = rules.leaving == Leaving::Stays;
        let Self { afterstates, unknown, coefficients, .. } = self;
        let (afterstates, unknown, coefficients) =
            (afterstates.all_mut(), unknown.all_mut(), coefficients.all_mut());
        for &BorderStep { at, beyond, .. } in skew.border() {
            afterstates[beyond] = if stays { afterstates[at] } else { rules.loss };
            unknown[beyond] = 0.0;
            coefficients[constant_at(beyond)] = 0.0;
        }
        let residual = linear_residuals(simd, afterstates, unknown, coefficients, skew, world, &soils(world));
        if stays {
            // Leaving the map means staying: e = constant + l e + … gives e = (constant + …) / (1 − l).
            for &BorderStep { at, step, .. } in skew.border() {
                let constant = constant_at(at);
                let leaves = std::mem::take(&mut coefficients[constant + (1 + step) * LANES]);
                let scale = 1.0 / (1.0 - leaves);
                for index in 0..PARTS {
                    coefficients[constant + index * LANES] *= scale;
                }
            }
        }
        residual
    }
}

dispatch! {
    /// The largest residual of all nodes. The shifts of all hops go into `stream`.
    fn hop_residuals(
        afterstates: &[f64], unknown: &mut [f32], stream: &mut [f32], skew: &Skew, world: &GridWorld, soils: &Soils,
    ) -> f64 = residual_lanes::<false>
}

dispatch! {
    /// The largest residual of all nodes. The equation of the best hops goes into `stream`.
    fn linear_residuals(
        afterstates: &[f64], unknown: &mut [f32], stream: &mut [f32], skew: &Skew, world: &GridWorld, soils: &Soils,
    ) -> f64 = residual_lanes::<true>
}

#[inline(always)]
fn residual_lanes<const BEST: bool>(
    afterstates: &[f64],
    unknown: &mut [f32],
    stream: &mut [f32],
    skew: &Skew,
    world: &GridWorld,
    soils: &Soils,
) -> f64 {
    let flip = skew.flip.map(|flip| if flip { -1.0 } else { 1.0 });
    let mut maxima = Maxima::default();
    let mut remaining = skew.chunks();
    let mut gathered = Gathered::new();
    loop {
        let chunks = gathered.next(&mut remaining, world);
        if chunks == 0 {
            break;
        }
        for index in 0..chunks {
            let nodes = gathered.nodes(index);
            residual_half::<BEST>(afterstates, stream, nodes, 0, soils, flip, &mut maxima);
            // The last chunk of a diagonal often has no nodes there, and entries without a node are 0 already.
            if nodes.chunk.lanes > DOUBLE_LANES {
                residual_half::<BEST>(afterstates, stream, nodes, DOUBLE_LANES, soils, flip, &mut maxima);
            }
            unknown[nodes.chunk.entry..][..LANES].fill(0.0);
        }
    }
    if maxima.not_finite == [0.0; DOUBLE_LANES] {
        maxima.residual.into_iter().fold(0.0, f64::max)
    } else {
        f64::INFINITY
    }
}

/// Maxima over the nodes so far, lane by lane.
#[derive(Clone, Copy, Debug, Default)]
struct Maxima {
    /// The largest |V − TV|.
    residual: [f64; DOUBLE_LANES],
    /// Not 0 if some residual was not finite.
    not_finite: [f64; DOUBLE_LANES],
}

/// Residuals of a chunk's nodes from its lane `first` on, as many as the widest vector holds in double precision.
// Long: one loop over lanes: cut in two, the numbers in between would go through memory.
#[inline(always)]
fn residual_half<const BEST: bool>(
    afterstates: &[f64],
    stream: &mut [f32],
    nodes: Nodes<'_>,
    first: usize,
    soils: &Soils,
    flip: [f64; 2],
    maxima: &mut Maxima,
) {
    // No closures here: they would be compiled without the vector instructions, as functions of their own.
    let (payoffs, classes) = (half(nodes.payoffs, first), half(nodes.classes, first));
    let (slopes_i, slopes_j) = (half(&nodes.slopes[0], first), half(&nodes.slopes[1], first));
    let [intended, stuck, sideways, waits] = soils_of(soils, &classes);
    let (at, steps) = (nodes.chunk.entry + first, nodes.chunk.steps);
    let here = half(afterstates, at);
    let low_i = half(afterstates, at.wrapping_add_signed(steps[0]));
    let low_j = half(afterstates, at.wrapping_add_signed(steps[1]));
    let high_i = half(afterstates, at.wrapping_add_signed(steps[2]));
    let high_j = half(afterstates, at.wrapping_add_signed(steps[3]));
    let mut parts = [[0.0_f32; DOUBLE_LANES]; PARTS];
    let mut hops = [[0.0_f32; DOUBLE_LANES]; HOPS];
    for lane in 0..DOUBLE_LANES {
        let (a, c, q) = (intended[lane], sideways[lane], stuck[lane]);
        let (s, t) = (slopes_i[lane] * flip[0], slopes_j[lane] * flip[1]);
        let along_i = c * ((low_j[lane] + high_j[lane]) + t * (high_j[lane] - low_j[lane]));
        let along_j = c * ((low_i[lane] + high_i[lane]) + s * (high_i[lane] - low_i[lane]));
        // In single precision, to agree with the sweeps.
        let (rises_i, rises_j) = (s as f32 > 0.0, t as f32 > 0.0);
        let (up_i, down_i) = if rises_i { (high_i[lane], low_i[lane]) } else { (low_i[lane], high_i[lane]) };
        let (up_j, down_j) = if rises_j { (high_j[lane], low_j[lane]) } else { (low_j[lane], high_j[lane]) };
        let (lost_i, lost_j) = (a * s.abs(), a * t.abs());
        let uphill_i = along_i + ((a - lost_i) * up_i + lost_i * here[lane]);
        let uphill_j = along_j + ((a - lost_j) * up_j + lost_j * here[lane]);
        let downhill_i = along_i + a * down_i;
        let downhill_j = along_j + a * down_j;
        let climbs_i = uphill_i > downhill_i;
        let climbs_j = uphill_j > downhill_j;
        let best_i = if climbs_i { uphill_i } else { downhill_i };
        let best_j = if climbs_j { uphill_j } else { downhill_j };
        let is_i = best_i > best_j;
        let best = if is_i { best_i } else { best_j };
        let value = here[lane] - payoffs[lane];
        let same = (q * here[lane] + waits[lane] * payoffs[lane]) - value;
        let residual = best + same;
        let free = classes[lane].is_free();
        let size = if free { residual.abs() } else { 0.0 };
        maxima.not_finite[lane] = if size < f64::INFINITY { maxima.not_finite[lane] } else { 1.0 };
        maxima.residual[lane] = if size > maxima.residual[lane] { size } else { maxima.residual[lane] };
        if !BEST {
            let scale = 1.0 / (1.0 - q as f32);
            hops[0][lane] = if free { (uphill_i + same) as f32 * scale } else { 0.0 };
            hops[1][lane] = if free { (downhill_i + same) as f32 * scale } else { 0.0 };
            hops[2][lane] = if free { (uphill_j + same) as f32 * scale } else { 0.0 };
            hops[3][lane] = if free { (downhill_j + same) as f32 * scale } else { 0.0 };
            continue;
        }
        let lost_i = if climbs_i { lost_i } else { 0.0 };
        let lost_j = if climbs_j { lost_j } else { 0.0 };
        let lost = if is_i { lost_i } else { lost_j };
        let scale = 1.0 / (1.0 - q - lost) as f32;
        let ahead = (a - lost) as f32 * scale;
        let side = c as f32 * scale;
        let across = if is_i { t } else { s } as f32;
        let (slip_low, slip_high) = (side - side * across, side + side * across);
        let high_ahead_i = climbs_i == rises_i;
        let high_ahead_j = climbs_j == rises_j;
        let (ahead_low_i, ahead_high_i) = if high_ahead_i { (0.0, ahead) } else { (ahead, 0.0) };
        let (ahead_low_j, ahead_high_j) = if high_ahead_j { (0.0, ahead) } else { (ahead, 0.0) };
        parts[0][lane] = if free { residual as f32 * scale } else { 0.0 };
        parts[1][lane] = if is_i { ahead_low_i } else { slip_low };
        parts[2][lane] = if is_i { slip_low } else { ahead_low_j };
        parts[3][lane] = if is_i { ahead_high_i } else { slip_high };
        parts[4][lane] = if is_i { slip_high } else { ahead_high_j };
    }
    if BEST {
        for (index, values) in parts.iter().enumerate() {
            let start = part_at(nodes.chunk.entry, index) + first;
            stream[start..start + DOUBLE_LANES].copy_from_slice(values);
        }
    } else {
        for (hop, values) in hops.iter().enumerate() {
            let start = shift_at(nodes.chunk.entry, hop) + first;
            stream[start..start + DOUBLE_LANES].copy_from_slice(values);
        }
    }
}

/// The soils of some nodes, each number lane by lane.
#[inline(always)]
fn soils_of(soils: &Soils, classes: &[Class; DOUBLE_LANES]) -> [[f64; DOUBLE_LANES]; 4] {
    let mut lanes = [[0.0_f64; DOUBLE_LANES]; 4];
    for lane in 0..DOUBLE_LANES {
        let soil = &soils[classes[lane].row()];
        for index in 0..4 {
            lanes[index][lane] = soil[index];
        }
    }
    lanes
}

/// Half a chunk, from an entry on.
#[inline(always)]
fn half<T: Copy + Default>(of: &[T], at: usize) -> [T; DOUBLE_LANES] {
    let mut half = [T::default(); DOUBLE_LANES];
    half.copy_from_slice(&of[at..at + DOUBLE_LANES]);
    half
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cold::correct::SweepOrder;
    use crate::cold::krylov::Krylov;
    use crate::cold::skew::Chunk;
    use crate::cold::wavefront::Wavefront;
    use crate::fixtures::{Fixture, SplitMix64};

    /// Half chunks without nodes are skipped, because entries without a node are 0 whatever came before.
    #[test]
    fn entries_without_a_node_stay_zero() {
        let mut draw = SplitMix64(1);
        let (mut skew, mut planes, mut krylov) = (Skew::default(), Planes::default(), Krylov::default());
        let simd = Simd::detect();
        for seed in 0..60 {
            let (width, height) = (1 + (seed as usize / 2 * 7) % 37, 1 + (seed as usize / 2 * 11) % 29);
            let leaving = if seed % 2 == 0 { Leaving::Stays } else { Leaving::Loses };
            let fixture = Fixture { width, height, leaving, ..Fixture::trap(4, seed) };
            let world = fixture.world().expect("a sound world");
            if skew.fit(&world, Some(fixture.goal())) {
                planes.reset(skew.len);
            }
            let mut is_node = vec![false; skew.len];
            let lanes = |chunk: Chunk| (0..chunk.lanes).map(move |lane| chunk.entry + lane);
            skew.chunks().flat_map(lanes).for_each(|entry| is_node[entry] = true);
            let beside = || (0..skew.len).filter(|entry| !is_node[*entry]);
            planes.load_uniform(simd, &skew, &world, draw.between(-500.0, 100.0));
            let mut change = [0.0; LANES];
            for step in 0..12 {
                let wavefront = Wavefront { sweeps: 1 + step % 5, backwards: draw.uniform() < 0.5 };
                planes.relax(simd, &skew, leaving, false, wavefront, &mut change);
                planes.adopt(simd, &skew);
                if draw.uniform() < 0.5 {
                    planes.hop_residuals(simd, &skew, &world);
                    let (_, shifts) = split(planes.coefficients.all_mut());
                    let zeros = |entry| (0..HOPS).all(|hop| shifts[shift_at(entry, hop)] == 0.0);
                    assert!(beside().all(zeros), "{width} x {height}, seed {seed}, step {step}");
                    planes.relax(simd, &skew, leaving, true, wavefront, &mut change);
                } else {
                    planes.linear_residuals(simd, &skew, &world);
                    let order =
                        if draw.uniform() < 0.5 { SweepOrder::Outwards } else { SweepOrder::Alternating };
                    planes.correct(simd, &skew, &mut krylov, order, 1e-3, u64::MAX);
                    let (coefficients, _) = split(planes.coefficients.all_mut());
                    let zeros =
                        |entry| (0..PARTS).all(|part| coefficients[constant_at(entry) + part * LANES] == 0.0);
                    assert!(beside().all(zeros), "{width} x {height}, seed {seed}, step {step}");
                    let unknown = planes.unknown.all();
                    assert!(
                        beside().all(|entry| unknown[entry] == 0.0),
                        "{width} x {height}, seed {seed}, step {step}"
                    );
                }
                planes.add(simd);
                planes.resume(simd, &skew, &world);
            }
        }
    }
}
