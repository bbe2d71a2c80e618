//! The scatter of a hop on observed or true ground: the slope law ([`scatter`]) in the contract's terms.
//!
//! The slope is taken at the cell of departure, from the gradient ∇h of its ground.

use contract::{Branch, Direction, Ground, MotionParameters, Soil, SoilMotion};
use scatter::{FlatScatter, Scatter, slope_in_limits};

/// Probabilities of a hop's branches, each in [0, 1], together 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// Lands on the cell ahead, as intended.
    pub intended: f64,
    /// Lands where it departed.
    pub stayed: f64,
    /// Slips one hop to the left of the hop's direction.
    pub left: f64,
    /// Slips one hop to the right; computed as the remainder, so that the four sum to 1.
    pub right: f64,
}

impl From<Scatter> for Transition {
    fn from(Scatter { intended, stayed, left, right }: Scatter) -> Self {
        Self { intended, stayed, left, right }
    }
}

impl Transition {
    /// The probability of one branch; 0 for those that no hop ends in.
    #[must_use]
    pub fn probability(&self, branch: Branch) -> f64 {
        match branch {
            Branch::Intended => self.intended,
            Branch::Stayed => self.stayed,
            Branch::Left => self.left,
            Branch::Right => self.right,
            Branch::Held | Branch::Stranded | Branch::Halted | Branch::Elsewhere | Branch::RolledAway => 0.0,
        }
    }

    /// The branch that a uniform draw from [0, 1) selects, in the order intended, stayed, left, right.
    #[must_use]
    pub fn branch(&self, uniform: f64) -> Branch {
        if uniform < self.intended {
            Branch::Intended
        } else if uniform < self.intended + self.stayed {
            Branch::Stayed
        } else if uniform < self.intended + self.stayed + self.left {
            Branch::Left
        } else {
            Branch::Right
        }
    }
}

/// The motion parameters of one soil.
#[must_use]
pub fn soil_motion(parameters: &MotionParameters, soil: Soil) -> &SoilMotion {
    match soil {
        Soil::Hard => &parameters.hard,
        Soil::Sand => &parameters.sand,
    }
}

/// The scatter of a hop from `ground` towards `direction`.
#[must_use]
pub fn transition(parameters: &MotionParameters, ground: &Ground, direction: Direction) -> Transition {
    transitions(parameters, ground)[direction as usize]
}

/// The scatter of the hops from `ground` in all four directions, in the order of [`Direction::ALL`].
///
/// # Panics
/// If the soil's probabilities do not sum to 1, or the slope limit is not above 0. Both are checked where a brief enters
/// a process.
#[must_use]
pub fn transitions(parameters: &MotionParameters, ground: &Ground) -> [Transition; 4] {
    let SoilMotion { intended, stuck, sideways, .. } = *soil_motion(parameters, ground.soil);
    let sum = intended + stuck + 2.0 * sideways;
    assert!((sum - 1.0).abs() <= 1e-6, "the scatter of one soil needs to sum to 1, got {sum}");
    assert!(
        parameters.slope_limit_rad > 0.0,
        "a slope limit needs to be above 0, got {}",
        parameters.slope_limit_rad
    );
    let flat = FlatScatter { intended, stuck, sideways };
    // The law is odd in the gradient, so one slope along x and one along y serve all directions.
    let [east, north] = ground.gradient.map(|gradient| slope_in_limits(gradient, parameters.slope_limit_rad));
    let towards = |direction| match direction {
        Direction::North => north,
        Direction::East => east,
        Direction::South => -north,
        Direction::West => -east,
    };
    Direction::ALL.map(|direction| flat.on_slope(towards(direction), towards(direction.right())).into())
}
