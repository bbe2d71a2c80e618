//! Bellman's operator over whole rows in double precision, operation for operation as in [`crate::bellman`].
//!
//! It serves twice. The largest deviation is the certificate's residual. And the best hop of each node is a
//! policy π whose equation, linear in the correction e = V_π − V, is what [`crate::correct`] solves:
//! with δ = TV − V and P_π the landings of the best hops,
//! e = δ + g P_π e, hence e = (δ + g Σ_{x′ ≠ x} p e(x′)) / (1 − g p_stay).
//! It is Newton's method for Bellman's equation (policy iteration), and each round begins with a residual
//! in double precision, so single precision is enough for the corrections.

use crate::simd::{Simd, dispatch};
use crate::world::Class;
use crate::{Hop, Kind, Leaving, World};

/// Lanes of a chunk in double precision.
const LANES: usize = 8;

/// What the survey found along one row, padded to whole chunks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    /// δ / (1 − g p_stay).
    pub own: Vec<f64>,
    /// g p / (1 − g p_stay) for the landings north, east, south and west of the best hop.
    pub landings: [Vec<f64>; 4],
}

/// The survey's buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Survey {
    row: Row,
    /// Worths of the rows south of, at and north of the present one, with a node beyond either end.
    worths: [Vec<f64>; 3],
    /// Value, payoff, slopes; intended, stuck, sideways, wait of the row's nodes.
    inputs: [Vec<f64>; 8],
}

/// What a survey found over all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Findings {
    /// max |V − TV|; infinite if some value is no number.
    pub residual: f64,
    /// The largest |r| + |V| and |loss| met.
    pub worth_max: f64,
}

impl Survey {
    /// Surveys `values`, handing each row to `take`.
    pub fn run(
        &mut self,
        simd: Simd,
        world: &World,
        values: &[f64],
        mut take: impl FnMut(usize, &Row),
    ) -> Findings {
        let (width, height) = (world.width(), world.height());
        let padded = width.next_multiple_of(LANES);
        let Self { row, worths, inputs } = self;
        for buffer in worths.iter_mut() {
            buffer.clear();
            buffer.resize(padded + 2, 0.0);
        }
        for buffer in inputs.iter_mut().chain(&mut row.landings).chain([&mut row.own]) {
            buffer.clear();
            buffer.resize(padded, 0.0);
        }
        let rules = world.rules();
        let stays = rules.leaving == Leaving::Stays;
        let mut findings = Findings { residual: 0.0, worth_max: rules.loss.abs() };
        worths_of(world, values, 0, &mut worths[1]);
        for y in 0..height {
            let [south, here, north] = worths;
            if y + 1 < height {
                worths_of(world, values, y + 1, north);
            } else {
                beyond(here, north, stays, rules.loss);
            }
            if y == 0 {
                beyond(here, south, stays, rules.loss);
            }
            let here_values = &values[y * width..(y + 1) * width];
            gather(world, y, here_values, inputs);
            let [residual, worth_max] = survey(simd, rules.discount, [south, here, north], inputs, row);
            findings.residual = findings.residual.max(residual);
            findings.worth_max = findings.worth_max.max(worth_max);
            if stays {
                row.close_border(y == 0, y + 1 == height, width);
            }
            take(y, row);
            worths.rotate_left(1);
        }
        findings
    }
}

impl Row {
    /// Adds to the stay what leaves the map: e = own + l e + … is e = (own + …) / (1 − l).
    fn close_border(&mut self, southernmost: bool, northernmost: bool, width: usize) {
        let mut close = |hop: Hop, x: usize| {
            let leaves = std::mem::take(&mut self.landings[hop as usize][x]);
            if leaves > 0.0 {
                let scale = 1.0 / (1.0 - leaves);
                self.own[x] *= scale;
                self.landings.iter_mut().for_each(|landing| landing[x] *= scale);
            }
        };
        close(Hop::West, 0);
        close(Hop::East, width - 1);
        for x in 0..width {
            if southernmost {
                close(Hop::South, x);
            }
            if northernmost {
                close(Hop::North, x);
            }
        }
    }
}

fn worths_of(world: &World, values: &[f64], y: usize, into: &mut [f64]) {
    let (payoffs, _, _, classes) = world.row(y);
    let width = payoffs.len();
    let loss = world.rules().loss;
    let values = &values[y * width..(y + 1) * width];
    for x in 0..width {
        into[x + 1] = match classes[x].kind() {
            Kind::Free => payoffs[x] + values[x],
            Kind::Goal => payoffs[x],
            Kind::Lost => loss,
        };
    }
    let stays = world.rules().leaving == Leaving::Stays;
    into[0] = if stays { into[1] } else { loss };
    into[width + 1] = if stays { into[width] } else { loss };
}

/// The row beyond the map's edge, beside the row `edge`.
fn beyond(edge: &[f64], into: &mut [f64], stays: bool, loss: f64) {
    if stays {
        into.copy_from_slice(edge);
    } else {
        into.fill(loss);
    }
}

fn gather(world: &World, y: usize, values: &[f64], inputs: &mut [Vec<f64>; 8]) {
    let (payoffs, east, north, classes): (_, _, _, &[Class]) = world.row(y);
    let width = values.len();
    let [value, payoff, slope_east, slope_north, intended, stuck, sideways, wait] = inputs;
    value[..width].copy_from_slice(values);
    payoff[..width].copy_from_slice(payoffs);
    slope_east[..width].copy_from_slice(east);
    slope_north[..width].copy_from_slice(north);
    let soils = &world.rules().soils;
    for x in 0..width {
        // A wait of −1 marks a node without hops.
        let free = classes[x].kind() == Kind::Free;
        let soil = &soils[classes[x].soil()];
        intended[x] = soil.intended;
        stuck[x] = soil.stuck;
        sideways[x] = soil.sideways;
        wait[x] = if free { soil.wait } else { -1.0 };
    }
    wait[width..].fill(-1.0);
}

dispatch! {
    /// Surveys one row; its largest deviation and its largest |r| + |V|.
    fn survey(discount: f64, worths: [&[f64]; 3], inputs: &[Vec<f64>; 8], row: &mut Row) -> [f64; 2] = survey_lanes
}

#[inline(always)]
fn chunk(of: &[f64], at: usize) -> [f64; LANES] {
    let mut chunk = [0.0; LANES];
    chunk.copy_from_slice(&of[at..at + LANES]);
    chunk
}

#[inline(always)]
fn survey_lanes(discount: f64, worths: [&[f64]; 3], inputs: &[Vec<f64>; 8], row: &mut Row) -> [f64; 2] {
    let [souths, heres, norths] = worths;
    let mut residual = [0.0_f64; LANES];
    let mut worth_max = [0.0_f64; LANES];
    let mut sound = [true; LANES];
    let [mut p_north, mut p_east, mut p_south, mut p_west] = [[0.0; LANES]; 4];
    let mut own = [0.0; LANES];
    for at in (0..inputs[0].len()).step_by(LANES) {
        let [value, payoff, east, north] = [0, 1, 2, 3].map(|input: usize| chunk(&inputs[input], at));
        let [intended, stuck, sideways, wait] = [4, 5, 6, 7].map(|input: usize| chunk(&inputs[input], at));
        let (w_here, w_north, w_south) = (chunk(heres, at + 1), chunk(norths, at + 1), chunk(souths, at + 1));
        let (w_west, w_east) = (chunk(heres, at), chunk(heres, at + 2));
        for l in 0..LANES {
            let free = wait[l] >= 0.0;
            let wait = if free { wait[l] } else { 0.0 };
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
            for (index, (ahead, right_up, w_ahead, w_left, w_right)) in hops.into_iter().enumerate() {
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
                for (entry, p) in chosen.iter_mut().zip([p, stayed, left, right]) {
                    *entry = if better { p } else { *entry };
                }
            }
            let deviation = best - value[l];
            let size = if free { deviation.abs() } else { 0.0 };
            sound[l] &= size < f64::INFINITY;
            residual[l] = if size > residual[l] { size } else { residual[l] };
            let size = if free { payoff[l].abs() + value[l].abs() } else { 0.0 };
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
        row.own[at..at + LANES].copy_from_slice(&own);
        let [to_north, to_east, to_south, to_west] = &mut row.landings;
        to_north[at..at + LANES].copy_from_slice(&p_north);
        to_east[at..at + LANES].copy_from_slice(&p_east);
        to_south[at..at + LANES].copy_from_slice(&p_south);
        to_west[at..at + LANES].copy_from_slice(&p_west);
    }
    let residual = if sound.into_iter().all(|sound| sound) {
        residual.into_iter().fold(0.0, f64::max)
    } else {
        f64::INFINITY
    };
    [residual, worth_max.into_iter().fold(0.0, f64::max)]
}
