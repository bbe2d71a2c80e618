//! A robot as it is before the mission, and the robots of a mission.

use std::fmt;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::body::{Body, Hopper};
use super::goal::{Goal, Reach};
use super::sensor::{Sensor, SensorParameters};
use crate::limits::ROBOTS_MAX;
use crate::{Cell, Direction, Grid, MotionParameters, RobotId, RobotSet, Waypoint};

/// A cell, and the direction in which a robot faces there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Placement {
    /// On the grid.
    pub cell: Cell,
    /// The direction of the last step, or that of the start.
    pub heading: Direction,
}

/// What is known of a robot before the mission: what it is, what it sees, where it begins, and what it shall do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Robot {
    /// How it gets about.
    pub body: Body,
    /// What it sees of the ground around it.
    pub sensor: Sensor,
    /// Where it begins. No two robots on the ground begin on one cell, unless they drive from point to point.
    pub start: Placement,
    /// Where it begins exactly, metres; of a robot that goes from cell to cell the middle of its cell.
    pub start_at: Waypoint,
    /// What it shall do.
    pub goal: Goal,
    /// Whether the mission needs its goal to be reached, and has failed once it cannot be.
    pub required: bool,
}

impl Robot {
    /// A hopper that shall go from one cell to another.
    #[must_use]
    pub fn hopper(
        grid: &Grid,
        motion: MotionParameters,
        sensor: SensorParameters,
        [start, goal]: [Cell; 2],
    ) -> Self {
        Self {
            body: Body::Hopper(Hopper { motion }),
            sensor: Sensor::Disc(sensor),
            start: Placement { cell: start, heading: Direction::North },
            start_at: Waypoint::middle_of(grid, start),
            goal: Goal::Reach(Reach::of_cell(grid, goal)),
            required: true,
        }
    }

    /// How it hops, and how far it sees from a height, if it is a hopper.
    #[must_use]
    pub fn as_hopper(&self) -> Option<(&MotionParameters, &SensorParameters)> {
        match (&self.body, &self.sensor) {
            (Body::Hopper(hopper), Sensor::Disc(sensor)) => Some((&hopper.motion, sensor)),
            _ => None,
        }
    }
}

/// The robots of a mission in the order of their numbers, 1 to [`ROBOTS_MAX`]; copies share them.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Robot>", into = "Vec<Robot>")]
pub struct Robots(Arc<[Robot]>);

impl Robots {
    /// These robots; `None` if there is none, or there are too many.
    #[must_use]
    pub fn new(robots: &[Robot]) -> Option<Self> {
        (1..=ROBOTS_MAX).contains(&robots.len()).then(|| Self(robots.into()))
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> u16 {
        self.0.len() as u16
    }

    /// The robot of that number, if the mission has it.
    #[must_use]
    pub fn at(&self, robot: RobotId) -> Option<&Robot> {
        self.get(usize::from(robot.0))
    }

    /// With their numbers.
    pub fn numbered(&self) -> impl DoubleEndedIterator<Item = (RobotId, &Robot)> + Clone {
        (0..self.count()).map(RobotId).zip(self.iter())
    }

    /// Those for which `is_one` holds.
    #[must_use]
    pub fn those(&self, is_one: impl Fn(&Robot) -> bool) -> RobotSet {
        let numbered = self.numbered().filter(|(_, robot)| is_one(robot));
        numbered.fold(RobotSet::NONE, |set, (number, _)| set.with(number))
    }
}

impl Deref for Robots {
    type Target = [Robot];

    fn deref(&self) -> &[Robot] {
        &self.0
    }
}

impl DerefMut for Robots {
    fn deref_mut(&mut self) -> &mut [Robot] {
        Arc::make_mut(&mut self.0)
    }
}

impl fmt::Debug for Robots {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

impl From<Robots> for Vec<Robot> {
    fn from(robots: Robots) -> Self {
        robots.to_vec()
    }
}

impl TryFrom<Vec<Robot>> for Robots {
    type Error = String;

    fn try_from(robots: Vec<Robot>) -> Result<Self, String> {
        Self::new(&robots)
            .ok_or_else(|| format!("a mission has 1 to {ROBOTS_MAX} robots, got {}", robots.len()))
    }
}
