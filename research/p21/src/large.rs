//! A stand-in for the Jezero map of Folsom et al. 2021, which is not public: 821 x 821 cells that are made, not measured.
//!
//! A long scarp lies between start and goal. Around its southern end leads a short way over ground that is either good or deep sand;
//! around its northern end a longer way, which is somewhat slower at worst. Speeds come from the mobility model: heights give the
//! slopes, and patches of ground have a probability for each terrain class. A patch has one true class.

use std::sync::Arc;

use routing::{Goal, Stream, Trip};
use rover::{
    Belief, Lattice, Point, SpeedDistribution, Surface, TerrainClass, Truth, speed, speed_distribution,
};

use crate::World;

/// Cells to a side. The paper's map has 673,854 cells, this one 674,041.
pub const LARGE_SIDE: usize = 821;

/// Where the rover starts, and the middle of its goal.
const START: Point = Point::new(262.0, 415.0);
const GOAL: Point = Point::new(558.0, 415.0);
const GOAL_RADIUS_M: f64 = 3.0;
/// The crest of the scarp runs north at this x, between these y.
const CREST_X_M: f64 = 410.0;
const CREST_Y_M: (f64, f64) = (338.0, 630.0);
/// Half the breadth of the ground that is classified as scarp.
const SCARP_HALF_M: f64 = 22.0;
/// Height of the crest, and the breadth of its slopes.
const CREST_M: (f64, f64) = (18.0, 14.0);
/// The short way leads through this rectangle: west, east, south, north.
const SHORT_WAY: (f64, f64, f64, f64) = (380.0, 440.0, 280.0, 338.0);
/// The long way leads through this one.
const LONG_WAY: (f64, f64, f64, f64) = (370.0, 450.0, 630.0, 821.0);
/// Patches elsewhere.
const PATCHES: usize = 10;
/// Share of the ground covered by rocks: everywhere, and in patches that are rocky.
const ROCKS: (f64, f64) = (0.03, 0.10);

/// The map: what is known of it, and what the truth is drawn from.
#[derive(Clone, Debug)]
pub struct LargeMap {
    surface: Arc<Surface>,
    prior: Belief,
    /// The patch of each cell; 0 is the ground between.
    patch_of: Vec<u8>,
    patches: Vec<Patch>,
}

/// Ground of one class, known as a probability.
#[derive(Clone, Debug)]
struct Patch {
    classes: [f64; 11],
    cfa: f64,
}

impl Patch {
    fn of(classes: &[(TerrainClass, f64)], cfa: f64) -> Self {
        let mut all = [0.0; 11];
        for (class, probability) in classes {
            all[*class as usize] = *probability;
        }
        Self { classes: all, cfa }
    }

    /// The class below which lies the share `uniform` of the distribution.
    fn class(&self, uniform: f64) -> TerrainClass {
        let mut sum = 0.0;
        let drawn = TerrainClass::ALL.into_iter().zip(self.classes).find(|(_, probability)| {
            sum += probability;
            uniform < sum
        });
        let likeliest = || {
            let classes = TerrainClass::ALL.into_iter().zip(self.classes);
            classes.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(class, _)| class)
        };
        drawn.map(|drawn| drawn.0).or_else(likeliest).expect("there are eleven classes")
    }
}

impl LargeMap {
    /// The map of a seed: waves of the ground and patches elsewhere differ, the two ways do not. The short way is good with
    /// probability `good`.
    ///
    /// # Panics
    /// If `good` is no probability.
    #[must_use]
    pub fn new(seed: u64, good: f64) -> Self {
        use TerrainClass::{DeepSand, RoughOutcrop, Scarp, SmoothRegolith, SparseLinearRipples};
        assert!((0.0..=1.0).contains(&good), "a probability needs 0 to 1, got {good}");
        let lattice = Lattice::new(LARGE_SIDE, LARGE_SIDE).expect("821 cells a side are within the limits");
        let mut draws = Stream::new(seed, "large map");
        let heights_m = heights_m(lattice, &mut draws);
        let surface =
            Arc::new(Surface::from_heights(lattice, &heights_m).expect("a finite height for each cell"));
        let mut patches = vec![
            Patch::of(&[(SmoothRegolith, 1.0)], ROCKS.0),
            Patch::of(&[(Scarp, 1.0)], ROCKS.0),
            // South of the short way.
            Patch::of(&[(DeepSand, 1.0)], ROCKS.0),
            Patch::of(
                &[(SmoothRegolith, 0.75 * good), (SparseLinearRipples, 0.25 * good), (DeepSand, 1.0 - good)],
                ROCKS.0,
            ),
            Patch::of(&[(SmoothRegolith, 0.5), (SparseLinearRipples, 0.5)], ROCKS.0),
        ];
        let mut discs = Vec::new();
        while discs.len() < PATCHES {
            let radius_m = draws.between(12.0, 28.0);
            let at = Point::new(draws.between(0.0, 821.0), draws.between(0.0, 821.0));
            let cfa = if draws.uniform() < 0.5 { ROCKS.0 } else { ROCKS.1 };
            let weights = [0; 3].map(|_| -libm::log(1.0 - draws.uniform()));
            let sum: f64 = weights.iter().sum();
            // Rover and goal stand on firm ground.
            if at.distance_m(START) > radius_m + 10.0 && at.distance_m(GOAL) > radius_m + 10.0 {
                let classes = [SmoothRegolith, SparseLinearRipples, RoughOutcrop];
                let classes: Vec<_> =
                    classes.into_iter().zip(weights).map(|(class, weight)| (class, weight / sum)).collect();
                discs.push((at, radius_m));
                patches.push(Patch::of(&classes, cfa));
            }
        }
        let patch = |cell: usize| patch(lattice.centre(cell), &discs);
        let patch_of: Vec<u8> = (0..lattice.cells()).map(patch).collect();
        let speeds = patch_of.iter().enumerate().map(|(cell, patch)| {
            let Patch { classes, cfa } = &patches[*patch as usize];
            speed_distribution(classes, surface.slope_deg(cell), *cfa).expect("sound properties")
        });
        let speeds: Vec<SpeedDistribution> = speeds.collect();
        let prior = Belief::new(Arc::clone(&surface), speeds).expect("a distribution for each cell");
        Self { surface, prior, patch_of, patches }
    }

    /// The map with a truth drawn for a seed. Start and goal are always the same.
    #[must_use]
    pub fn world(&self, seed: u64) -> World {
        let mut draws = Stream::new(seed, "large truth");
        let classes: Vec<TerrainClass> =
            self.patches.iter().map(|patch| patch.class(draws.uniform())).collect();
        let speeds = self.patch_of.iter().enumerate().map(|(cell, patch)| {
            let patch = *patch as usize;
            speed(classes[patch], self.surface.slope_deg(cell), self.patches[patch].cfa)
        });
        World {
            prior: self.prior.clone(),
            truth: Truth { speeds: speeds.collect() },
            trip: Trip { start: START, goal: Goal { at: GOAL, radius_m: GOAL_RADIUS_M } },
        }
    }
}

/// The patch of a point, by its place in the list.
fn patch(at: Point, discs: &[(Point, f64)]) -> u8 {
    let within = |(west, east, south, north): (f64, f64, f64, f64)| {
        (west..east).contains(&at.x_m) && (south..north).contains(&at.y_m)
    };
    let (south, north) = CREST_Y_M;
    let beside_m = (at.x_m - CREST_X_M).abs();
    if beside_m < SCARP_HALF_M && (south..north).contains(&at.y_m) {
        1
    } else if beside_m < SCARP_HALF_M + 5.0 && at.y_m < SHORT_WAY.2 {
        2
    } else if within(SHORT_WAY) {
        3
    } else if within(LONG_WAY) {
        4
    } else {
        let disc = discs.iter().position(|(middle, radius_m)| at.distance_m(*middle) < *radius_m);
        disc.map_or(0, |disc| disc as u8 + 5)
    }
}

/// Gentle waves with the scarp on top.
fn heights_m(lattice: Lattice, draws: &mut Stream) -> Vec<f64> {
    // Direction, wavelength and phase; a wave of 80 m and 0.9 m rises by 4 degrees.
    let waves: Vec<[f64; 3]> = (0..3)
        .map(|_| {
            let angle = draws.between(0.0, std::f64::consts::TAU);
            [angle, draws.between(80.0, 200.0), draws.between(0.0, std::f64::consts::TAU)]
        })
        .collect();
    let height = |at: Point| {
        let wave = |[angle, length_m, phase]: &[f64; 3]| {
            let along = at.x_m * libm::cos(*angle) + at.y_m * libm::sin(*angle);
            0.9 * libm::sin(std::f64::consts::TAU * along / length_m + phase)
        };
        let (crest_m, breadth_m) = CREST_M;
        let (south, north) = CREST_Y_M;
        let beyond_m = (south - at.y_m).max(at.y_m - north).max(0.0);
        let across = ((at.x_m - CREST_X_M) / breadth_m).powi(2) + (beyond_m / breadth_m).powi(2);
        waves.iter().map(wave).sum::<f64>() + crest_m * libm::exp(-across)
    };
    (0..lattice.cells()).map(|cell| height(lattice.centre(cell))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use routing::ett_exact;
    use rover::Caution;

    /// P-LARGE: The stand-in for Jezero has a short way that a careful rover takes only if it was
    /// seen to be good, and that then saves 30 %.
    #[test]
    fn the_short_way_is_closed_to_a_careful_rover_and_saves_a_third_where_it_is_good() {
        let map = LargeMap::new(1, 0.8);
        let good = (0..20).map(|seed| map.world(seed)).find(|world| {
            let short = world.prior.surface().lattice().cell(Point::new(410.0, 310.0));
            world.truth.speeds[short] == rover::Speed::Fast
        });
        let world = good.expect("a good short way is likely");
        let prior = ett_exact(&world.prior.expected_time(Caution::default()), &world.trip, 0.0).unwrap();
        let knowing = world.truth.known(Arc::clone(world.prior.surface())).unwrap();
        let best = ett_exact(&knowing.expected_time(Caution::default()), &world.trip, 0.0).unwrap();
        assert!(prior.points.iter().any(|point| point.y_m > 630.0), "around the northern end");
        assert!(best.points.iter().all(|point| point.y_m < 450.0), "around the southern end");
        assert!(best.cost < 0.7 * prior.cost, "{} against {}", best.cost, prior.cost);
        // The truth is possible under the prior.
        for (known, truth) in world.prior.cells().iter().zip(&world.truth.speeds) {
            assert!(known.probability(*truth) > 0.0);
        }
    }

    #[test]
    fn the_truth_of_the_short_way_is_drawn_with_its_probability() {
        let map = LargeMap::new(1, 0.8);
        let short = map.surface.lattice().cell(Point::new(410.0, 310.0));
        let good = (0..40).filter(|seed| map.world(*seed).truth.speeds[short] > rover::Speed::Zero).count();
        // 32 are expected, with a standard deviation of 2.5.
        assert!((24..=40).contains(&good), "{good} of 40");
        assert_eq!(map.world(7).truth, map.world(7).truth);
    }
}
