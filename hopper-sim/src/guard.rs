//! Run-time assurance: what stands between any planner and a hop that no hopper should make.
//!
//! The guard depends on no planner, no map and no message, only on what the hopper's own sensor shows from
//! where it stands: the closed disc around its pose, in which every landing of every hop lies, since it
//! reaches at least one hop ([`contract::SensorParameters::reach_cells`]). So it knows less than a planner, never
//! more; two truths that agree on what has been observed get the same vetoes. It is a pure function of brief, disc
//! and action: a hopper-sim that was killed and resumed vetoes the same.
//!
//! # What is vetoed
//! An action's *hazard* is the probability, by the motion law (P23 section IV), of ending off the map or on
//! ground that is seen to be impassable. An action whose hazard exceeds [`contract::Guard::hazard_max`] is
//! vetoed. To stand still is no hazard, and never vetoed.
//!
//! # What is done at the deadline
//! Where [`contract::Guard::deadline_ns`] is given and so long after a state's publication no command has
//! been accepted, the arbiter executes, once for each deadline: the action of the last policy that the
//! algorithm in command has published, if the guard lets it pass; else, greedily, the hop that the guard
//! lets pass whose aim lies nearest to the goal, ties to the first of north, east, south, west; else it
//! holds. A hop is let pass only if no other robot is where it aims.

use contract::{
    Action, Branch, Brief, Cell, Direction, GradientSource, Ground, MotionParameters, Origin, Policy, Pose,
    Robot, RobotId, SensorParameters,
};
use terrain::{Terrain, differences};

/// The guard at one pose.
#[derive(Clone, Copy, Debug)]
pub struct Guard<'a> {
    brief: &'a Brief,
    motion: &'a MotionParameters,
    sensor: &'a SensorParameters,
    terrain: &'a Terrain,
    pose: Pose,
}

/// What the fallback does, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fallback {
    /// What is done in place of a command.
    pub action: Action,
    /// Where it comes from; never [`Origin::Planner`].
    pub origin: Origin,
}

impl<'a> Guard<'a> {
    /// The guard of the hopper `robot` at `pose`. Of `terrain` it reads what the sensor sees from there.
    ///
    /// # Panics
    /// If the robot is no hopper.
    #[must_use]
    pub fn new(brief: &'a Brief, terrain: &'a Terrain, robot: RobotId, pose: Pose) -> Self {
        let hopper = brief.robots.at(robot).and_then(Robot::as_hopper);
        let (motion, sensor) = hopper.expect("the guard of hops is that of a hopper");
        Self { brief, motion, sensor, terrain, pose }
    }

    /// The probability that `action` ends off the map or on ground that is seen to be impassable.
    #[must_use]
    pub fn hazard(&self, action: Action) -> f64 {
        let Action::Hop(direction) = action else { return 0.0 };
        let grid = &self.brief.grid;
        let Some(departure) = self.departure() else { return 0.0 };
        let scatter = motion::transition(self.motion, &departure, direction);
        [Branch::Intended, Branch::Left, Branch::Right]
            .into_iter()
            .filter(|&branch| self.is_hazard(motion::landing(grid, self.pose.cell, direction, branch)))
            .map(|branch| scatter.probability(branch))
            .sum()
    }

    /// The hazard of `action`, if it is more than the guard lets pass.
    #[must_use]
    pub fn veto(&self, action: Action) -> Option<f64> {
        Some(self.hazard(action)).filter(|&hazard| hazard > self.brief.guard.hazard_max)
    }

    /// What to do on the way to `goal` if nobody has said anything acceptable for too long; `may` tells of an action whether
    /// other robots let it pass.
    #[must_use]
    pub fn fallback(&self, goal: Cell, policy: Option<&Policy>, may: impl Fn(Action) -> bool) -> Fallback {
        let may = |action| self.veto(action).is_none() && may(action);
        let index = self.brief.grid.index(self.pose.cell);
        let advised = policy.zip(index).and_then(|(policy, index)| policy.cells.get(index));
        // A policy holds where it knows nothing, so holding is no advice.
        let advised = advised.map(|cell| cell.action).filter(|action| *action != Action::Hold);
        if let Some(action) = advised.filter(|&action| may(action)) {
            return Fallback { action, origin: Origin::Policy };
        }
        match self.greedy(goal, may) {
            Some(direction) => Fallback { action: Action::Hop(direction), origin: Origin::Greedy },
            None => Fallback { action: Action::Hold, origin: Origin::Hold },
        }
    }

    /// The hop that is let pass whose aim lies nearest to the goal.
    fn greedy(&self, goal: Cell, may: impl Fn(Action) -> bool) -> Option<Direction> {
        let aim = |direction| self.brief.grid.hop(self.pose.cell, direction);
        let to_goal_cells = |direction: &Direction| aim(*direction).distance_cells(goal);
        Direction::ALL
            .into_iter()
            .filter(|&direction| may(Action::Hop(direction)) && !self.is_hazard(aim(direction)))
            .min_by(|a, b| to_goal_cells(a).total_cmp(&to_goal_cells(b)))
    }

    /// Whether a landing on `cell` ends the mission, as far as can be seen from here.
    fn is_hazard(&self, cell: Cell) -> bool {
        !self.brief.grid.contains(cell) || self.seen(cell).is_some_and(|ground| !ground.passable)
    }

    /// The ground of `cell`, if the sensor sees it from here.
    fn seen(&self, cell: Cell) -> Option<&'a Ground> {
        let reach_cells = self.sensor.reach_cells(&self.brief.grid, self.pose.height_m);
        if cell.distance_cells(self.pose.cell) <= reach_cells { self.terrain.ground(cell) } else { None }
    }

    /// The ground under the hopper as the observed map has it: its neighbours are seen, so the gradient is
    /// the map's whatever else has been seen before.
    fn departure(&self) -> Option<Ground> {
        let grid = &self.brief.grid;
        let here = *self.seen(self.pose.cell)?;
        let height_m = |cell| self.seen(cell).map(|ground| ground.height_m);
        let gradient = match self.sensor.gradient {
            GradientSource::Measured => here.gradient,
            GradientSource::SeenDifferences => differences(self.pose.cell, grid.cell_size_m, height_m),
        };
        Some(Ground { gradient, ..here })
    }
}
