//! The vertical hop, which reaches the top of a rock that a hop at 45° would run into (P22 section "Vertical hopping").
//!
//! With f = Δh / h_max, Δh the height difference to the landing aimed at and h_max the apex at the steep
//! angle, and p, s, q the scatter of the soil on the flat:
//!
//! | intended | to either side | stays |
//! |---|---|---|
//! | p (1 − f) | s (1 − f) | q (1 − f) + f |
//!
//! The paper's plain has q = 0. The slope law does not apply, because the plain is flat: Δh takes its place.

use contract::SoilMotion;

use crate::Transition;

/// The scatter of a vertical hop that rises `rise_m`, with an apex of `apex_height_m` above its launch;
/// `None` if the rise is not below the apex, so that no hop gets there.
///
/// # Panics
/// If the rise is not finite, or the apex not above 0.
#[must_use]
pub fn vertical_transition(motion: &SoilMotion, rise_m: f64, apex_height_m: f64) -> Option<Transition> {
    assert!(
        rise_m.is_finite() && apex_height_m > 0.0,
        "need a rise and an apex, got {rise_m} m, {apex_height_m} m"
    );
    let failing = rise_m.abs() / apex_height_m;
    if rise_m >= apex_height_m || failing >= 1.0 {
        return None;
    }
    let working = 1.0 - failing;
    let (intended, left) = (motion.intended * working, motion.sideways * working);
    let stayed = motion.stuck * working + failing;
    Some(Transition { intended, stayed, left, right: (1.0 - intended - stayed - left).max(0.0) })
}
