//! Bellman's operator over whole rows in double precision, operation for operation as in [`crate::bellman`].
//!
//! It serves twice. The largest deviation is the certificate's residual. And the best hop of each node is a
//! policy π whose equation, linear in the correction e = V_π − V, is what [`crate::correct`] solves:
//! with δ = TV − V and P_π the landings of the best hops,
//! e = δ + g P_π e, hence e = (δ + g Σ_{x′ ≠ x} p e(x′)) / (1 − g p_stay).
//! It is Newton's method for Bellman's equation (policy iteration), and each round begins with a residual
//! in double precision, so single precision is enough for the corrections.

use std::ops::Range;

use crate::simd::{Simd, dispatch};
use crate::world::Class;
use crate::{Hop, Leaving, Rules, World};

/// Lanes of a chunk in double precision.
const LANES: usize = 8;

/// Nodes of a panel: rows are surveyed in panels, so that what one panel's rows write to the skewed layout,
/// where neighbours in a row lie far apart, stays in the nearest cache from row to row.
pub(crate) const PANEL: usize = 128;

/// What the survey found along one row of a panel.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// δ / (1 − g p_stay).
    pub own: [f32; PANEL],
    /// g p / (1 − g p_stay) for the landings north, east, south and west of the best hop.
    pub landings: [[f32; PANEL]; 4],
}

/// What the survey reads along one row of a panel.
struct Inputs {
    values: [f64; PANEL],
    payoffs: [f64; PANEL],
    slopes_east: [f64; PANEL],
    slopes_north: [f64; PANEL],
    classes: [Class; PANEL],
}

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

/// Surveys `values`, handing each row of each panel to `take` with its columns and its y.
pub(crate) fn run(
    simd: Simd,
    world: &World,
    values: &[f64],
    mut take: impl FnMut(Range<usize>, usize, &Row),
) -> Findings {
    let (width, height) = (world.width(), world.height());
    let rules = world.rules();
    let mut findings = Findings { residual: 0.0, worth_max: rules.loss.abs() };
    let mut row = Row { own: [0.0; PANEL], landings: [[0.0; PANEL]; 4] };
    let mut inputs = Inputs {
        values: [0.0; PANEL],
        payoffs: [0.0; PANEL],
        slopes_east: [0.0; PANEL],
        slopes_north: [0.0; PANEL],
        classes: [Class::LOST; PANEL],
    };
    for start in (0..width).step_by(PANEL) {
        let columns = start..width.min(start + PANEL);
        let mut worths = [[0.0; PANEL + 2]; 3];
        inputs.classes.fill(Class::LOST);
        worths_of(simd, world, values, &columns, 0, &mut worths[1]);
        worths[0] = beyond(rules, &worths[1]);
        for y in 0..height {
            if y + 1 < height {
                worths_of(simd, world, values, &columns, y + 1, &mut worths[(y + 2) % 3]);
            } else {
                worths[(y + 2) % 3] = beyond(rules, &worths[(y + 1) % 3]);
            }
            inputs.fill(world, values, &columns, y);
            let [residual, worth_max] = {
                let [south, here, north] = [y % 3, (y + 1) % 3, (y + 2) % 3].map(|row| &worths[row]);
                survey(simd, rules, south, here, north, &inputs, &mut row, columns.len())
            };
            findings.residual = findings.residual.max(residual);
            findings.worth_max = findings.worth_max.max(worth_max);
            if rules.leaving == Leaving::Stays {
                row.close_border([y == 0, y + 1 == height], &columns, width);
            }
            take(columns.clone(), y, &row);
        }
    }
    findings
}

impl Row {
    /// Adds to the stay what leaves the map: e = own + l e + … is e = (own + …) / (1 − l).
    fn close_border(&mut self, [south, north]: [bool; 2], columns: &Range<usize>, width: usize) {
        let mut close = |hop: Hop, x: usize| {
            let leaves = std::mem::take(&mut self.landings[hop as usize][x]);
            if leaves > 0.0 {
                let scale = 1.0 / (1.0 - leaves);
                self.own[x] *= scale;
                self.landings.iter_mut().for_each(|landing| landing[x] *= scale);
            }
        };
        if columns.start == 0 {
            close(Hop::West, 0);
        }
        if columns.end == width {
            close(Hop::East, columns.len() - 1);
        }
        for x in 0..columns.len() {
            if south {
                close(Hop::South, x);
            }
            if north {
                close(Hop::North, x);
            }
        }
    }
}

impl Inputs {
    fn fill(&mut self, world: &World, values: &[f64], columns: &Range<usize>, y: usize) {
        let (payoffs, east, north, classes) = world.row(y);
        let (width, len) = (payoffs.len(), columns.len());
        self.values[..len].copy_from_slice(&values[y * width..(y + 1) * width][columns.clone()]);
        self.payoffs[..len].copy_from_slice(&payoffs[columns.clone()]);
        self.slopes_east[..len].copy_from_slice(&east[columns.clone()]);
        self.slopes_north[..len].copy_from_slice(&north[columns.clone()]);
        self.classes[..len].copy_from_slice(&classes[columns.clone()]);
    }
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

/// The row beyond the map's edge, beside the row `edge`.
fn beyond(rules: &Rules, edge: &Worths) -> Worths {
    if rules.leaving == Leaving::Stays { *edge } else { [rules.loss; PANEL + 2] }
}

dispatch! {
    /// Surveys one row; its largest deviation and its largest |r| + |V|.
    fn survey(
        rules: &Rules, souths: &Worths, heres: &Worths, norths: &Worths, inputs: &Inputs, row: &mut Row, nodes: usize,
    ) -> [f64; 2] = survey_lanes
}

#[inline(always)]
fn chunk(of: &[f64], at: usize) -> [f64; LANES] {
    let mut chunk = [0.0; LANES];
    chunk.copy_from_slice(&of[at..at + LANES]);
    chunk
}

#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "one row needs its neighbours")]
#[allow(
    clippy::needless_range_loop,
    reason = "a lane is a lane of many arrays, and closures are not inlined"
)]
fn survey_lanes(
    rules: &Rules,
    souths: &Worths,
    heres: &Worths,
    norths: &Worths,
    inputs: &Inputs,
    row: &mut Row,
    nodes: usize,
) -> [f64; 2] {
    // No closures in here: they would be compiled without the vector instructions, and be called.
    let discount = rules.discount;
    let mut residual = [0.0_f64; LANES];
    let mut worth_max = [0.0_f64; LANES];
    let mut unsound = [0.0_f64; LANES];
    let [mut p_north, mut p_east, mut p_south, mut p_west] = [[0.0; LANES]; 4];
    let mut own = [0.0; LANES];
    for at in (0..nodes).step_by(LANES) {
        let (value, payoff) = (chunk(&inputs.values, at), chunk(&inputs.payoffs, at));
        let (east, north) = (chunk(&inputs.slopes_east, at), chunk(&inputs.slopes_north, at));
        let [mut intended, mut stuck, mut sideways, mut waits] = [[0.0; LANES]; 4];
        // 1 where it is so, 0 elsewhere.
        let [mut is_free, mut is_lost] = [[0.0; LANES]; 2];
        for index in 0..rules.soils.len() {
            let soil = rules.soils[index];
            for l in 0..LANES {
                let this = inputs.classes[at + l].soil() == index;
                intended[l] = if this { soil.intended } else { intended[l] };
                stuck[l] = if this { soil.stuck } else { stuck[l] };
                sideways[l] = if this { soil.sideways } else { sideways[l] };
                waits[l] = if this { soil.wait } else { waits[l] };
            }
        }
        for l in 0..LANES {
            is_free[l] = if inputs.classes[at + l].is_free() { 1.0 } else { 0.0 };
            is_lost[l] = if inputs.classes[at + l].is_lost() { 1.0 } else { 0.0 };
        }
        let (w_here, w_north, w_south) = (chunk(heres, at + 1), chunk(norths, at + 1), chunk(souths, at + 1));
        let (w_west, w_east) = (chunk(heres, at), chunk(heres, at + 2));
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
            let mut chosen = [0.0; 4];
            let mut hop_chosen = 0.0;
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
                let better = worth > best;
                best = if better { worth } else { best };
                hop_chosen = if better { index as f64 } else { hop_chosen };
                chosen[0] = if better { p } else { chosen[0] };
                chosen[1] = if better { stayed } else { chosen[1] };
                chosen[2] = if better { left } else { chosen[2] };
                chosen[3] = if better { right } else { chosen[3] };
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

            let landing = discount * then;
            let scale = if free { 1.0 / (1.0 - landing * chosen[1]) } else { 0.0 };
            let (p, left, right) =
                (landing * chosen[0] * scale, landing * chosen[2] * scale, landing * chosen[3] * scale);
            let across = hop_chosen == 0.0 || hop_chosen == 2.0;
            own[l] = deviation * scale;
            p_north[l] = if hop_chosen == 0.0 {
                p
            } else if across {
                0.0
            } else if hop_chosen == 1.0 {
                left
            } else {
                right
            };
            p_south[l] = if hop_chosen == 2.0 {
                p
            } else if across {
                0.0
            } else if hop_chosen == 1.0 {
                right
            } else {
                left
            };
            p_east[l] = if hop_chosen == 1.0 {
                p
            } else if !across {
                0.0
            } else if hop_chosen == 0.0 {
                right
            } else {
                left
            };
            p_west[l] = if hop_chosen == 3.0 {
                p
            } else if !across {
                0.0
            } else if hop_chosen == 0.0 {
                left
            } else {
                right
            };
        }
        let [to_north, to_east, to_south, to_west] = &mut row.landings;
        for l in 0..LANES {
            row.own[at + l] = own[l] as f32;
            to_north[at + l] = p_north[l] as f32;
            to_east[at + l] = p_east[l] as f32;
            to_south[at + l] = p_south[l] as f32;
            to_west[at + l] = p_west[l] as f32;
        }
    }
    let residual =
        if unsound == [0.0; LANES] { residual.into_iter().fold(0.0, f64::max) } else { f64::INFINITY };
    [residual, worth_max.into_iter().fold(0.0, f64::max)]
}
