//! The scatter of a hop: where it may come down, with which probability (P23 section IV).
//!
//! With p, q, s the probabilities of the intended landing, of getting stuck, and of a slip to either
//! side on the flat, and with the slope towards a direction d, θ_d = atan(∇h·d), measured in slope
//! limits, t_d = θ_d / limit:
//!
//! | intended | stays | to the left | to the right |
//! |---|---|---|---|
//! | p (1 − t_f) | p t_f + q | s (1 − t_r) | s (1 − t_l) |
//!
//! t_f, forwards, is clamped to [0, 1]: going down is no easier than the flat. t_l = −t_r is clamped to
//! [−1, 1]. The slope is taken at the cell of departure. A slope that rises to the left makes the slip
//! to the left the likelier one, as the paper prints it.

use contract::{Branch, Direction, Ground, MotionParameters, Soil, SoilMotion};

/// Probabilities of a hop's landings; each in [0, 1], together 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// Lands where it was meant to.
    pub intended: f64,
    /// Does not get away.
    pub stayed: f64,
    /// Slips one hop to the left of the hop's direction.
    pub left: f64,
    /// Slips one hop to the right; takes the remainder, so that the four sum to 1.
    pub right: f64,
}

impl Transition {
    /// The probability of one branch; 0 for [`Branch::Held`], which no hop ends in.
    #[must_use]
    pub fn probability(&self, branch: Branch) -> f64 {
        match branch {
            Branch::Intended => self.intended,
            Branch::Stayed => self.stayed,
            Branch::Left => self.left,
            Branch::Right => self.right,
            Branch::Held => 0.0,
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

/// The scatter on one soil.
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
/// If the soil's probabilities are not ones, or the slope limit is not above 0: both are checked
/// where a brief enters a process.
#[must_use]
pub fn transitions(parameters: &MotionParameters, ground: &Ground) -> [Transition; 4] {
    let SoilMotion { intended, stuck, sideways, .. } = *soil_motion(parameters, ground.soil);
    let sum = intended + stuck + 2.0 * sideways;
    assert!((sum - 1.0).abs() <= 1e-6, "the scatter of one soil needs to sum to 1, got {sum}");
    assert!(parameters.slope_limit_rad > 0.0, "a slope limit is above 0, got {}", parameters.slope_limit_rad);
    // atan is odd, so one slope each along x and along y serves all directions.
    let east = libm::atan(ground.gradient[0]) / parameters.slope_limit_rad;
    let north = libm::atan(ground.gradient[1]) / parameters.slope_limit_rad;
    let towards = |direction| match direction {
        Direction::North => north,
        Direction::East => east,
        Direction::South => -north,
        Direction::West => -east,
    };
    Direction::ALL.map(|direction| {
        let forwards = towards(direction).clamp(0.0, 1.0);
        let right_up = towards(direction.right()).clamp(-1.0, 1.0);
        let transition = Transition {
            intended: intended * (1.0 - forwards),
            stayed: intended * forwards + stuck,
            left: sideways * (1.0 - right_up),
            right: 0.0,
        };
        let others = transition.intended + transition.stayed + transition.left;
        Transition { right: (1.0 - others).max(0.0), ..transition }
    })
}
