//! Seeded worlds for tests, benchmarks and comparisons: hills, sand, and the paper's payoff.
//!
//! Hills and hollows are Gaussians, about one to 50 nodes as on the paper's map of 20 × 20; a dozen
//! rectangles are sand. The payoff of a landing is w1 S + w2 I + 10 D (Sakamoto & Kunii 2023, eq. 3):
//! S = −|∇h| − T, T = −5 on sand, and I = h, both min–max normalised over the world; D = −distance to the
//! goal over distance from start to goal. The goal pays 100. Large w1 and w2 make traps, worlds where
//! lingering on a hill pays more than the goal. Equal fixtures make equal worlds, on every machine.

use scatter::slope_in_limits;

use crate::landings::{Landing, LandingTable, Row, TableRules, TableSite, TableWorld};
use crate::{Error, GridWorld, Hop, Kind, Leaving, Rules, Site, Soil};

/// Where the goal lies; the start is in the corner of the first node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalPlace {
    /// One node off the opposite corner.
    Corner,
    /// One node off the opposite side, at 3/5 of the width.
    Side,
    /// Well inside, at 3/5 of the width and 2/5 of the height.
    Inside,
}

/// The parameters of a world for tests, benchmarks and comparisons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fixture {
    /// Nodes per row, at least 1.
    pub width: usize,
    /// Number of rows, at least 1.
    pub height: usize,
    /// Seed of hills and sand.
    pub seed: u64,
    /// Weight w1 of safety.
    pub safety: f64,
    /// Weight w2 of information.
    pub information: f64,
    /// What leaving the grid means.
    pub leaving: Leaving,
    /// The goal, near a corner, near a side, or inside.
    pub place: GoalPlace,
}

/// Hard ground of the paper.
pub const HARD: Soil = Soil { intended: 0.9, stuck: 0.0, sideways: 0.05, wait: 0.0 };
/// Sand of the paper: a hop takes two periods.
pub const SAND: Soil = Soil { intended: 0.7, stuck: 0.1, sideways: 0.1, wait: 1.0 };
/// Discount of the paper.
pub const DISCOUNT: f64 = 0.99;
/// Payoff of landing on the goal.
pub const GOAL_PAYOFF: f64 = 100.0;
/// Slope at which no hop gets away uphill, radians.
const SLOPE_LIMIT_RAD: f64 = std::f64::consts::PI / 6.0;
/// Beyond this many standard deviations a hill counts as flat.
const HILL_REACH_SIGMAS: f64 = 6.0;

impl Fixture {
    /// A square world in which the goal is worth reaching: w1 = w2 = 0.5, leaving stays.
    #[must_use]
    pub fn plain(side: usize, seed: u64) -> Self {
        let leaving = Leaving::Stays;
        let (safety, information, place) = (0.5, 0.5, GoalPlace::Corner);
        Self { width: side, height: side, seed, safety, information, leaving, place }
    }

    /// A square world in which lingering on a hill pays more than the goal: w1 = 10, w2 = 30.
    #[must_use]
    pub fn trap(side: usize, seed: u64) -> Self {
        Self { safety: 10.0, information: 30.0, ..Self::plain(side, seed) }
    }

    /// A square world in which the goal is worth reaching and lies well inside.
    #[must_use]
    pub fn inner(side: usize, seed: u64) -> Self {
        Self { place: GoalPlace::Inside, ..Self::plain(side, seed) }
    }

    /// The node that a mission would start from.
    #[must_use]
    pub fn start(&self) -> usize {
        2.min(self.height - 1) * self.width + 1.min(self.width - 1)
    }

    /// The node of the goal.
    #[must_use]
    pub fn goal(&self) -> usize {
        let (far_x, far_y) = (self.width.saturating_sub(2), self.height.saturating_sub(2));
        let (x, y) = match self.place {
            GoalPlace::Corner => (far_x, far_y),
            GoalPlace::Side => (self.width * 3 / 5, far_y),
            GoalPlace::Inside => (self.width * 3 / 5, self.height * 2 / 5),
        };
        y * self.width + x
    }

    /// Builds the world as it is, all of it seen.
    ///
    /// # Errors
    /// If its size is out of range.
    pub fn world(&self) -> Result<GridWorld, Error> {
        self.build(true)
    }

    /// The world before anything of it has been seen: flat, hard, at height 0, where it is not the
    /// goal; the ranges that payoffs are normalised by are known beforehand.
    ///
    /// # Errors
    /// If its size is out of range.
    pub fn unseen(&self) -> Result<GridWorld, Error> {
        self.build(false)
    }

    /// The same ground, where hops land by a table of twelve landings for each of two soils and 25 × 25 slopes: about the target,
    /// shorter uphill, longer downhill, and beside it downhill.
    ///
    /// # Errors
    /// If its size is out of range.
    pub fn table_world(&self) -> Result<TableWorld, Error> {
        let ground = self.world()?;
        let Rules { discount, loss, leaving, .. } = *ground.rules();
        let slopes = || (-BINS..=BINS).map(|bin| f64::from(bin) / f64::from(BINS));
        let rows = HOP_SPREADS.into_iter().flat_map(|spread| {
            slopes().flat_map(move |along| slopes().map(move |across| bell_row(along, across, spread)))
        });
        let table = LandingTable::new(rows.collect())?;
        let mut world =
            TableWorld::new(self.width, self.height, TableRules { discount, loss, leaving }, table)?;
        for node in 0..ground.nodes() {
            let Site { kind, payoff, slope_east, slope_north, soil } = ground.site(node);
            let towards = |hop| match hop {
                Hop::North => slope_north,
                Hop::East => slope_east,
                Hop::South => -slope_north,
                Hop::West => -slope_east,
            };
            let bin = |slope: f64| (libm::round(slope * f64::from(BINS)) + f64::from(BINS)) as u16;
            let side = 2 * BINS as u16 + 1;
            let classes = Hop::ALL
                .map(|hop| (u16::from(soil) * side + bin(towards(hop))) * side + bin(towards(hop.left())));
            world.set(node, TableSite { kind, payoff, classes });
        }
        Ok(world)
    }

    fn build(&self, seen: bool) -> Result<GridWorld, Error> {
        let rules = Rules { discount: DISCOUNT, loss: 0.0, leaving: self.leaving, soils: vec![HARD, SAND] };
        let mut world = GridWorld::new(self.width, self.height, rules)?;
        let mut draw = SplitMix64(self.seed);
        let relief = self.relief(&mut draw);
        let sand = self.sand(&mut draw);
        let safety = |&(_, east, north): &(f64, f64, f64), sand: bool| {
            -(east * east + north * north).sqrt() + if sand { 5.0 } else { 0.0 }
        };
        let normalised_safety = min_max(relief.iter().zip(&sand).map(|(relief, sand)| safety(relief, *sand)));
        let normalised_height = min_max(relief.iter().map(|relief| relief.0));
        let distance = |node: usize| {
            let (goal, width) = (self.goal(), self.width);
            let across = (node % width).abs_diff(goal % width) as f64;
            let along = (node / width).abs_diff(goal / width) as f64;
            (across * across + along * along).sqrt()
        };
        let whole = distance(self.start()).max(1.0);
        let mut worst = 0.0_f64;
        for node in 0..relief.len() {
            let truth = (relief[node], sand[node]);
            let ((height, east, north), sand) = if seen { truth } else { ((0.0, 0.0, 0.0), false) };
            let payoff = |relief: &(f64, f64, f64), sand: bool| {
                self.safety * normalised_safety(safety(relief, sand))
                    + self.information * normalised_height(relief.0)
                    - 10.0 * distance(node) / whole
            };
            let is_goal = node == self.goal();
            if !is_goal {
                worst = worst.min(payoff(&truth.0, truth.1));
            }
            let site = Site {
                kind: if is_goal { Kind::Goal } else { Kind::Free },
                payoff: if is_goal { GOAL_PAYOFF } else { payoff(&(height, east, north), sand) },
                slope_east: slope_in_limits(east, SLOPE_LIMIT_RAD),
                slope_north: slope_in_limits(north, SLOPE_LIMIT_RAD),
                soil: u8::from(sand),
            };
            world.set(node, site);
        }
        world.set_loss(worst / (1.0 - DISCOUNT) - 300.0)?;
        Ok(world)
    }

    /// Height and its slopes towards east and north at each node, metres and metres a node.
    fn relief(&self, draw: &mut SplitMix64) -> Vec<(f64, f64, f64)> {
        let mut relief = vec![(0.0, 0.0, 0.0); self.width * self.height];
        for _ in 0..relief.len().div_ceil(50) {
            let sigma = draw.between(1.5, 6.0);
            let sign = if draw.uniform() < 0.375 { -1.0 } else { 1.0 };
            let amplitude = sign * draw.between(0.04, 0.24) * sigma;
            let (x0, y0) = (draw.between(0.0, self.width as f64), draw.between(0.0, self.height as f64));
            let reach = sigma * HILL_REACH_SIGMAS;
            let along = |centre: f64, side: usize| {
                let first = (centre - reach).ceil().max(0.0) as usize;
                first..side.min((centre + reach).floor().max(-1.0) as usize + 1)
            };
            let bell = |offset: f64| libm::exp(-offset * offset / (2.0 * sigma * sigma));
            for y in along(y0, self.height) {
                let row = amplitude * bell(y as f64 - y0);
                for x in along(x0, self.width) {
                    let height = row * bell(x as f64 - x0);
                    let (h, east, north) = &mut relief[y * self.width + x];
                    *h += height;
                    *east -= height * (x as f64 - x0) / (sigma * sigma);
                    *north -= height * (y as f64 - y0) / (sigma * sigma);
                }
            }
        }
        relief
    }

    /// Whether each node is sand.
    fn sand(&self, draw: &mut SplitMix64) -> Vec<bool> {
        let mut sand = vec![false; self.width * self.height];
        for _ in 0..12 {
            let mut span = |side: usize| {
                let side = side as f64;
                let (first, length) = (draw.between(-0.1, 1.0) * side, draw.between(0.05, 0.3) * side);
                first.max(0.0) as usize..((first + length).clamp(0.0, side) as usize)
            };
            let (columns, rows) = (span(self.width), span(self.height));
            for y in rows {
                for x in columns.clone() {
                    sand[y * self.width + x] = true;
                }
            }
        }
        sand
    }
}

/// Classes of slope to each side of level ground.
const BINS: i16 = 12;

/// Standard deviation of a landing along each axis, hops: on hard ground and on sand.
const HOP_SPREADS: [f64; 2] = [0.4, 0.3];

/// Twelve landings about where a hop is expected to come to rest, at slopes in slope limits.
fn bell_row(along: f64, across: f64, spread: f64) -> Row {
    const OFFSETS: [(i8, i8); 12] =
        [(1, 0), (0, 0), (2, 0), (1, 1), (1, -1), (0, 1), (0, -1), (-1, 0), (2, 1), (2, -1), (1, 2), (1, -2)];
    let ahead = if along > 0.0 { 1.0 - along } else { 1.0 - 0.3 * along };
    let weight = |(forward, left): (i8, i8)| {
        let (forward, left) = (f64::from(forward) - ahead, f64::from(left) + 0.5 * across);
        libm::exp(-(forward * forward + left * left) / (2.0 * spread * spread))
    };
    let whole: f64 = OFFSETS.into_iter().map(weight).sum();
    let landing =
        |offset: (i8, i8)| Landing { forward: offset.0, left: offset.1, probability: weight(offset) / whole };
    Row { landings: OFFSETS.into_iter().map(landing).collect(), waits: false }
}

/// Maps the range of `values` to [0, 1].
fn min_max(values: impl Iterator<Item = f64>) -> impl Fn(f64) -> f64 {
    let (min, max) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), x| (min.min(x), max.max(x)));
    let width = max - min;
    move |x| if width > 0.0 { (x - min) / width } else { 0.0 }
}

/// Uniform numbers by SplitMix64 (Steele, Lea & Flood 2014, OOPSLA, fig. 1).
#[derive(Clone, Debug)]
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    /// A number in [0, 1) with 53 random bits.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        (bits >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// A number in [`min`, `max`).
    pub fn between(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * self.uniform()
    }
}
