//! Worlds of the study: what is known of the ground beforehand, what is true, and where the rover is to go.

use std::sync::Arc;

use helicopter::Sensor;
use routing::{Goal, Stream, Trip};
use rover::{Belief, Lattice, Point, Speed, SpeedDistribution, Surface, Truth};

/// A world with its task.
#[derive(Clone, Debug)]
pub struct World {
    /// The speeds as everyone knows them before the mission.
    pub prior: Belief,
    /// The speeds as they are.
    pub truth: Truth,
    /// Where the rover starts, and where it is to go.
    pub trip: Trip,
}

/// The goal counts as reached from here on.
const GOAL_RADIUS_M: f64 = 3.0;

/// Side of the Monte Carlo world, in cells.
const SIDE: usize = 200;
/// Middles of the impassable discs, and their radius.
const DISCS: ([(f64, f64); 2], f64) = ([(100.0, 62.5), (100.0, 137.5)], 25.0);
/// Middles of the elliptical passages, and their semi-axes.
const PASSAGES: ([(f64, f64); 3], (f64, f64)) =
    ([(100.0, 20.0), (100.0, 100.0), (100.0, 180.0)], (35.0, 22.0));

/// What a camera that errs reads on ground of these speeds: the same whenever and by whichever helicopter a cell is looked at.
#[must_use]
pub fn readings(speeds: &[Speed], camera: &Sensor, seed: u64) -> Vec<Speed> {
    let mut draws = Stream::new(seed, "camera readings");
    speeds.iter().map(|speed| camera.reading(*speed, draws.uniform())).collect()
}

/// What lies where on the Monte Carlo world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Region {
    Background,
    Disc,
    Passage(usize),
}

/// The region of each cell by its middle; where a disc and a passage overlap, the disc wins.
fn region(at: Point) -> Region {
    let (discs, radius_m) = DISCS;
    if discs.iter().any(|(x_m, y_m)| at.distance_m(Point::new(*x_m, *y_m)) <= radius_m) {
        return Region::Disc;
    }
    let (passages, (a_m, b_m)) = PASSAGES;
    let inside =
        |(x_m, y_m): &(f64, f64)| ((at.x_m - x_m) / a_m).powi(2) + ((at.y_m - y_m) / b_m).powi(2) <= 1.0;
    passages.iter().position(inside).map_or(Region::Background, Region::Passage)
}

/// The world of P21, Fig. 13, for a seed: two discs, three passages, start in the west, goal in the east.
#[must_use]
pub fn monte_carlo(seed: u64) -> World {
    let mut draws = Stream::new(seed, "monte carlo world");
    let priors = loop {
        let priors = [0; 3].map(|_| passage_prior(&mut draws));
        if priors.iter().any(|prior| prior.probability(Speed::Zero) == 0.0) {
            break priors;
        }
    };
    let truths = priors.map(|prior| prior.quantile(draws.uniform()));
    let start = Point::new(draws.between(5.0, 10.0), draws.between(0.0, SIDE as f64));
    let goal = Point::new(draws.between(190.0, 195.0), draws.between(0.0, SIDE as f64));
    monte_carlo_regions(priors, truths, start, goal)
}

/// The Monte Carlo world with these passages, from south to north.
///
/// # Panics
/// Never: the lattice has as many cells as there are speeds.
#[must_use]
pub fn monte_carlo_regions(
    priors: [SpeedDistribution; 3],
    truths: [Speed; 3],
    start: Point,
    goal: Point,
) -> World {
    let lattice = Lattice::new(SIDE, SIDE).expect("200 cells a side are within the limits");
    let regions: Vec<Region> = (0..lattice.cells()).map(|cell| region(lattice.centre(cell))).collect();
    let prior = regions.iter().map(|region| match region {
        Region::Background => SpeedDistribution::certain(Speed::Fast),
        Region::Disc => SpeedDistribution::certain(Speed::Zero),
        Region::Passage(passage) => priors[*passage],
    });
    let truth = regions.iter().map(|region| match region {
        Region::Background => Speed::Fast,
        Region::Disc => Speed::Zero,
        Region::Passage(passage) => truths[*passage],
    });
    World {
        prior: Belief::new(Arc::new(Surface::flat(lattice)), prior.collect()).expect("a speed for each cell"),
        truth: Truth { speeds: truth.collect() },
        trip: Trip { start, goal: Goal { at: goal, radius_m: GOAL_RADIUS_M } },
    }
}

/// Risky with probability ½, otherwise Dirichlet(1, 1, 1) over the three speeds above 0.
fn passage_prior(draws: &mut Stream) -> SpeedDistribution {
    let probabilities = if draws.uniform() < 0.5 {
        let stuck = draws.between(0.3, 0.7);
        [stuck, 0.0, 0.0, 1.0 - stuck]
    } else {
        // Exponentials over their sum.
        let weights = [0; 3].map(|_| -libm::log(1.0 - draws.uniform()));
        let sum: f64 = weights.iter().sum();
        [0.0, weights[0] / sum, weights[1] / sum, weights[2] / sum]
    };
    SpeedDistribution::new(probabilities).expect("the probabilities sum to 1 as drawn")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_region_is_that_of_the_paper_and_discs_win() {
        assert_eq!(region(Point::new(100.0, 80.0)), Region::Disc);
        assert_eq!(region(Point::new(100.0, 100.0)), Region::Passage(1));
        assert_eq!(region(Point::new(134.0, 180.0)), Region::Passage(2));
        assert_eq!(region(Point::new(136.0, 180.0)), Region::Background);
    }

    #[test]
    fn a_world_is_a_function_of_its_seed_and_never_has_risky_passages_only() {
        let mut risky = 0;
        for seed in 0..300 {
            let world = monte_carlo(seed);
            let passages = PASSAGES.0.map(|(x_m, y_m)| {
                world.prior.cells()[world.prior.surface().lattice().cell(Point::new(x_m, y_m))]
            });
            let risks = passages.iter().filter(|prior| prior.probability(Speed::Zero) > 0.0).count();
            assert!(risks < 3);
            risky += risks;
            assert!((5.0..10.0).contains(&world.trip.start.x_m));
            assert!((190.0..195.0).contains(&world.trip.goal.at.x_m));
        }
        // 3/7 of 900 are expected, with a standard deviation of 13.
        assert!((386 - 45..386 + 45).contains(&risky), "{risky}");
        assert_eq!(monte_carlo(5).prior, monte_carlo(5).prior);
    }
}
