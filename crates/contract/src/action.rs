//! What a planner may ask of the hopper.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A hop's direction on the grid; north is +y, east is +x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// +y.
    North,
    /// +x.
    East,
    /// −y.
    South,
    /// −x.
    West,
}

impl Direction {
    /// In the order in which ties are broken.
    pub const ALL: [Direction; 4] = [Direction::North, Direction::East, Direction::South, Direction::West];

    /// The unit step (dx, dy) in cells.
    #[must_use]
    pub fn step(self) -> (i32, i32) {
        match self {
            Direction::North => (0, 1),
            Direction::East => (1, 0),
            Direction::South => (0, -1),
            Direction::West => (-1, 0),
        }
    }

    /// A quarter turn counter-clockwise: the left of one who faces this way.
    #[must_use]
    pub fn left(self) -> Self {
        match self {
            Direction::North => Direction::West,
            Direction::East => Direction::North,
            Direction::South => Direction::East,
            Direction::West => Direction::South,
        }
    }

    /// A quarter turn clockwise: the right of one who faces this way.
    #[must_use]
    pub fn right(self) -> Self {
        self.left().left().left()
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Direction::North => "north",
            Direction::East => "east",
            Direction::South => "south",
            Direction::West => "west",
        })
    }
}

/// One command to the hopper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Stand still: a decision like any other, and the safe one.
    Hold,
    /// Hop one hop distance at 45°.
    Hop(Direction),
}

impl Action {
    /// Every action, in the order of their wire codes.
    pub const ALL: [Action; 5] = [
        Action::Hold,
        Action::Hop(Direction::North),
        Action::Hop(Direction::East),
        Action::Hop(Direction::South),
        Action::Hop(Direction::West),
    ];

    /// The code on the wire: 0 hold, 1 north, 2 east, 3 south, 4 west.
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Action::Hold => 0,
            Action::Hop(direction) => 1 + direction as u32,
        }
    }

    /// The action of a wire code, if there is one.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.get(code as usize).copied()
    }
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Action::Hold => f.pad("hold"),
            Action::Hop(direction) => direction.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_of_north_is_west_and_right_is_east() {
        assert_eq!(Direction::North.left(), Direction::West);
        assert_eq!(Direction::North.right(), Direction::East);
        for direction in Direction::ALL {
            assert_eq!(direction.left().right(), direction);
            let (dx, dy) = direction.step();
            assert_eq!(direction.left().step(), (-dy, dx), "left is a quarter turn counter-clockwise");
        }
    }

    #[test]
    fn every_action_survives_its_code() {
        for action in Action::ALL {
            assert_eq!(Action::from_code(action.code()), Some(action));
        }
        assert_eq!(Action::from_code(5), None);
    }
}
