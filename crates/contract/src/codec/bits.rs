//! Sets of numbers.

use super::{Codec, Ends};
use crate::limits::TREASURES_MAX;
use crate::{Action, Refusal};

/// A set of numbers, one bit for each.
pub(crate) struct Bits(usize);

/// A bit for each treasure of a scenario.
pub(crate) const TREASURE_BITS: Bits = Bits(TREASURES_MAX);

/// A bit for each action.
pub(crate) const ACTION_BITS: Bits = Bits(Action::CODES);

impl Codec<u32> for Bits {
    type Value = u32;

    fn to_wire(&self, value: &u32) -> u32 {
        *value
    }

    fn from_wire(&self, field: &str, wire: u32) -> Result<u32, Refusal> {
        if wire >> self.0 == 0 {
            Ok(wire)
        } else {
            Err(Refusal::malformed(field, &self.range(), format!("{wire:#b}")))
        }
    }

    fn range(&self) -> String {
        format!("bits 0 to {}", self.0 - 1)
    }

    fn ends(&self) -> Ends<u32> {
        Ends { inside: vec![0, (1 << self.0) - 1], outside: vec![1 << self.0] }
    }
}
