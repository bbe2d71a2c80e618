//! The slope law: how the slope at the cell of departure changes where a hop lands (Sakamoto & Kunii 2023, section IV).
//!
//! With p, q, s the probabilities of the intended landing, of getting stuck, and of a slip to either side on the flat,
//! and t_d the slope towards direction d ([`slope_in_limits`]):
//!
//! | intended | stays | to the left | to the right |
//! |---|---|---|---|
//! | p (1 − t_f) | p t_f + q | s (1 − t_r) | s (1 − t_l) |
//!
//! t_f, forwards, is clamped to [0, 1]: going down is no easier than the flat. t_l = −t_r is clamped to [−1, 1]. A
//! slope that rises to the left makes the slip to the left the likelier one, as the paper prints it.
//!
//! ```
//! let hard = scatter::FlatScatter { intended: 0.9, stuck: 0.0, sideways: 0.05 };
//! let uphill = hard.on_slope(0.5, 0.0);
//! assert_eq!((uphill.intended, uphill.stayed), (0.45, 0.45), "half the hops slide back");
//! ```
//!
//! The simulator's physics and the solver's model of it both take the law from here. The crate knows neither messages
//! nor grids, so the solver may depend on it.

#![warn(clippy::disallowed_methods)]
#![forbid(unsafe_code)]

/// Probabilities of a hop's landings, each in [0, 1], together 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Lands on the node ahead, as intended.
    pub intended: f64,
    /// Lands where it departed.
    pub stayed: f64,
    /// Slips one hop to the left of the hop's direction.
    pub left: f64,
    /// Slips one hop to the right; computed as the remainder, so that the four sum to 1.
    pub right: f64,
}

/// Probabilities of a hop's landings on flat ground of one soil: intended + stuck + 2 · sideways = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatScatter {
    /// Probability p of the intended landing.
    pub intended: f64,
    /// Probability q of getting stuck.
    pub stuck: f64,
    /// Probability s of a slip to either side.
    pub sideways: f64,
}

impl FlatScatter {
    /// The landings of a hop where the slope towards the hop is `ahead` and the slope to its right is `to_right`, in
    /// slope limits; beyond ±1 as ±1.
    #[inline]
    #[must_use]
    pub fn on_slope(&self, ahead: f64, to_right: f64) -> Scatter {
        let Self { intended, stuck, sideways } = *self;
        let forwards = ahead.clamp(0.0, 1.0);
        let to_right = to_right.clamp(-1.0, 1.0);
        let scatter = Scatter {
            intended: intended * (1.0 - forwards),
            stayed: intended * forwards + stuck,
            left: sideways * (1.0 - to_right),
            right: 0.0,
        };
        let others = scatter.intended + scatter.stayed + scatter.left;
        Scatter { right: (1.0 - others).max(0.0), ..scatter }
    }
}

/// A slope as the law measures it: the angle of `gradient` (metres per metre) divided by the slope limit, the angle at
/// which no hop gets away uphill.
#[inline]
#[must_use]
pub fn slope_in_limits(gradient: f64, slope_limit_rad: f64) -> f64 {
    libm::atan(gradient) / slope_limit_rad
}
