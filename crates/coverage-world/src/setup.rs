//! What a coverage mission is given besides its world.

use coverage::{Algorithm, CoverMode, Placement, Situation};
use serde::{Deserialize, Serialize};

use crate::error::SetupError;
use crate::{Sensing, World};

/// A rover that fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// Number of the rover.
    pub robot: usize,
    /// Number of its action, from 1, that it no longer carries out. From then on it stands still.
    pub action: u64,
}

/// Who covers how much, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Planner of all rovers.
    pub algorithm: Algorithm,
    /// How the rovers share the ground.
    pub mode: CoverMode,
    /// Cells that a rover sees around it.
    pub sensing: Sensing,
    /// Their starts, in the order of their numbers.
    pub starts: Vec<Placement>,
    /// Share to cover of the cells that can be reached, 1 to 100 %.
    pub percent: u32,
    /// Which rovers fail, and when.
    pub faults: Vec<Fault>,
    /// The mission ends uncovered once every rover has acted so many times.
    pub steps_max: u64,
}

impl Setup {
    /// A setup for `starts` with one-step sensing, no fault, and a step limit that no planner here meets: 1,000 for
    /// each cell of `world`.
    #[must_use]
    pub fn new(
        world: &World,
        algorithm: Algorithm,
        mode: CoverMode,
        starts: Vec<Placement>,
        percent: u32,
    ) -> Self {
        let steps_max = 1000 * world.grid().cells() as u64;
        Self { algorithm, mode, sensing: Sensing::default(), starts, percent, faults: Vec::new(), steps_max }
    }

    /// Checks everything that could not be executed on `world`.
    pub(crate) fn check(&self, world: &World) -> Result<(), SetupError> {
        let rovers = self.starts.len();
        if !(1..=Situation::ROVERS_MAX).contains(&rovers) {
            return Err(SetupError::Rovers { got: rovers });
        }
        for (robot, start) in self.starts.iter().enumerate() {
            let cell = start.cell;
            if !world.is_free(cell) {
                return Err(SetupError::StartNotFree { robot, cell });
            }
            if let Some(other) = self.starts[..robot].iter().position(|other| other.cell == cell) {
                return Err(SetupError::StartShared { robots: [other, robot], cell });
            }
        }
        if !(1..=100).contains(&self.percent) {
            return Err(SetupError::Percent { got: self.percent });
        }
        match self.faults.iter().find(|fault| fault.robot >= rovers || fault.action == 0) {
            Some(&Fault { robot, action }) => Err(SetupError::Fault { robot_max: rovers - 1, robot, action }),
            None => Ok(()),
        }
    }
}
