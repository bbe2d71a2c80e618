//! The observed map of a mission, folded again from its records.

use contract::{Brief, Cell, Decision, ObservedMap, Pose, Record, RobotId, Sensor};
use perception::Observation;
use scenario::ResolvedScenario;

/// The map as perception had it after the records so far.
pub struct Sensed<'a> {
    world: &'a ResolvedScenario,
    brief: &'a Brief,
    observation: Observation,
}

impl<'a> Sensed<'a> {
    /// What is seen before the first decision.
    #[must_use]
    pub fn new(world: &'a ResolvedScenario, brief: &'a Brief) -> Self {
        let mut sensed = Self { world, brief, observation: Observation::unseen(brief, RobotId(0)) };
        match &world.fleet {
            Some(fleet) => {
                let starts: Vec<(Sensor, Cell)> =
                    fleet.robots.iter().map(|robot| (robot.sensor, robot.start.cell)).collect();
                sensed.observation.enter(&world.terrain, &starts, Decision(0));
            }
            None => {
                let height_m = world.terrain.ground(brief.start).map_or(0.0, |ground| ground.height_m);
                let pose = Pose { cell: brief.start, height_m };
                sensed.observation.fold(brief, &world.terrain, pose, Decision(0));
            }
        }
        sensed
    }

    /// Folds in what is seen after the decision of `record`, the next one.
    pub fn record(&mut self, record: &Record) {
        let decision = record.decision.next();
        let Some(fleet) = &self.world.fleet else {
            self.observation.fold(self.brief, &self.world.terrain, record.pose, decision);
            return;
        };
        let has_moved = record.outcome.from != record.outcome.to;
        let moved = fleet.robots.get(usize::from(record.robot.0)).filter(|_| has_moved);
        let moved: Vec<(Sensor, Cell)> = moved.iter().map(|robot| (robot.sensor, record.pose.cell)).collect();
        self.observation.enter(&self.world.terrain, &moved, decision);
    }

    /// The map so far.
    #[must_use]
    pub fn map(&self) -> &ObservedMap {
        self.observation.map()
    }
}
