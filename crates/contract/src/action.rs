//! What a planner may ask of a robot.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::RouteId;

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

/// One command to a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Stand still: a decision like any other, and the safe one.
    Hold,
    /// A hopper: hop one hop distance at 45°.
    Hop(Direction),
    /// A rover: drive to the neighbouring cell.
    Step(Direction),
    /// A driving rover: drive to the next point of its route.
    Drive,
    /// A helicopter: fly to the next point of its route.
    Fly,
    /// Act again once another robot has acted.
    Wait,
    /// The robot acts no more in this mission; the others go on.
    Done,
    /// Take the route of that fingerprint for one's own, from its first point on.
    Announce(RouteId),
    /// A hopper: hop one hop distance at 80°, up what a hop at its own angle would run into. Only where the scenario has
    /// vertical hops.
    Up(Direction),
}

impl Action {
    /// Every action without a route, in the order of their wire codes.
    pub const ALL: [Action; 17] = [
        Action::Hold,
        Action::Hop(Direction::North),
        Action::Hop(Direction::East),
        Action::Hop(Direction::South),
        Action::Hop(Direction::West),
        Action::Step(Direction::North),
        Action::Step(Direction::East),
        Action::Step(Direction::South),
        Action::Step(Direction::West),
        Action::Drive,
        Action::Fly,
        Action::Wait,
        Action::Done,
        Action::Up(Direction::North),
        Action::Up(Direction::East),
        Action::Up(Direction::South),
        Action::Up(Direction::West),
    ];

    /// The code of every announcement, whatever its route.
    const ANNOUNCE: u32 = 13;

    /// Number of wire codes.
    pub const CODES: usize = Self::ALL.len() + 1;

    /// The code on the wire: 0 hold, 1 to 4 hop north, east, south, west, 5 to 8 step so, 9 drive, 10 fly, 11 wait, 12
    /// done, 13 announce, 14 to 17 hop up north, east, south, west. Journals hold them: new ones are appended.
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Action::Hold => 0,
            Action::Hop(direction) => 1 + direction as u32,
            Action::Step(direction) => 5 + direction as u32,
            Action::Drive => 9,
            Action::Fly => 10,
            Action::Wait => 11,
            Action::Done => 12,
            Action::Announce(_) => Self::ANNOUNCE,
            Action::Up(direction) => 14 + direction as u32,
        }
    }

    /// Where a hopper hops to by it, at whatever angle.
    #[must_use]
    pub fn hop(self) -> Option<Direction> {
        match self {
            Action::Hop(direction) | Action::Up(direction) => Some(direction),
            _ => None,
        }
    }

    /// The action of a wire code, if there is one; announcements need [`Action::with_route`].
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|action| action.code() == code)
    }

    /// The action of a wire code and a route, 0 for none, if there is one.
    #[must_use]
    pub fn with_route(code: u32, route: u64) -> Option<Self> {
        match (code == Self::ANNOUNCE, route) {
            (true, 0) => None,
            (true, route) => Some(Action::Announce(RouteId(route))),
            (false, 0) => Self::from_code(code),
            (false, _) => None,
        }
    }

    /// The route that it announces, 0 for none.
    #[must_use]
    pub fn route(self) -> u64 {
        match self {
            Action::Announce(RouteId(route)) => route,
            _ => 0,
        }
    }
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Action::Hold => f.pad("hold"),
            Action::Hop(direction) => direction.fmt(f),
            Action::Step(direction) => f.pad(match direction {
                Direction::North => "step_north",
                Direction::East => "step_east",
                Direction::South => "step_south",
                Direction::West => "step_west",
            }),
            Action::Drive => f.pad("drive"),
            Action::Fly => f.pad("fly"),
            Action::Wait => f.pad("wait"),
            Action::Done => f.pad("done"),
            Action::Announce(_) => f.pad("announce"),
            Action::Up(direction) => f.pad(match direction {
                Direction::North => "up_north",
                Direction::East => "up_east",
                Direction::South => "up_south",
                Direction::West => "up_west",
            }),
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
            assert_eq!(Action::with_route(action.code(), 0), Some(action));
            assert_eq!(Action::with_route(action.code(), 7), None, "{action} has no route");
        }
        let announce = Action::Announce(RouteId(7));
        assert_eq!(Action::with_route(announce.code(), announce.route()), Some(announce));
        assert_eq!(Action::with_route(announce.code(), 0), None);
        assert_eq!(Action::from_code(13), None);
        assert_eq!(Action::ALL.map(Action::code).into_iter().max(), Some(Action::CODES as u32 - 1));
        assert_eq!(Action::Up(Direction::West).code(), 17);
    }
}
