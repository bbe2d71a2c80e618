//! All that a rover's decision may depend on.

use contract::{Cell, CoverMode, Direction, Placement};

use crate::TeamMap;
use crate::region;
use crate::team_map::Place;

/// A rover as its team knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rover {
    /// Placement before its first step. Its heading is the sweep axis of a boustrophedon; its cell is the centre of its
    /// region in [`CoverMode::Voronoi`].
    pub start: Placement,
    /// Placement now.
    pub pose: Placement,
    /// Whether it has failed. It stays where it is for good and still occupies its cell.
    pub stranded: bool,
}

impl Rover {
    /// A rover before its first step.
    #[must_use]
    pub fn at(start: Placement) -> Self {
        Self { start, pose: start, stranded: false }
    }
}

/// What one rover of a team knows when it decides.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// What all rovers have sensed and visited.
    pub map: &'a TeamMap,
    /// All rovers in the order of their numbers, at most [`Situation::ROVERS_MAX`].
    pub rovers: &'a [Rover],
    /// How they share the ground.
    pub mode: CoverMode,
    /// Number of the rover that decides.
    pub robot: usize,
}

impl Situation<'_> {
    /// Most rovers of a team.
    pub const ROVERS_MAX: usize = 16;

    /// The rover that decides.
    #[must_use]
    pub fn own(&self) -> &Rover {
        &self.rovers[self.robot]
    }

    /// Whether another rover stands on `place`.
    pub(crate) fn is_occupied(&self, place: Place) -> bool {
        let others = self.rovers.iter().enumerate().filter(|(robot, _)| *robot != self.robot);
        others.map(|(_, rover)| self.map.place(rover.pose.cell)).any(|other| other == place)
    }

    /// Whether a rover that can still move stands at most `steps` steps from this one, obstacles left aside.
    pub(crate) fn others_within(&self, steps: u32) -> bool {
        let Cell { x, y } = self.own().pose.cell;
        let near = |cell: Cell| cell.x.abs_diff(x) + cell.y.abs_diff(y) <= steps;
        let mut others = self.rovers.iter().enumerate().filter(|(robot, _)| *robot != self.robot);
        others.any(|(_, rover)| !rover.stranded && near(rover.pose.cell))
    }

    /// Whether `place` is sensed free ground on which the mode lets this rover drive.
    pub(crate) fn is_open(&self, place: Place) -> bool {
        self.map.is_free(place) && self.is_own(place)
    }

    /// How many of the four cells beside `place` this rover may still have to cover.
    pub(crate) fn uncovered_neighbours(&self, place: Place) -> u32 {
        let beside = Direction::ALL.map(|direction| self.map.neighbour(place, direction));
        beside.into_iter().map(|beside| u32::from(self.map.is_uncovered(beside) && self.is_own(beside))).sum()
    }

    /// Whether the mode lets this rover drive on `place`.
    fn is_own(&self, place: Place) -> bool {
        let starts = self.rovers.iter().map(|rover| rover.start.cell);
        self.mode == CoverMode::Overlap || region::nearest_start(starts, self.map.cell(place)) == self.robot
    }
}
