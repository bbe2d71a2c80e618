//! The four hops to neighbouring nodes.

/// A hop to one of the four neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Hop {
    /// To the row above: y grows.
    North,
    /// To the column after: x grows.
    East,
    /// To the row below.
    South,
    /// To the column before.
    West,
}

impl Hop {
    /// All four, in the order that breaks ties.
    pub const ALL: [Self; 4] = [Self::North, Self::East, Self::South, Self::West];

    /// The hop a quarter turn to the left.
    #[must_use]
    pub fn left(self) -> Self {
        Self::ALL[(self as usize + 3) % 4]
    }

    /// The hop a quarter turn to the right.
    #[must_use]
    pub fn right(self) -> Self {
        Self::ALL[(self as usize + 1) % 4]
    }
}
