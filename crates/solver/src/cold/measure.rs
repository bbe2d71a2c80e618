//! The certificate's sweep: Bellman's residual in double precision, row by row, with the same operations as
//! [`crate::bellman`].
//!
//! It reads the world and the values as they are handed out, and shares no code with the kernels and the layout that
//! computed them.

use std::ops::Range;

use crate::grid_world::Class;
use crate::simd::{DOUBLE_LANES as LANES, Simd, dispatch};
use crate::{GridWorld, Leaving, Rules};

/// Columns of a panel. Rows are measured panel by panel, so that the afterstate values of a few rows stay in cache.
const PANEL: usize = 512;

/// Rows in the buffer: the one being measured, the two beside it, and the next.
const ROWS: usize = 4;

/// Afterstate values of one row of a panel, with the node before it and the node after it.
type Afterstates = [f64; PANEL + 2];

/// Maxima over all nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Measured {
    /// max |V − TV|; infinite if some value is not finite.
    pub residual: f64,
    /// The largest of |r| + |V| and |loss|.
    pub afterstate_max: f64,
}

/// Measures the residual of `values`, row-major.
pub(crate) fn run(simd: Simd, world: &GridWorld, values: &[f64]) -> Measured {
    let (width, height) = (world.width(), world.height());
    let rules = world.rules();
    let soils = soils(rules);
    let mut maxima = Maxima::default();
    for start in (0..width).step_by(PANEL) {
        let columns = start..width.min(start + PANEL);
        let mut afterstates = [[0.0; PANEL + 2]; ROWS];
        afterstates_of(simd, world, values, &columns, 0, &mut afterstates[1]);
        fill_outside(rules, &mut afterstates, [1, 0], columns.len());
        if height > 1 {
            afterstates_of(simd, world, values, &columns, 1, &mut afterstates[2]);
        }
        for y in 0..height {
            // One row ahead, so that no read waits for these writes.
            if y + 2 < height {
                afterstates_of(simd, world, values, &columns, y + 2, &mut afterstates[(y + 3) % ROWS]);
            } else if y + 1 == height {
                fill_outside(rules, &mut afterstates, [(y + 1) % ROWS, (y + 2) % ROWS], columns.len());
            }
            let [south, here, north] = [0, 1, 2].map(|row| &afterstates[(y + row) % ROWS]);
            let (payoffs, east, north_up, classes) = world.row(y);
            let inputs = Inputs {
                values: &values[y * width..][columns.clone()],
                payoffs: &payoffs[columns.clone()],
                slopes_east: &east[columns.clone()],
                slopes_north: &north_up[columns.clone()],
                classes: &classes[columns.clone()],
            };
            measure(simd, rules.discount, &soils, south, here, north, &inputs, &mut maxima);
        }
    }
    let Maxima { residual, afterstate_max, not_finite } = maxima;
    Measured {
        residual: if not_finite == [0.0; LANES] { largest(residual) } else { f64::INFINITY },
        afterstate_max: largest(afterstate_max).max(rules.loss.abs()),
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

/// Maxima over the nodes so far, lane by lane.
#[derive(Clone, Copy, Debug, Default)]
struct Maxima {
    /// The largest |V − TV|.
    residual: [f64; LANES],
    /// The largest |r| + |V|.
    afterstate_max: [f64; LANES],
    /// Not 0 if some residual was not finite.
    not_finite: [f64; LANES],
}

/// The world's numbers along one row of a panel.
struct Inputs<'a> {
    values: &'a [f64],
    payoffs: &'a [f64],
    slopes_east: &'a [f64],
    slopes_north: &'a [f64],
    classes: &'a [Class],
}

fn afterstates_of(
    simd: Simd,
    world: &GridWorld,
    values: &[f64],
    columns: &Range<usize>,
    y: usize,
    into: &mut Afterstates,
) {
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
    /// Afterstate values of some nodes.
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

/// Fills buffer row `row`, which lies outside the map, beside the border row `edge`.
fn fill_outside(rules: &Rules, afterstates: &mut [Afterstates; ROWS], [edge, row]: [usize; 2], nodes: usize) {
    let [edge, row] = afterstates.get_disjoint_mut([edge, row]).expect("two rows of four");
    if rules.leaving == Leaving::Stays {
        row[..nodes + 2].copy_from_slice(&edge[..nodes + 2]);
    } else {
        row[..nodes + 2].fill(rules.loss);
    }
}

dispatch! {
    /// Measures one row of a panel.
    fn measure(
        discount: f64, soils: &Soils, souths: &Afterstates, heres: &Afterstates, norths: &Afterstates, inputs: &Inputs<'_>,
        maxima: &mut Maxima,
    ) = measure_lanes
}

/// The soils of a chunk's nodes, each number lane by lane.
#[inline(always)]
fn soils_of(soils: &Soils, classes: &[Class; LANES]) -> [[f64; LANES]; 4] {
    let mut lanes = [[0.0; LANES]; 4];
    for l in 0..LANES {
        let soil = &soils[classes[l].row()];
        for index in 0..4 {
            lanes[index][l] = soil[index];
        }
    }
    lanes
}

/// A chunk of numbers from `at` on, filled up with `beyond` past the end.
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
    souths: &Afterstates,
    heres: &Afterstates,
    norths: &Afterstates,
    inputs: &Inputs<'_>,
    maxima: &mut Maxima,
) {
    // No closures here: they would be compiled without the vector instructions, as functions of their own.
    let Maxima { mut residual, mut afterstate_max, mut not_finite } = *maxima;
    for start in (0..inputs.values.len()).step_by(LANES) {
        // The last chunk overlaps the one before, so that it is full.
        let at = start.min(inputs.values.len().saturating_sub(LANES));
        let (value, payoff) = (chunk(inputs.values, at, 0.0), chunk(inputs.payoffs, at, 0.0));
        let (east, north) = (chunk(inputs.slopes_east, at, 0.0), chunk(inputs.slopes_north, at, 0.0));
        let classes = chunk(inputs.classes, at, Class::LOST);
        let [intended, stuck, sideways, waits] = soils_of(soils, &classes);
        // 1 where it holds, 0 elsewhere.
        let [mut is_free, mut is_lost] = [[0.0; LANES]; 2];
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
            // Slopes ahead and to the right; afterstate values ahead, to the left, to the right.
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
                let action_value = discount * (wait * payoff[l] + then * next);
                best = if action_value > best { action_value } else { best };
            }
            let difference = best - value[l];
            let size = if free { difference.abs() } else { 0.0 };
            not_finite[l] = if size < f64::INFINITY { not_finite[l] } else { 1.0 };
            residual[l] = if size > residual[l] { size } else { residual[l] };
            let size = if is_lost[l] > 0.0 {
                0.0
            } else {
                payoff[l].abs() + if free { value[l].abs() } else { 0.0 }
            };
            afterstate_max[l] = if size > afterstate_max[l] { size } else { afterstate_max[l] };
        }
    }
    *maxima = Maxima { residual, afterstate_max, not_finite };
}
