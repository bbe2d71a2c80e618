//! Bellman's residual in double precision, row by row, operation for operation as in [`crate::bellman`].
//!
//! It is the certificate's sweep: it reads the world and the values as they are handed out, and shares
//! nothing with the kernels and the layout that made them.

use std::ops::Range;

use crate::simd::{Simd, dispatch};
use crate::world::Class;
use crate::{Leaving, Rules, World};

/// Lanes of a chunk in double precision.
const LANES: usize = 8;

/// Nodes of a panel: rows are measured in panels, so that the worths of a few of its rows stay at hand.
const PANEL: usize = 512;

/// Rows at hand: the one that is measured, the two beside it, and the next.
const ROWS: usize = 4;

/// Worths along one row of a panel, from the node before it to the node after it.
type Worths = [f64; PANEL + 2];

/// What a survey found over all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Findings {
    /// max |V − TV|; infinite if some value is no number.
    pub residual: f64,
    /// The largest |r| + |V| and |loss| met.
    pub worth_max: f64,
}

/// Measures `values`.
pub(crate) fn run(simd: Simd, world: &World, values: &[f64]) -> Findings {
    let (width, height) = (world.width(), world.height());
    let rules = world.rules();
    let soils = soils(rules);
    let mut seen = Seen::default();
    for start in (0..width).step_by(PANEL) {
        let columns = start..width.min(start + PANEL);
        let mut worths = [[0.0; PANEL + 2]; ROWS];
        worths_of(simd, world, values, &columns, 0, &mut worths[1]);
        beyond(rules, &mut worths, [1, 0], columns.len());
        if height > 1 {
            worths_of(simd, world, values, &columns, 1, &mut worths[2]);
        }
        for y in 0..height {
            // A row ahead, so that nothing waits for what is written here.
            if y + 2 < height {
                worths_of(simd, world, values, &columns, y + 2, &mut worths[(y + 3) % ROWS]);
            } else if y + 1 == height {
                beyond(rules, &mut worths, [(y + 1) % ROWS, (y + 2) % ROWS], columns.len());
            }
            let [south, here, north] = [0, 1, 2].map(|row| &worths[(y + row) % ROWS]);
            let (payoffs, east, north_up, classes) = world.row(y);
            let inputs = Inputs {
                values: &values[y * width..][columns.clone()],
                payoffs: &payoffs[columns.clone()],
                slopes_east: &east[columns.clone()],
                slopes_north: &north_up[columns.clone()],
                classes: &classes[columns.clone()],
            };
            measure(simd, rules.discount, &soils, south, here, north, &inputs, &mut seen);
        }
    }
    let Seen { residual, worth_max, unsound } = seen;
    Findings {
        residual: if unsound == [0.0; LANES] { largest(residual) } else { f64::INFINITY },
        worth_max: largest(worth_max).max(rules.loss.abs()),
    }
}

/// For each row of classes: the shares intended, stuck and sideways, and the wait, of its soil.
type Soils = [[f64; 4]; Class::ROWS];

fn soils(rules: &Rules) -> Soils {
    let mut table = [[0.0; 4]; Class::ROWS];
    for (row, soil) in table.iter_mut().zip(&rules.soils) {
        *row = [soil.intended, soil.stuck, soil.sideways, soil.wait];
    }
    table
}

fn largest(lanes: [f64; LANES]) -> f64 {
    lanes.into_iter().fold(0.0, f64::max)
}

/// What was met so far, lane by lane.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// The largest deviation.
    residual: [f64; LANES],
    /// The largest |r| + |V|.
    worth_max: [f64; LANES],
    /// Not 0 if some deviation was no number.
    unsound: [f64; LANES],
}

/// What is read along one row of a panel.
struct Inputs<'a> {
    values: &'a [f64],
    payoffs: &'a [f64],
    slopes_east: &'a [f64],
    slopes_north: &'a [f64],
    classes: &'a [Class],
}

fn worths_of(simd: Simd, world: &World, values: &[f64], columns: &Range<usize>, y: usize, into: &mut Worths) {
    let (payoffs, _, _, classes) = world.row(y);
    let (width, loss) = (payoffs.len(), world.rules().loss);
    let inside = columns.start.saturating_sub(1)..width.min(columns.end + 1);
    let shift = inside.start + 1 - columns.start;
    let values = &values[y * width..(y + 1) * width][inside.clone()];
    land(simd, &mut into[shift..], &payoffs[inside.clone()], values, &classes[inside], loss);
    let stays = world.rules().leaving == Leaving::Stays;
    if columns.start == 0 {
        into[0] = if stays { into[1] } else { loss };
    }
    if columns.end == width {
        into[columns.len() + 1] = if stays { into[columns.len()] } else { loss };
    }
}

dispatch! {
    /// The worths of landing on some nodes.
    fn land(into: &mut [f64], payoffs: &[f64], values: &[f64], classes: &[Class], loss: f64) = land_lanes
}

#[inline(always)]
fn land_lanes(into: &mut [f64], payoffs: &[f64], values: &[f64], classes: &[Class], loss: f64) {
    let nodes = payoffs.len();
    let (into, values, classes) = (&mut into[..nodes], &values[..nodes], &classes[..nodes]);
    for x in 0..nodes {
        let sum = payoffs[x] + values[x];
        let landed = if classes[x].is_free() { sum } else { payoffs[x] };
        into[x] = if classes[x].is_lost() { loss } else { landed };
    }
}

/// Fills the second row, which lies beyond the map's edge, beside the first.
fn beyond(rules: &Rules, worths: &mut [Worths; ROWS], [edge, row]: [usize; 2], nodes: usize) {
    let [edge, row] = worths.get_disjoint_mut([edge, row]).expect("two rows of four");
    if rules.leaving == Leaving::Stays {
        row[..nodes + 2].copy_from_slice(&edge[..nodes + 2]);
    } else {
        row[..nodes + 2].fill(rules.loss);
    }
}

dispatch! {
    /// Measures one row.
    fn measure(
        discount: f64, soils: &Soils, souths: &Worths, heres: &Worths, norths: &Worths, inputs: &Inputs<'_>,
        seen: &mut Seen,
    ) = measure_lanes
}

/// Eight from `at` on; `beyond` past the end.
#[inline(always)]
fn chunk<T: Copy>(of: &[T], at: usize, beyond: T) -> [T; LANES] {
    let mut chunk = [beyond; LANES];
    if at + LANES <= of.len() {
        chunk.copy_from_slice(&of[at..at + LANES]);
    } else {
        let rest = &of[at..];
        chunk[..rest.len()].copy_from_slice(rest);
    }
    chunk
}

#[inline(always)]
#[allow(
    clippy::needless_range_loop,
    reason = "a lane is a lane of many arrays, and closures are not inlined"
)]
fn measure_lanes(
    discount: f64,
    soils: &Soils,
    souths: &Worths,
    heres: &Worths,
    norths: &Worths,
    inputs: &Inputs<'_>,
    seen: &mut Seen,
) {
    // No closures in here: they would be compiled without the vector instructions, and be called.
    let Seen { mut residual, mut worth_max, mut unsound } = *seen;
    for start in (0..inputs.values.len()).step_by(LANES) {
        // What is left at the end is measured together with what was measured before it.
        let at = start.min(inputs.values.len().saturating_sub(LANES));
        let (value, payoff) = (chunk(inputs.values, at, 0.0), chunk(inputs.payoffs, at, 0.0));
        let (east, north) = (chunk(inputs.slopes_east, at, 0.0), chunk(inputs.slopes_north, at, 0.0));
        let classes = chunk(inputs.classes, at, Class::LOST);
        let [mut intended, mut stuck, mut sideways, mut waits] = [[0.0; LANES]; 4];
        // 1 where it is so, 0 elsewhere.
        let [mut is_free, mut is_lost] = [[0.0; LANES]; 2];
        for l in 0..LANES {
            let soil = &soils[classes[l].row()];
            intended[l] = soil[0];
            stuck[l] = soil[1];
            sideways[l] = soil[2];
            waits[l] = soil[3];
        }
        for l in 0..LANES {
            is_free[l] = if classes[l].is_free() { 1.0 } else { 0.0 };
            is_lost[l] = if classes[l].is_lost() { 1.0 } else { 0.0 };
        }
        let (w_here, w_north, w_south) =
            (chunk(heres, at + 1, 0.0), chunk(norths, at + 1, 0.0), chunk(souths, at + 1, 0.0));
        let (w_west, w_east) = (chunk(heres, at, 0.0), chunk(heres, at + 2, 0.0));
        for l in 0..LANES {
            let free = is_free[l] > 0.0;
            let wait = waits[l];
            // (slope ahead, slope to the right), worths ahead, to the left, to the right.
            let hops = [
                (north[l], east[l], w_north[l], w_west[l], w_east[l]),
                (east[l], -north[l], w_east[l], w_north[l], w_south[l]),
                (-north[l], -east[l], w_south[l], w_east[l], w_west[l]),
                (-east[l], north[l], w_west[l], w_south[l], w_north[l]),
            ];
            let then = 1.0 - wait + wait * discount;
            let mut best = f64::NEG_INFINITY;
            for index in 0..4 {
                let (ahead, right_up, w_ahead, w_left, w_right) = hops[index];
                let forwards = if ahead > 0.0 { ahead } else { 0.0 };
                let p = intended[l] * (1.0 - forwards);
                let stayed = intended[l] * forwards + stuck[l];
                let left = sideways[l] * (1.0 - right_up);
                let rest = 1.0 - (p + stayed + left);
                let right = if rest > 0.0 { rest } else { 0.0 };
                let next = p * w_ahead + stayed * w_here[l] + left * w_left + right * w_right;
                let worth = discount * (wait * payoff[l] + then * next);
                best = if worth > best { worth } else { best };
            }
            let deviation = best - value[l];
            let size = if free { deviation.abs() } else { 0.0 };
            unsound[l] = if size < f64::INFINITY { unsound[l] } else { 1.0 };
            residual[l] = if size > residual[l] { size } else { residual[l] };
            let size = if is_lost[l] > 0.0 {
                0.0
            } else {
                payoff[l].abs() + if free { value[l].abs() } else { 0.0 }
            };
            worth_max[l] = if size > worth_max[l] { size } else { worth_max[l] };
        }
    }
    *seen = Seen { residual, worth_max, unsound };
}
