//! Where hops end, by soil and slope: what a planner may believe in place of the law of the papers.

use contract::{MotionRow, MotionTable, Soil};
use std::collections::BTreeMap;

use campaign::statistics::wilson;
use contact::{End, Noise};
use rayon::prelude::*;
use scenario::Preset;
use serde::Serialize;

use crate::hopper_on::{HOP_M, HopperOn, soil_of};

/// Distance between the slopes of two classes, degrees.
pub const BIN_DEG: f64 = MotionTable::BIN_DEG;

/// Classes to each side of level ground.
const BINS: i32 = MotionTable::BINS;

/// Most landings of a class that are kept one by one.
pub const LANDINGS_MAX: usize = MotionRow::LANDINGS_MAX - 1;

/// Hops of a class on ground too steep to rest on.
const TOO_STEEP_HOPS: u64 = 100;

/// A landing in the frame of the hop, whole hops forward and to the left.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Landing {
    /// Hops forward, −1 to 2, and to the left, −2 to 2.
    pub offset: [i32; 2],
    /// Share of the hops that rest there.
    pub probability: f64,
    /// Lower end of its Wilson interval of 95 %.
    pub low: f64,
    /// Upper end of its Wilson interval of 95 %.
    pub high: f64,
}

/// Hops that rest where no landing is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Far {
    /// Share of the hops.
    pub probability: f64,
    /// Mean displacement forward and to the left, hops.
    pub mean: [f64; 2],
}

/// The landings of hops on one soil at one slope.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Class {
    /// Soil of departure.
    pub soil: Soil,
    /// Rise towards the target, degrees.
    pub along_deg: f64,
    /// Rise to the left, degrees.
    pub across_deg: f64,
    /// Hops that were flown.
    pub samples: u64,
    /// Where they rest, the most frequent first.
    pub landings: Vec<Landing>,
    /// Those that rest elsewhere.
    pub far: Far,
    /// Whether the ground is too steep to rest on.
    pub rolls_away: bool,
}

/// The landings of all classes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LandingTable {
    /// Body on which it was derived.
    pub preset: &'static str,
    /// Surface gravity, m/s².
    pub gravity_mps2: f64,
    /// Length of a hop, metres.
    pub hop_m: f64,
    /// By soil, slope along and slope across.
    pub classes: Vec<Class>,
}

impl LandingTable {
    /// Flies `samples` hops a class: each departs from where the one before came to rest, moved to its own cell.
    #[must_use]
    pub fn derive(preset: Preset, samples: u64, seed: u64) -> Self {
        let slopes = (-BINS..=BINS).map(|bin| f64::from(bin) * BIN_DEG);
        let all: Vec<(Soil, f64, f64)> = Soil::ALL
            .into_iter()
            .flat_map(|soil| {
                let slopes = slopes.clone();
                slopes.clone().flat_map(move |along| slopes.clone().map(move |across| (soil, along, across)))
            })
            .collect();
        let class = |(number, &(soil, along_deg, across_deg)): (usize, &(Soil, f64, f64))| {
            let mut key = [0; 32];
            key[..8].copy_from_slice(&seed.to_le_bytes());
            key[8..16].copy_from_slice(&(number as u64).to_le_bytes());
            class(preset, (soil, along_deg, across_deg), samples, key)
        };
        let classes = all.par_iter().enumerate().map(class).collect();
        let gravity_mps2 = preset.gravity_mps2();
        Self { preset: preset.name(), gravity_mps2, hop_m: HOP_M, classes }
    }

    /// The class of level ground across, at a slope along.
    #[must_use]
    pub fn straight(&self, soil: Soil, along_deg: f64) -> Option<&Class> {
        let fits = |class: &&Class| {
            class.soil == soil && class.across_deg == 0.0 && (class.along_deg - along_deg).abs() < 1e-9
        };
        self.classes.iter().find(fits)
    }
}

impl Class {
    /// Share of the hops that rest at an offset.
    #[must_use]
    pub fn share(&self, offset: [i32; 2]) -> f64 {
        let landing = self.landings.iter().find(|landing| landing.offset == offset);
        landing.map_or(0.0, |landing| landing.probability)
    }
}

fn class(
    preset: Preset,
    (soil, along_deg, across_deg): (Soil, f64, f64),
    samples: u64,
    key: [u8; 32],
) -> Class {
    // To the left of a hop along x is y.
    let gradient = [along_deg, across_deg].map(|degrees| libm::tan(degrees.to_radians()));
    let hopper = HopperOn::new(preset, soil, gradient);
    let steepness = libm::hypot(gradient[0], gradient[1]);
    let is_too_steep = steepness > soil_of(preset, soil).rolling;
    // A few show that nothing rests there, each at the cost of thousands of arcs.
    let samples = if is_too_steep { samples.min(TOO_STEEP_HOPS) } else { samples };
    let mut counts = BTreeMap::<[i32; 2], u64>::new();
    let (mut far, mut away, mut displaced) = (0, 0, [0.0; 2]);
    let mut offset_m = [0.0; 2];
    for number in 0..samples {
        let noise = &mut Noise::new(key, number);
        let rest_m = match hopper.hop(offset_m, noise) {
            None => offset_m,
            Some(hop) if matches!(hop.end, End::Rest | End::Caught) => [hop.position.x, hop.position.y],
            Some(_) => {
                away += 1;
                offset_m = [0.0; 2];
                continue;
            }
        };
        let cell = rest_m.map(|metres| libm::floor(metres / HOP_M + 0.5));
        offset_m = [0, 1].map(|axis| rest_m[axis] - cell[axis] * HOP_M);
        let offset = cell.map(|hops| hops as i32);
        if (-1..=2).contains(&offset[0]) && (-2..=2).contains(&offset[1]) {
            *counts.entry(offset).or_default() += 1;
        } else {
            far += 1;
            displaced = [0, 1].map(|axis| displaced[axis] + cell[axis]);
        }
    }
    let mut counted: Vec<([i32; 2], u64)> = counts.into_iter().collect();
    counted.sort_by_key(|&(offset, count)| (std::cmp::Reverse(count), offset));
    for &(offset, count) in counted.get(LANDINGS_MAX..).unwrap_or_default() {
        far += count;
        displaced = [0, 1].map(|axis| displaced[axis] + f64::from(offset[axis]) * count as f64);
    }
    counted.truncate(LANDINGS_MAX);
    let rested = (samples - away).max(1);
    let landing = |(offset, count): ([i32; 2], u64)| {
        let interval = wilson(count, rested);
        Landing { offset, probability: count as f64 / rested as f64, low: interval.low, high: interval.high }
    };
    let mean = displaced.map(|hops| if far > 0 { hops / far as f64 } else { 0.0 });
    Class {
        soil,
        along_deg,
        across_deg,
        samples,
        landings: counted.into_iter().map(landing).collect(),
        far: Far { probability: far as f64 / rested as f64, mean },
        rolls_away: is_too_steep || 2 * away > samples,
    }
}
