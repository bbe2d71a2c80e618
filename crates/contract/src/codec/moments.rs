//! The moments of a decision.

use super::Codec;
use crate::{MonotonicNs, Refusal, Timing};

/// The moments of a decision, monotonic nanoseconds.
pub(crate) struct Moments;

/// The moments of a decision from landing to landing, in the order of [`Timing`].
pub(crate) const MOMENTS: Moments = Moments;

impl Codec<[u64; 8]> for Moments {
    type Value = Timing;

    fn to_wire(&self, timing: &Timing) -> [u64; 8] {
        timing.moments().map(|moment| moment.0)
    }

    fn from_wire(&self, _: &str, wire: [u64; 8]) -> Result<Timing, Refusal> {
        Ok(Timing::from_moments(wire.map(MonotonicNs)))
    }

    fn range(&self) -> String {
        "any".into()
    }
}
