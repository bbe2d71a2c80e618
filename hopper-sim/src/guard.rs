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
//! A hopper with the vertical hop has one hop towards each direction, or none ([`motion::offers`]), whatever `hazard_max`: a hop at its
//! launch angle whose arc does not clear the ground is vetoed, and so is a vertical hop where that arc is clear, or where the rise is too
//! high. All that the arcs pass lies within a hop, so the sensor shows it.
//!
//! # What is done at the deadline
//! Where [`contract::Guard::deadline_ns`] is given and so long after a state's publication no command has
//! been accepted, the arbiter executes, once for each deadline: the action of the last policy that the
//! algorithm in command has published, if the guard lets it pass; else, greedily, the hop that the guard
//! lets pass whose aim lies nearest to the goal, ties to the first of north, east, south, west; else it
//! holds. A hop is let pass only if no other robot is where it aims.

use contract::{
    Action, Branch, Brief, Cell, Direction, GradientSource, Ground, MotionParameters, Origin, Policy, Pose,
    Refusal, Robot, RobotId, SensorParameters,
};
use motion::Offer;
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
        action.hop().map_or(0.0, |direction| self.hazard_of(action, self.offered(direction)))
    }

    /// [`Guard::hazard`] of a hop, by the one that is offered towards its direction.
    fn hazard_of(&self, action: Action, offered: Option<Offer>) -> f64 {
        let Some(offer) = offered.filter(|offer| offer.action == action) else { return 0.0 };
        let Some(direction) = action.hop() else { return 0.0 };
        let scatter = offer.scatter();
        [Branch::Intended, Branch::Left, Branch::Right]
            .into_iter()
            .filter(|&branch| {
                self.is_hazard(motion::landing(&self.brief.grid, self.pose.cell, direction, branch))
            })
            .map(|branch| scatter.probability(branch))
            .sum()
    }

    /// Why the guard does not let `action` pass, if it does not.
    #[must_use]
    pub fn refusal(&self, action: Action) -> Option<Refusal> {
        let offered = self.offered(action.hop()?);
        if let Some(need) = self.blocked(action, offered) {
            return Some(Refusal::Blocked { action, need });
        }
        let need = self.brief.guard.hazard_max;
        let got = self.hazard_of(action, offered);
        (got > need).then_some(Refusal::Vetoed { action, need, got })
    }

    /// What would be needed for a hop to be the one that is offered; `None` if it is.
    fn blocked(&self, action: Action, offered: Option<Offer>) -> Option<String> {
        let departure = self.departure().filter(|_| self.motion.vertical)?;
        match (action, offered) {
            (_, Some(offer)) if offer.action == action => None,
            (Action::Up(_), Some(_)) => Some("something in the way of a hop at the launch angle".into()),
            (Action::Up(_), None) => {
                let launch = motion::vertical_launch(self.motion, &self.brief.grid, departure.soil);
                Some(format!("a rise below its apex of {:.3} m", launch.apex_height_m()))
            }
            _ => Some("an arc that clears the ground".into()),
        }
    }

    /// The hop towards `direction` as far as can be seen from here.
    fn offered(&self, direction: Direction) -> Option<Offer> {
        let departure = self.departure()?;
        let height_m = |cell| self.seen(cell).map(|ground| ground.height_m);
        motion::offers(self.motion, &self.brief.grid, (self.pose.cell, &departure), height_m)
            [direction as usize]
    }

    /// What to do on the way to `goal` if nobody has said anything acceptable for too long; `may` tells of an action whether
    /// other robots let it pass.
    #[must_use]
    pub fn fallback(&self, goal: Cell, policy: Option<&Policy>, may: impl Fn(Action) -> bool) -> Fallback {
        let may = |action| self.refusal(action).is_none() && may(action);
        let index = self.brief.grid.index(self.pose.cell);
        let advised = policy.zip(index).and_then(|(policy, index)| policy.cells.get(index));
        // A policy holds where it knows nothing, so holding is no advice.
        let advised = advised.map(|cell| cell.action).filter(|action| *action != Action::Hold);
        if let Some(action) = advised.filter(|&action| may(action)) {
            return Fallback { action, origin: Origin::Policy };
        }
        match self.greedy(goal, may) {
            Some(action) => Fallback { action, origin: Origin::Greedy },
            None => Fallback { action: Action::Hold, origin: Origin::Hold },
        }
    }

    /// The hop that is let pass whose aim lies nearest to the goal.
    fn greedy(&self, goal: Cell, may: impl Fn(Action) -> bool) -> Option<Action> {
        let aim = |direction| self.brief.grid.hop(self.pose.cell, direction);
        let to_goal_cells = |direction: Direction| aim(direction).distance_cells(goal);
        let action = |direction| match self.offered(direction) {
            Some(offer) => offer.action,
            None => Action::Hop(direction),
        };
        let hops = Direction::ALL.into_iter().map(|direction| (direction, action(direction)));
        let nearest = hops
            .filter(|&(direction, action)| may(action) && !self.is_hazard(aim(direction)))
            .min_by(|(a, _), (b, _)| to_goal_cells(*a).total_cmp(&to_goal_cells(*b)));
        nearest.map(|(_, action)| action)
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
