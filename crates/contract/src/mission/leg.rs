//! What a plan for one hopper may depend on beside map and state.

use serde::{Deserialize, Serialize};

use super::brief::{Guard, Limits, Payoff, Priors, Weights};
use super::reading::Reading;
use crate::{Brief, Cell, Grid, Ground, MotionParameters, Profile, RobotId, RunId, SensorParameters};

/// One hopper's way from a start to a goal, with everything else that a plan for it may depend on beside map and state. For a
/// hopper that is alone it is the whole mission, for one that visits several goals the stretch between two of them, and among
/// several robots one robot's part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Leg {
    /// The run it belongs to.
    pub run: RunId,
    /// Reading of the model.
    pub profile: Profile,
    /// Lattice of the mission.
    pub grid: Grid,
    /// Where it begins: the start of the mission, or the goal visited last.
    pub start: Cell,
    /// Where it ends.
    pub goal: Cell,
    /// How safety, information and distance are weighed.
    pub weights: Weights,
    /// What a period, the goal and a treasure are worth.
    pub payoff: Payoff,
    /// What an orbiter has measured of the whole map beforehand.
    pub priors: Priors,
    /// How far a hop goes, and how it slips and drifts by soil.
    pub motion: MotionParameters,
    /// How far the hopper sees from a height.
    pub sensor: SensorParameters,
    /// Steps of the mission, and time for a decision.
    pub limits: Limits,
    /// The guard in hopper-sim.
    pub guard: Guard,
    /// How the paper's open points are read.
    pub reading: Reading,
    /// Whether other robots are on the ground, whose cells the hopper must not enter.
    pub is_shared: bool,
}

impl Brief {
    /// The leg that `robot` flies after so many visits; `None` unless it is a hopper that goes to cells.
    #[must_use]
    pub fn leg_of(&self, robot: RobotId, visits: u64) -> Option<Leg> {
        let goal = self.robots.at(robot)?.goal.cell(&self.grid, visits)?;
        self.leg_to(goal, robot, visits)
    }

    /// As [`Brief::leg_of`], by what has been seen of each cell, in index order: of goals, too, that are known only then.
    #[must_use]
    pub fn leg_on(&self, seen: &[Option<Ground>], robot: RobotId, visits: u64) -> Option<Leg> {
        let hopper = self.robots.at(robot)?;
        let goal = hopper.goal.cell_by(&self.grid, seen, hopper.start.cell, visits)?;
        self.leg_to(goal, robot, visits)
    }

    fn leg_to(&self, goal: Cell, robot: RobotId, visits: u64) -> Option<Leg> {
        let hopper = self.robots.at(robot)?;
        let (motion, sensor) = hopper.as_hopper()?;
        let start = match visits.checked_sub(1) {
            Some(last) if matches!(hopper.goal, crate::Goal::Visit(_)) => {
                hopper.goal.cell(&self.grid, last)?
            }
            _ => hopper.start.cell,
        };
        let mut others = self.robots.numbered().filter(|(other, _)| *other != robot);
        Some(Leg {
            run: self.run,
            profile: self.profile,
            grid: self.grid,
            start,
            goal,
            weights: self.weights,
            payoff: self.payoff,
            priors: self.priors,
            motion: *motion,
            sensor: *sensor,
            limits: self.limits,
            guard: self.guard,
            reading: self.reading,
            is_shared: others.any(|(_, other)| other.body.is_on_ground()),
        })
    }

    /// The leg of the hopper that is robot 0, after so many visits: of a mission that is a hopper's.
    ///
    /// # Panics
    /// If robot 0 is no hopper that goes to cells.
    #[must_use]
    pub fn leg(&self, visits: u64) -> Leg {
        self.leg_of(RobotId(0), visits).expect("robot 0 is a hopper that goes to cells")
    }
}
