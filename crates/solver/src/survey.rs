//! What each hop is short of, in double precision, over the skewed layout.
//!
//! With δ_u the worth of hop u in Bellman's equation less the value there is, a correction e solves that equation
//! if e = max_u (δ_u + g P_u e), which is what sweeps go on from ([`Planes::relax`]). With the best hops π alone
//! it is linear, e = δ_π + g P_π e, hence
//! e = (δ_π + g Σ_{x′ ≠ x} p e(x′)) / (1 − g p_stay), what [`crate::correct`] solves: Newton's step for
//! Bellman's equation (policy iteration). Either way δ is found in double precision, so single precision is
//! enough for the corrections.
//!
//! The hops are compared in the form of [`crate::sweep`]: both hops along one axis share what slips to the
//! sides, and what stays on the flat is common to all four.

use crate::gather::{Gathered, Nodes};
use crate::simd::{Simd, dispatch};
use crate::skew::{HOPS, LANES, PARTS, Rim, Skew, own, part, shift};
use crate::sweep::{Planes, split};
use crate::world::Class;
use crate::{Leaving, World};

impl Planes {
    /// max |V − TV|, infinite if some value is no number; leaves the shifts of all hops for sweeps, and
    /// corrections of 0.
    pub fn survey(&mut self, simd: Simd, skew: &Skew, world: &World) -> f64 {
        let stays = world.rules().leaving == Leaving::Stays;
        let Self { worths, unknown, ground, .. } = self;
        let (worths, unknown, (_, shifts)) = (worths.all_mut(), unknown.all_mut(), split(ground.all_mut()));
        for &Rim { at, beyond, .. } in skew.rim() {
            worths[beyond] = if stays { worths[at] } else { world.rules().loss };
            unknown[beyond] = 0.0;
            for hop in 0..HOPS {
                shifts[shift(beyond, hop)] = 0.0;
            }
        }
        survey_hops(simd, worths, unknown, shifts, skew, world, &soils(world))
    }

    /// The same; leaves the equation of the best hops' correction instead, the four coefficients in the order
    /// of [`Run::steps`](crate::skew::Run::steps).
    pub fn survey_best(&mut self, simd: Simd, skew: &Skew, world: &World) -> f64 {
        let rules = world.rules();
        let stays = rules.leaving == Leaving::Stays;
        let Self { worths, unknown, ground, .. } = self;
        let (worths, unknown, ground) = (worths.all_mut(), unknown.all_mut(), ground.all_mut());
        for &Rim { at, beyond, .. } in skew.rim() {
            worths[beyond] = if stays { worths[at] } else { rules.loss };
            unknown[beyond] = 0.0;
            ground[own(beyond)] = 0.0;
        }
        let residual = survey_best(simd, worths, unknown, ground, skew, world, &soils(world));
        if stays {
            // What leaves the map stays: e = own + l e + … is e = (own + …) / (1 − l).
            for &Rim { at, step, .. } in skew.rim() {
                let own = own(at);
                let leaves = std::mem::take(&mut ground[own + (1 + step) * LANES]);
                let scale = 1.0 / (1.0 - leaves);
                for index in 0..PARTS {
                    ground[own + index * LANES] *= scale;
                }
            }
        }
        residual
    }

    /// Adds the corrections to the worths.
    pub fn add(&mut self, simd: Simd) {
        add(simd, self.worths.all_mut(), self.unknown.all());
    }
}

/// For each row of classes: g intended, g stuck, g sideways, and γλ of its soil; g the discount between departure
/// and landing.
pub(crate) type Soils = [[f64; 4]; Class::ROWS];

pub(crate) fn soils(world: &World) -> Soils {
    let mut table = [[0.0; 4]; Class::ROWS];
    let discount = world.rules().discount;
    for (entry, soil) in table.iter_mut().zip(&world.rules().soils) {
        let landing = soil.discount(discount);
        *entry =
            [landing * soil.intended, landing * soil.stuck, landing * soil.sideways, discount * soil.wait];
    }
    table
}

dispatch! {
    /// Surveys all nodes; the largest deviation. The shifts of all hops go into `stream`.
    fn survey_hops(
        worths: &[f64], unknown: &mut [f32], stream: &mut [f32], skew: &Skew, world: &World, soils: &Soils,
    ) -> f64 = survey_lanes::<false>
}

dispatch! {
    /// Surveys all nodes; the largest deviation. The equation of the best hops goes into `stream`.
    fn survey_best(
        worths: &[f64], unknown: &mut [f32], stream: &mut [f32], skew: &Skew, world: &World, soils: &Soils,
    ) -> f64 = survey_lanes::<true>
}

#[inline(always)]
fn survey_lanes<const BEST: bool>(
    worths: &[f64],
    unknown: &mut [f32],
    stream: &mut [f32],
    skew: &Skew,
    world: &World,
    soils: &Soils,
) -> f64 {
    let flip = skew.flip.map(|flip| if flip { -1.0 } else { 1.0 });
    let mut seen = Seen::default();
    let mut blocks = skew.blocks();
    let mut gathered = Gathered::new();
    loop {
        let chunks = gathered.next(&mut blocks, world);
        if chunks == 0 {
            break;
        }
        for index in 0..chunks {
            let nodes = gathered.nodes(index);
            survey_half::<BEST>(worths, stream, nodes, 0, soils, flip, &mut seen);
            // The last chunk of a diagonal often has no nodes there: what lies beside the nodes is zeros already.
            if nodes.block.lanes > HALF {
                survey_half::<BEST>(worths, stream, nodes, HALF, soils, flip, &mut seen);
            }
            unknown[nodes.block.entry..][..LANES].fill(0.0);
        }
    }
    if seen.unsound == [0.0; HALF] { seen.residual.into_iter().fold(0.0, f64::max) } else { f64::INFINITY }
}

/// Lanes that are surveyed together: what the widest vector holds in double precision.
const HALF: usize = LANES / 2;

/// What was met so far, lane by lane.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// The largest deviation.
    residual: [f64; HALF],
    /// Not 0 if some deviation was no number.
    unsound: [f64; HALF],
}

/// Surveys the nodes of a chunk from its lane `first` on.
#[inline(always)]
fn survey_half<const BEST: bool>(
    worths: &[f64],
    stream: &mut [f32],
    nodes: Nodes<'_>,
    first: usize,
    soils: &Soils,
    flip: [f64; 2],
    seen: &mut Seen,
) {
    // No closures in here: they would be compiled without the vector instructions, and be called.
    let (payoffs, classes) = (half(nodes.payoffs, first), half(nodes.classes, first));
    let (slopes_i, slopes_j) = (half(&nodes.slopes[0], first), half(&nodes.slopes[1], first));
    let [mut intended, mut stuck, mut sideways, mut waits] = [[0.0_f64; HALF]; 4];
    for lane in 0..HALF {
        let soil = &soils[classes[lane].row()];
        intended[lane] = soil[0];
        stuck[lane] = soil[1];
        sideways[lane] = soil[2];
        waits[lane] = soil[3];
    }
    let (at, steps) = (nodes.block.entry + first, nodes.block.steps);
    let here = half(worths, at);
    let low_i = half(worths, at.wrapping_add_signed(steps[0]));
    let low_j = half(worths, at.wrapping_add_signed(steps[1]));
    let high_i = half(worths, at.wrapping_add_signed(steps[2]));
    let high_j = half(worths, at.wrapping_add_signed(steps[3]));
    let mut parts = [[0.0_f32; HALF]; PARTS];
    let mut hops = [[0.0_f32; HALF]; HOPS];
    for lane in 0..HALF {
        let (a, c, q) = (intended[lane], sideways[lane], stuck[lane]);
        let (s, t) = (slopes_i[lane] * flip[0], slopes_j[lane] * flip[1]);
        let along_i = c * ((low_j[lane] + high_j[lane]) + t * (high_j[lane] - low_j[lane]));
        let along_j = c * ((low_i[lane] + high_i[lane]) + s * (high_i[lane] - low_i[lane]));
        // As the sweeps see it.
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
        let deviation = best + same;
        let free = classes[lane].is_free();
        let size = if free { deviation.abs() } else { 0.0 };
        seen.unsound[lane] = if size < f64::INFINITY { seen.unsound[lane] } else { 1.0 };
        seen.residual[lane] = if size > seen.residual[lane] { size } else { seen.residual[lane] };
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
        parts[0][lane] = if free { deviation as f32 * scale } else { 0.0 };
        parts[1][lane] = if is_i { ahead_low_i } else { slip_low };
        parts[2][lane] = if is_i { slip_low } else { ahead_low_j };
        parts[3][lane] = if is_i { ahead_high_i } else { slip_high };
        parts[4][lane] = if is_i { slip_high } else { ahead_high_j };
    }
    if BEST {
        for (index, values) in parts.iter().enumerate() {
            let part = part(nodes.block.entry, index) + first;
            stream[part..part + HALF].copy_from_slice(values);
        }
    } else {
        for (hop, values) in hops.iter().enumerate() {
            let shift = shift(nodes.block.entry, hop) + first;
            stream[shift..shift + HALF].copy_from_slice(values);
        }
    }
}

/// Half a chunk, from an entry on.
#[inline(always)]
fn half<T: Copy + Default>(of: &[T], at: usize) -> [T; HALF] {
    let mut half = [T::default(); HALF];
    half.copy_from_slice(&of[at..at + HALF]);
    half
}

dispatch! {
    /// y += x.
    fn add(y: &mut [f64], x: &[f32]) = add_lanes
}

#[inline(always)]
fn add_lanes(y: &mut [f64], x: &[f32]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += f64::from(*x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::{Course, Krylov};
    use crate::skew::Block;
    use crate::specimen::{Draw, Specimen};
    use crate::wave::Wave;

    /// Half chunks without nodes are not surveyed, because what lies beside the nodes is zeros whatever came before.
    #[test]
    fn what_lies_beside_the_nodes_stays_zeros() {
        let mut draw = Draw(1);
        let (mut skew, mut planes, mut krylov) = (Skew::default(), Planes::default(), Krylov::default());
        let simd = Simd::detect();
        for seed in 0..60 {
            let (width, height) = (1 + (seed as usize / 2 * 7) % 37, 1 + (seed as usize / 2 * 11) % 29);
            let leaving = if seed % 2 == 0 { Leaving::Stays } else { Leaving::Loses };
            let specimen = Specimen { width, height, leaving, ..Specimen::trap(4, seed) };
            let world = specimen.world().expect("a sound world");
            if skew.fit(&world, Some(specimen.goal())) {
                planes.reset(skew.len);
            }
            let mut is_node = vec![false; skew.len];
            let lanes = |block: Block| (0..block.lanes).map(move |lane| block.entry + lane);
            skew.blocks().flat_map(lanes).for_each(|entry| is_node[entry] = true);
            let beside = || (0..skew.len).filter(|entry| !is_node[*entry]);
            planes.start(simd, &skew, &world, draw.between(-500.0, 100.0));
            let mut change = [0.0; LANES];
            for step in 0..12 {
                let wave = Wave { sweeps: 1 + step % 5, back: draw.uniform() < 0.5 };
                planes.relax(simd, &skew, leaving, false, wave, &mut change);
                planes.adopt(simd, &skew);
                if draw.uniform() < 0.5 {
                    planes.survey(simd, &skew, &world);
                    let (_, shifts) = split(planes.ground.all_mut());
                    let zeros = |entry| (0..HOPS).all(|hop| shifts[shift(entry, hop)] == 0.0);
                    assert!(beside().all(zeros), "{width} x {height}, seed {seed}, step {step}");
                    planes.relax(simd, &skew, leaving, true, wave, &mut change);
                } else {
                    planes.survey_best(simd, &skew, &world);
                    let course = if draw.uniform() < 0.5 { Course::Outwards } else { Course::Around };
                    planes.correct(simd, &skew, &mut krylov, course, 1e-3, u64::MAX);
                    let (ground, _) = split(planes.ground.all_mut());
                    let zeros = |entry| (0..PARTS).all(|part| ground[own(entry) + part * LANES] == 0.0);
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
