//! The choice of the hop, as a function of the world alone.
//!
//! # The canonical hop
//! Let g_u = max q* − q*_u be the gap between hop u and the best, under the true values V*. The hop to take is the first
//! of north, east, south, west with g_u ≤ δ ([`TIE`]). Bounds can only tell on which side of δ a gap lies, so the
//! *canonical procedure* fixes what happens at δ itself: solve the world from nothing to |V − V*| ≤ ε
//! ([`CANONICAL_ERROR`]), and take the first hop whose computed gap ĝ_u is at most δ. That depends on the world alone.
//!
//! # The same hop whatever the history
//! Whatever bounds are known, and however they were found, q_u ∈ \[lower_u, upper_u\] gives
//! max lower − upper_u ≤ g_u ≤ max upper − lower_u. Each computed q̂ is within γ ε of the true one, so
//! |ĝ_u − g_u| ≤ 2 ε, rounding included with room to spare ([`GAP_MARGIN`]). Hence
//!
//! - g_u certainly ≤ δ − [`GAP_MARGIN`] ⇒ ĝ_u ≤ δ: the canonical procedure counts u among the best;
//! - g_u certainly > δ + [`GAP_MARGIN`] ⇒ ĝ_u > δ: it does not.
//!
//! If the hops in order are certainly not among the best, up to one that certainly is, then that one is the canonical
//! hop, and the procedure need not run. Otherwise it runs. So every history gives the same answer, by proof.
//!
//! On flat ground, full of ties, g_u = 0 exactly, and any interval narrower than δ − [`GAP_MARGIN`] decides. The
//! procedure is needed only for gaps that happen to lie within a few millionths of δ.

use crate::Hop;

/// δ: hops with at most this gap to the best are equally good, in units of payoff.
pub const TIE: f64 = 1e-5;

/// ε: the error of the canonical procedure's values, in units of payoff.
pub const CANONICAL_ERROR: f64 = 1e-7;

/// Distance from δ that a gap needs for bounds to decide, in units of payoff.
pub const GAP_MARGIN: f64 = 2.5 * CANONICAL_ERROR;

/// Bounds on the values of the four hops, in the order of [`Hop::ALL`], in units of payoff.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// No hop's value is less.
    pub lower: [f64; 4],
    /// No hop's value is more.
    pub upper: [f64; 4],
}

impl Bounds {
    /// The canonical hop, if the bounds are close enough.
    #[must_use]
    pub fn hop(&self) -> Option<Hop> {
        let best_lower = self.lower.into_iter().fold(f64::NEG_INFINITY, f64::max);
        for hop in Hop::ALL {
            // A hop has no gap to itself, however wide its bounds are.
            if -self.margin(hop) <= TIE - GAP_MARGIN {
                return Some(hop);
            }
            let certainly_worse = best_lower - self.upper[hop as usize] > TIE + GAP_MARGIN;
            if !certainly_worse {
                return None;
            }
        }
        None
    }

    /// By how much `hop` is certainly better than each other; negative if one may be better by as much.
    #[must_use]
    pub fn margin(&self, hop: Hop) -> f64 {
        let others = Hop::ALL.into_iter().filter(|other| *other != hop);
        let rival = others.map(|other| self.upper[other as usize]).fold(f64::NEG_INFINITY, f64::max);
        self.lower[hop as usize] - rival
    }

    /// Width of the widest interval.
    #[must_use]
    pub fn width(&self) -> f64 {
        (0..4).map(|hop| self.upper[hop] - self.lower[hop]).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(values: [f64; 4], error: f64) -> Bounds {
        Bounds { lower: values.map(|v| v - error), upper: values.map(|v| v + error) }
    }

    #[test]
    fn equals_go_to_the_first_and_a_doubtful_loss_is_not_guessed() {
        assert_eq!(around([1.0; 4], 1e-6).hop(), Some(Hop::North));
        assert_eq!(around([0.0, 1.0, 1.0, 0.0], 1e-6).hop(), Some(Hop::East));
        assert_eq!(around([1.0 - 0.5 * TIE, 1.0, 1.0, 0.0], 1e-6).hop(), Some(Hop::North));
        assert_eq!(around([1.0 - 2.0 * TIE, 1.0, 1.0, 0.0], 1e-6).hop(), Some(Hop::East));
        assert_eq!(around([1.0 - TIE, 1.0, 1.0, 0.0], 1e-6).hop(), None);
        // Whether south is among the best does not matter once east certainly is.
        assert_eq!(around([0.0, 1.0, 1.0 - TIE, 0.0], 1e-6).hop(), Some(Hop::East));
        assert_eq!(around([1.0; 4], TIE).hop(), None);
    }

    #[test]
    fn no_bounds_disagree_with_the_computed_losses_they_contain() {
        // Gaps around δ, with every error the canonical procedure may make, and every interval that holds it.
        for step in 0..400 {
            let gap = TIE + GAP_MARGIN * 4.0 * (f64::from(step) / 200.0 - 1.0);
            let q = [5.0 - gap, 5.0, 4.0, 5.0];
            for error in [0.0, 1e-8, 1e-7, 1e-6, 4e-6] {
                let Some(hop) = around(q, error).hop() else { continue };
                for sign in [-1.0, 1.0] {
                    let e = CANONICAL_ERROR;
                    let computed = [q[0] + sign * e, q[1] - sign * e, q[2], q[3] - sign * e];
                    assert_eq!(crate::policy::first_best(computed, TIE), hop, "gap {gap:e}, error {error:e}");
                }
            }
        }
    }
}
