//! Objects worth a detour (P23 section IV-B5): known once their cell is seen, collected once, on landing.

use serde::{Deserialize, Serialize};

use crate::Cell;
use crate::limits::TREASURES_MAX;

/// Which of a scenario's treasures have been collected: one bit for each, in the order of their cells'
/// indices. It tells how many, and nothing of where the others lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub struct Collected(pub u32);

const _: () = assert!(TREASURES_MAX <= u32::BITS as usize);

impl Collected {
    /// How many treasures are collected.
    #[must_use]
    pub fn count(self) -> u32 {
        self.0.count_ones()
    }

    /// What is collected after landing on `cell`, with `treasures` those of the scenario in index order.
    #[must_use]
    pub fn landing(self, treasures: &[Cell], cell: Cell) -> Self {
        let found = treasures.iter().position(|treasure| *treasure == cell);
        Self(self.0 | found.map_or(0, |number| 1 << number))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_treasure_is_collected_once() {
        let treasures = [Cell::new(4, 1), Cell::new(0, 2)];
        let none = Collected::default();
        let one = none.landing(&treasures, treasures[1]);
        assert_eq!((none.count(), one.count()), (0, 1));
        assert_eq!(one.landing(&treasures, treasures[1]), one);
        assert_eq!(one.landing(&treasures, Cell::new(1, 1)), one);
        assert_eq!(one.landing(&treasures, treasures[0]), Collected(0b11));
    }
}
