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
//!
//! What slips outwards comes back: where a node's worth grows, that of the nodes further out will grow likewise,
//! and come back by the share c. A new worth therefore goes beyond Bellman's by [`OVER`] c of its change
//! (successive over-relaxation, with a factor of its own at each node), which leaves the fixed point where it is
//! and takes a smooth error down several times faster. All of it, factor 1, overshoots, and a worth that is too
//! high comes down only by γ a sweep.
//!
//! **Shifted.** With W the worths there are and e a correction to them, T(W + e) − W has the same form, but
//! for ρ, in place of which each of the four candidates has its own shift δ / D, δ what the hop is short of
//! under W ([`crate::survey`]). So the kernel that sweeps for worths sweeps for corrections as well, best hops
//! and all, and single precision then holds the correction to seven digits where it held the worths.
//!
//! Beyond the map lies the loss, or, where leaving counts as staying, the last worth of the border node
//! itself: the same fixed point, approached from one sweep to the next.

use std::cell::Cell;

use crate::gather::{Gathered, Nodes};
use crate::pair::{Part, Progress, Shared};
use crate::plane::Plane;
use crate::simd::{Simd, dispatch};
use crate::skew::{Around, HOPS, LANES, Lanes, PARTS, Rim, Run, Skew, chunk, own, part, shift};
use crate::wave::Wave;
use crate::world::Class;
use crate::{Leaving, Rules, World, survey};

/// What lies in the entries of a layout.
#[derive(Clone, Debug, Default)]
pub(crate) struct Planes {
    /// Threads that sweep large worlds in single precision: two if more than one.
    pub threads: usize,
    /// The worths that the next survey takes for true.
    pub worths: Plane<f64>,
    /// What is solved for in single precision: worths here, corrections in the linear solve.
    pub unknown: Plane<f32>,
    /// What each node has of its own, here ρ, a, c and the slopes along i and j, chunk by chunk ([`part`]); behind
    /// it, where corrections are swept for, what each of the four kinds of hop is short of ([`shift`]). In one
    /// plane, so that most of all memory is one piece, which allocators hand out again as it is.
    pub ground: Plane<f32>,
}

/// The ground, and the shifts behind it.
pub(crate) fn split(ground: &mut [f32]) -> (&mut [f32], &mut [f32]) {
    let entries = ground.len() / (PARTS + HOPS);
    ground.split_at_mut(PARTS * entries)
}

impl Planes {
    /// Planes of `len` entries, zeros. What lies beside the grid and its halo is never anything else after.
    pub fn reset(&mut self, len: usize) {
        self.worths.reset(len);
        self.unknown.reset(len);
        self.ground.reset((PARTS + HOPS) * len);
    }

    /// Begins a world in which every free node has the value `value`.
    pub fn start(&mut self, simd: Simd, skew: &Skew, world: &World, value: f64) {
        self.load(simd, skew, world, From::Same(value));
    }

    /// Begins anew from `values`, row-major.
    pub fn lay(&mut self, simd: Simd, skew: &Skew, world: &World, values: &[f64]) {
        self.load(simd, skew, world, From::Values(values));
    }

    /// Goes on from the worths there are.
    pub fn resume(&mut self, simd: Simd, skew: &Skew, world: &World) {
        self.load(simd, skew, world, From::Kept);
    }

    /// Lays the world out for sweeps.
    fn load(&mut self, simd: Simd, skew: &Skew, world: &World, from: From<'_>) {
        let Self { worths, unknown, ground, .. } = self;
        load(simd, worths.all_mut(), unknown.all_mut(), ground.all_mut(), skew, world, &soils(world), from);
        self.halo(skew, world.rules());
    }

    /// Ends the sweeps: their worths are the worths now, where there was anything to decide.
    pub fn adopt(&mut self, simd: Simd, skew: &Skew) {
        let Self { worths, unknown, ground, .. } = self;
        adopt(simd, worths.all_mut(), unknown.all(), ground.all(), skew);
    }

    /// Takes the values out, row-major: 0 at a goal, the loss where lost.
    pub fn take_out(&self, simd: Simd, skew: &Skew, world: &World, values: &mut [f64]) {
        take_out(simd, self.worths.all(), skew, world, values);
    }

    /// Fills the halo: with the loss, or with the worths of the border.
    fn halo(&mut self, skew: &Skew, rules: &Rules) {
        let stays = rules.leaving == Leaving::Stays;
        let (unknown, ground) = (self.unknown.all_mut(), self.ground.all_mut());
        for &Rim { at, beyond, .. } in skew.rim() {
            unknown[beyond] = if stays { unknown[at] } else { rules.loss as f32 };
            ground[own(beyond)] = unknown[beyond];
        }
    }

    /// Updates the worths in a wave, or the corrections where `shifted`; the largest change of its last sweep,
    /// lane by lane, goes into `change`.
    pub fn relax(
        &mut self,
        simd: Simd,
        skew: &Skew,
        leaving: Leaving,
        shifted: bool,
        wave: Wave,
        change: &mut Lanes,
    ) {
        let stays = leaving == Leaving::Stays;
        let Self { threads, unknown, ground, .. } = self;
        let (ground, shifts) = split(ground.all_mut());
        let [worths, ground, shifts] = [unknown.all_mut(), ground, shifts].map(Shared::new);
        let planes = Swept { worths, ground, shifts };
        let sweep = move |wave, part: Part<'_>, change: &mut Lanes| {
            let relax = if shifted { relax_shifted } else { relax };
            relax(simd, planes, skew, stays, wave, part, change);
        };
        if *threads < 2 || wave.sweeps < 2 || skew.width * skew.height < PAIR_NODES_MIN {
            return sweep(wave, Part::Whole, change);
        }
        let progress = Progress::default();
        let first = Wave { sweeps: wave.sweeps / 2, ..wave };
        let last = Wave { sweeps: wave.sweeps - first.sweeps, ..wave };
        std::thread::scope(|scope| {
            let leader = Part::Leader(&progress);
            scope.spawn(move || sweep(first, leader, &mut [0.0; LANES]));
            sweep(last, Part::Follower(&progress), change);
        });
    }
}

/// What the free nodes' worths begin from.
#[derive(Clone, Copy, Debug)]
enum From<'a> {
    /// One value everywhere.
    Same(f64),
    /// A value of each node, row-major.
    Values(&'a [f64]),
    /// The worths there are, in a layout that has not changed.
    Kept,
}

/// What a sweep in single precision reads and writes.
#[derive(Clone, Copy, Debug)]
struct Swept<'a> {
    worths: Shared<'a>,
    ground: Shared<'a>,
    shifts: Shared<'a>,
}

/// Nodes of a world that is worth a second thread.
const PAIR_NODES_MIN: usize = 10_000;

/// For each row of classes: ρ per payoff, a and c of its soil.
type Soils = [[f32; 3]; Class::ROWS];

fn soils(world: &World) -> Soils {
    survey::soils(world).map(|[intended, stuck, sideways, wait]| {
        let moves = 1.0 - stuck;
        [(1.0 + wait) / moves, intended / moves, sideways / moves].map(|number| number as f32)
    })
}

dispatch! {
    /// Lays the world out for sweeps.
    fn load(
        worths: &mut [f64], unknown: &mut [f32], ground: &mut [f32], skew: &Skew, world: &World, soils: &Soils,
        from: From<'_>,
    ) = load_lanes
}

#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "a kernel takes its planes one by one")]
fn load_lanes(
    worths: &mut [f64],
    unknown: &mut [f32],
    ground: &mut [f32],
    skew: &Skew,
    world: &World,
    soils: &Soils,
    from: From<'_>,
) {
    let loss = world.rules().loss;
    let flip_i = if skew.flip[0] { -1.0 } else { 1.0 };
    let flip_j = if skew.flip[1] { -1.0 } else { 1.0 };
    let mut blocks = skew.blocks();
    let mut gathered = Gathered::new();
    loop {
        let chunks = gathered.next(&mut blocks, world);
        if chunks == 0 {
            break;
        }
        for index in 0..chunks {
            let Nodes { block, payoffs, slopes: [slopes_i, slopes_j], classes } = gathered.nodes(index);
            let at = block.entry;
            let mut landed = chunk(worths, at);
            match from {
                From::Kept => {}
                From::Same(value) => {
                    for lane in 0..LANES {
                        landed[lane] = payoffs[lane] + value;
                    }
                }
                From::Values(values) => {
                    for lane in 0..block.lanes {
                        landed[lane] = payoffs[lane] + values[block.at(lane)];
                    }
                }
            }
            let mut parts = [[0.0_f32; LANES]; PARTS];
            for lane in 0..LANES {
                let [per_payoff, a, c] = soils[classes[lane].row()];
                parts[0][lane] = payoffs[lane] as f32 * per_payoff;
                parts[1][lane] = a;
                parts[2][lane] = c;
            }
            for lane in 0..LANES {
                let free = classes[lane].is_free();
                let ends = if classes[lane].is_lost() { loss } else { payoffs[lane] };
                landed[lane] = if free { landed[lane] } else { ends };
                parts[0][lane] = if free { parts[0][lane] } else { ends as f32 };
                parts[3][lane] = (slopes_i[lane] * flip_i) as f32;
                parts[4][lane] = (slopes_j[lane] * flip_j) as f32;
            }
            for lane in block.lanes..LANES {
                landed[lane] = 0.0;
                for values in &mut parts {
                    values[lane] = 0.0;
                }
            }
            worths[at..at + LANES].copy_from_slice(&landed);
            for lane in 0..LANES {
                unknown[at + lane] = landed[lane] as f32;
            }
            for (index, values) in parts.iter().enumerate() {
                let part = part(at, index);
                ground[part..part + LANES].copy_from_slice(values);
            }
        }
    }
}

dispatch! {
    /// The values of all nodes.
    fn take_out(worths: &[f64], skew: &Skew, world: &World, values: &mut [f64]) = take_out_lanes
}

#[inline(always)]
fn take_out_lanes(worths: &[f64], skew: &Skew, world: &World, values: &mut [f64]) {
    let loss = world.rules().loss;
    let (payoffs, classes) = world.payoffs();
    for block in skew.blocks() {
        for lane in 0..block.lanes {
            let (node, worth) = (block.at(lane), worths[block.entry + lane]);
            let ends = if classes[node].is_lost() { loss } else { 0.0 };
            values[node] = if classes[node].is_free() { worth - payoffs[node] } else { ends };
        }
    }
}

dispatch! {
    /// Takes over the worths of the nodes that are updated.
    fn adopt(worths: &mut [f64], unknown: &[f32], ground: &[f32], skew: &Skew) = adopt_lanes
}

#[inline(always)]
fn adopt_lanes(worths: &mut [f64], unknown: &[f32], ground: &[f32], skew: &Skew) {
    for run in skew.runs() {
        for at in (run.first()..run.first() + run.nodes()).step_by(LANES) {
            let (ahead, beside) = (chunk(ground, part(at, 1)), chunk(ground, part(at, 2)));
            let (mut landed, single) = (chunk(worths, at), chunk(unknown, at));
            for lane in 0..LANES {
                let updated = ahead[lane] + beside[lane] > 0.0;
                landed[lane] = if updated { f64::from(single[lane]) } else { landed[lane] };
            }
            worths[at..at + LANES].copy_from_slice(&landed);
        }
    }
}

dispatch! {
    /// Updates the worths in a wave.
    fn relax(planes: Swept<'_>, skew: &Skew, stays: bool, wave: Wave, part: Part<'_>, change: &mut Lanes)
        = relax_lanes::<false>
}

dispatch! {
    /// Updates the corrections in a wave.
    fn relax_shifted(planes: Swept<'_>, skew: &Skew, stays: bool, wave: Wave, part: Part<'_>, change: &mut Lanes)
        = relax_lanes::<true>
}

#[inline(always)]
fn relax_lanes<const SHIFTED: bool>(
    planes: Swept<'_>,
    skew: &Skew,
    stays: bool,
    wave: Wave,
    part: Part<'_>,
    change: &mut Lanes,
) {
    let [worths, ground, shifts] = [planes.worths, planes.ground, planes.shifts].map(Shared::cells);
    // No closures in here: they would be compiled without the vector instructions, and be called.
    let runs = skew.runs();
    let diagonals = runs.len();
    for step in 0..wave.steps(diagonals) {
        part.begin(step, diagonals);
        for sweep in wave.at(diagonals, step) {
            let run = &runs[wave.diagonal(diagonals, step, sweep)];
            if stays && step == 2 * sweep {
                mirror::<SHIFTED>(worths, ground, shifts, skew.rim_of(run));
            }
            if sweep + 1 == wave.sweeps {
                relax_run::<SHIFTED, true>(worths, ground, shifts, run, change);
            } else {
                relax_run::<SHIFTED, false>(worths, ground, shifts, run, change);
            }
            // A step ahead, so that nothing waits for what is written here.
            if stays && step - 2 * sweep + 1 < diagonals {
                let next = &runs[wave.diagonal(diagonals, step + 1, sweep)];
                mirror::<SHIFTED>(worths, ground, shifts, skew.rim_of(next));
            }
        }
        part.finish((step + 1).saturating_sub(2 * (wave.sweeps - 1)));
    }
}

/// Lays worths of the rim out beyond it.
#[inline(always)]
fn mirror<const SHIFTED: bool>(
    worths: &[Cell<f32>],
    ground: &[Cell<f32>],
    shifts: &[Cell<f32>],
    rim: &[Rim],
) {
    for &Rim { at, beyond, .. } in rim {
        worths[beyond].set(worths[at].get());
        // What stands beyond the rim is a constant to the chunk that it lies in.
        if SHIFTED {
            for index in 0..HOPS {
                shifts[shift(beyond, index)].set(worths[at].get());
            }
        } else {
            ground[own(beyond)].set(worths[at].get());
        }
    }
}

/// Updates a diagonal; the largest change goes into `change` in the `LAST` sweep.
#[inline(always)]
fn relax_run<const SHIFTED: bool, const LAST: bool>(
    worths: &[Cell<f32>],
    ground: &[Cell<f32>],
    shifts: &[Cell<f32>],
    run: &Run,
    change: &mut Lanes,
) {
    let around = Around::new(worths, run);
    let chunks = around.chunks();
    let ground = &ground[part(run.first(), 0)..].as_chunks::<{ PARTS * LANES }>().0[..chunks];
    let shifts = if SHIFTED { &shifts[shift(run.first(), 0)..].as_chunks().0[..chunks] } else { &[] };
    for (index, parts) in ground.iter().enumerate() {
        let [low_i, low_j, high_i, high_j, old] = around.chunk(index);
        let (ahead, beside) = (cells(parts, LANES), cells(parts, 2 * LANES));
        let (slope_i, slope_j) = (cells(parts, 3 * LANES), cells(parts, 4 * LANES));
        // Of the hops up and down along i, up and down along j.
        let owns = if SHIFTED {
            let own: &[Cell<f32>; HOPS * LANES] = &shifts[index];
            [cells(own, 0), cells(own, LANES), cells(own, 2 * LANES), cells(own, 3 * LANES)]
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
            let (uphill_i, downhill_i) = (owns[0][lane] + along_i, owns[1][lane] + along_i);
            let (uphill_j, downhill_j) = (owns[2][lane] + along_j, owns[3][lane] + along_j);
            let (lost_i, lost_j) = (a * s.abs(), a * t.abs());
            let (over_i, over_j) = (uphill_i + (a - lost_i) * up_i, uphill_j + (a - lost_j) * up_j);
            let (under_i, under_j) = (1.0 - lost_i, 1.0 - lost_j);
            let first = over_i * under_j > over_j * under_i;
            let over = if first { over_i } else { over_j };
            let under = if first { under_i } else { under_j };
            let uphill = over / under;
            let downhill_i = downhill_i + a * down_i;
            let downhill_j = downhill_j + a * down_j;
            let downhill = if downhill_i > downhill_j { downhill_i } else { downhill_j };
            let best = if uphill > downhill { uphill } else { downhill };
            new[lane] = best + OVER * c * (best - old[lane]);
        }
        if LAST {
            for lane in 0..LANES {
                let moved = (new[lane] - old[lane]).abs();
                change[lane] = if moved > change[lane] { moved } else { change[lane] };
            }
        }
        around.set(index, &new);
    }
}

/// Share of what flows back outwards that is anticipated.
const OVER: f32 = 0.6;

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
