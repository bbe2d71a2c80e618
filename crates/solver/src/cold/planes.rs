//! The planes of numbers that sweeps read and write, in the layout of [`super::skew`].
//!
//! Loading a world fills them with each node's coefficients (see [`super::sweep`]); the values are read out row by
//! row of the grid.

use super::gather::{Gathered, Nodes};
use super::plane::Plane;
use super::skew::{BorderStep, HOPS, PARTS, Skew, chunk, constant_at, part_at};
use crate::grid_world::Class;
use crate::simd::{SINGLE_LANES as LANES, Simd, dispatch};
use crate::{GridWorld, Leaving, Rules};

/// Numbers per entry of a layout: afterstate values, unknowns, coefficients.
#[derive(Clone, Debug, Default)]
pub(crate) struct Planes {
    /// Threads that sweep large worlds in single precision: two if more than one.
    pub threads: usize,
    /// Afterstate values, from which the next residuals are measured.
    pub afterstates: Plane<f64>,
    /// What single precision solves for: afterstate values, or corrections to them.
    pub unknown: Plane<f32>,
    /// Five coefficients per node, chunk by chunk ([`part_at`]): ρ, a, c and the slopes along i and j for sweeps, the
    /// linear equation for [`super::correct`]. Behind them, where corrections are swept for, the residuals of the
    /// four kinds of hop ([`super::skew::shift_at`]). One plane holds both, so that most of all memory is one
    /// allocation, which allocators reuse as it is.
    pub coefficients: Plane<f32>,
}

/// Splits [`Planes::coefficients`] into the nodes' own and the shifts behind them.
pub(crate) fn split(coefficients: &mut [f32]) -> (&mut [f32], &mut [f32]) {
    let entries = coefficients.len() / (PARTS + HOPS);
    coefficients.split_at_mut(PARTS * entries)
}

impl Planes {
    /// Planes of `len` entries, zeros. Entries outside the grid and its halo stay 0 from then on.
    pub fn reset(&mut self, len: usize) {
        self.afterstates.reset(len);
        self.unknown.reset(len);
        self.coefficients.reset((PARTS + HOPS) * len);
    }

    /// Loads `world` with the value `value` at every free node.
    pub fn load_uniform(&mut self, simd: Simd, skew: &Skew, world: &GridWorld, value: f64) {
        self.load(simd, skew, world, Initial::Same(value));
    }

    /// Loads `world` with `values`, row-major.
    pub fn load_values(&mut self, simd: Simd, skew: &Skew, world: &GridWorld, values: &[f64]) {
        self.load(simd, skew, world, Initial::Values(values));
    }

    /// Loads `world` for sweeps of afterstate values again, keeping the present ones.
    pub fn resume(&mut self, simd: Simd, skew: &Skew, world: &GridWorld) {
        self.load(simd, skew, world, Initial::Kept);
    }

    fn load(&mut self, simd: Simd, skew: &Skew, world: &GridWorld, initial: Initial<'_>) {
        let Self { afterstates, unknown, coefficients, .. } = self;
        let soils = single_soils(world);
        load(
            simd,
            afterstates.all_mut(),
            unknown.all_mut(),
            coefficients.all_mut(),
            skew,
            world,
            &soils,
            initial,
        );
        self.fill_halo(skew, world.rules());
    }

    /// Copies the swept unknowns into the afterstate values of all free nodes.
    pub fn adopt(&mut self, simd: Simd, skew: &Skew) {
        let Self { afterstates, unknown, coefficients, .. } = self;
        adopt(simd, afterstates.all_mut(), unknown.all(), coefficients.all(), skew);
    }

    /// Adds the corrections to the afterstate values.
    pub fn add(&mut self, simd: Simd) {
        add(simd, self.afterstates.all_mut(), self.unknown.all());
    }

    /// Copies the values out, row-major: 0 at a goal, the loss where lost.
    pub fn read_values(&self, simd: Simd, skew: &Skew, world: &GridWorld, values: &mut [f64]) {
        read_values(simd, self.afterstates.all(), skew, world, values);
    }

    /// Fills the halo with the loss, or, where leaving means staying, with the border's afterstate values.
    fn fill_halo(&mut self, skew: &Skew, rules: &Rules) {
        let stays = rules.leaving == Leaving::Stays;
        let (unknown, coefficients) = (self.unknown.all_mut(), self.coefficients.all_mut());
        for &BorderStep { at, beyond, .. } in skew.border() {
            unknown[beyond] = if stays { unknown[at] } else { rules.loss as f32 };
            coefficients[constant_at(beyond)] = unknown[beyond];
        }
    }
}

/// What the free nodes' afterstate values start from.
#[derive(Clone, Copy, Debug)]
enum Initial<'a> {
    /// The same value at every free node.
    Same(f64),
    /// One value per node, row-major.
    Values(&'a [f64]),
    /// The present afterstate values, in a layout that has not changed.
    Kept,
}

/// For each row of classes: g intended, g stuck, g sideways, and γλ of its soil, with g the discount between departure
/// and landing.
pub(crate) type Soils = [[f64; 4]; Class::ROWS];

/// The soils of `world` as kernels in double precision read them; zeros for nodes that are not free.
pub(crate) fn soils(world: &GridWorld) -> Soils {
    let mut table = [[0.0; 4]; Class::ROWS];
    let discount = world.rules().discount;
    for (entry, soil) in table.iter_mut().zip(&world.rules().soils) {
        let landing = soil.discount(discount);
        *entry =
            [landing * soil.intended, landing * soil.stuck, landing * soil.sideways, discount * soil.wait];
    }
    table
}

/// For each row of classes: ρ per payoff, a and c of its soil ([`super::sweep`]).
type SingleSoils = [[f32; 3]; Class::ROWS];

fn single_soils(world: &GridWorld) -> SingleSoils {
    soils(world).map(|[intended, stuck, sideways, wait]| {
        let moves = 1.0 - stuck;
        [(1.0 + wait) / moves, intended / moves, sideways / moves].map(|number| number as f32)
    })
}

dispatch! {
    /// Fills the planes with the world's numbers.
    fn load(
        afterstates: &mut [f64], unknown: &mut [f32], coefficients: &mut [f32], skew: &Skew, world: &GridWorld, soils: &SingleSoils,
        initial: Initial<'_>,
    ) = load_lanes
}

#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "a kernel takes its planes one by one")]
fn load_lanes(
    afterstates: &mut [f64],
    unknown: &mut [f32],
    coefficients: &mut [f32],
    skew: &Skew,
    world: &GridWorld,
    soils: &SingleSoils,
    initial: Initial<'_>,
) {
    let loss = world.rules().loss;
    let flip_i = if skew.flip[0] { -1.0 } else { 1.0 };
    let flip_j = if skew.flip[1] { -1.0 } else { 1.0 };
    let mut remaining = skew.chunks();
    let mut gathered = Gathered::new();
    loop {
        let chunks = gathered.next(&mut remaining, world);
        if chunks == 0 {
            break;
        }
        for index in 0..chunks {
            let Nodes { chunk: place, payoffs, slopes: [slopes_i, slopes_j], classes } =
                gathered.nodes(index);
            let at = place.entry;
            let mut landed = chunk(afterstates, at);
            match initial {
                Initial::Kept => {}
                Initial::Same(value) => {
                    for lane in 0..LANES {
                        landed[lane] = payoffs[lane] + value;
                    }
                }
                Initial::Values(values) => {
                    for lane in 0..place.lanes {
                        landed[lane] = payoffs[lane] + values[place.at(lane)];
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
            for lane in place.lanes..LANES {
                landed[lane] = 0.0;
                for values in &mut parts {
                    values[lane] = 0.0;
                }
            }
            afterstates[at..at + LANES].copy_from_slice(&landed);
            for lane in 0..LANES {
                unknown[at + lane] = landed[lane] as f32;
            }
            for (index, values) in parts.iter().enumerate() {
                let part = part_at(at, index);
                coefficients[part..part + LANES].copy_from_slice(values);
            }
        }
    }
}

dispatch! {
    /// Copies out the values of all nodes.
    fn read_values(afterstates: &[f64], skew: &Skew, world: &GridWorld, values: &mut [f64]) = take_out_lanes
}

#[inline(always)]
fn take_out_lanes(afterstates: &[f64], skew: &Skew, world: &GridWorld, values: &mut [f64]) {
    let loss = world.rules().loss;
    let (payoffs, classes) = world.payoffs();
    for place in skew.chunks() {
        for lane in 0..place.lanes {
            let (node, afterstate) = (place.at(lane), afterstates[place.entry + lane]);
            let ends = if classes[node].is_lost() { loss } else { 0.0 };
            values[node] = if classes[node].is_free() { afterstate - payoffs[node] } else { ends };
        }
    }
}

dispatch! {
    /// Copies the unknowns of the nodes that sweeps update.
    fn adopt(afterstates: &mut [f64], unknown: &[f32], coefficients: &[f32], skew: &Skew) = adopt_lanes
}

#[inline(always)]
fn adopt_lanes(afterstates: &mut [f64], unknown: &[f32], coefficients: &[f32], skew: &Skew) {
    for diagonal in skew.diagonals() {
        for at in (diagonal.first()..diagonal.first() + diagonal.nodes()).step_by(LANES) {
            let (ahead, beside) = (chunk(coefficients, part_at(at, 1)), chunk(coefficients, part_at(at, 2)));
            let (mut landed, single) = (chunk(afterstates, at), chunk(unknown, at));
            for lane in 0..LANES {
                let updated = ahead[lane] + beside[lane] > 0.0;
                landed[lane] = if updated { f64::from(single[lane]) } else { landed[lane] };
            }
            afterstates[at..at + LANES].copy_from_slice(&landed);
        }
    }
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
