//! What is flown under faults: a scenario, and the planner processes of its robots.

use std::path::Path;

use contract::{Digest, MonotonicNs, Name, RobotId, RobotSet, Status};
use hopper_sim::shell::MissionArgs;
use hopper_sim::{Mission, Pace};
use lockstep::PlannerSchedule;
use node::Failure;
use scenario::ResolvedScenario;
use simulation::setup::Seat;

/// Result of the same mission without faults, flown in lockstep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undisturbed {
    /// Digest of its last decision.
    pub digest: Digest,
    /// Status in which it ended.
    pub outcome: Status,
    /// Number of its decisions.
    pub decisions: u64,
}

/// A mission without its seed, and who plans for which robots.
#[derive(Clone, Debug)]
pub struct World {
    resolved: ResolvedScenario,
    /// The planner of each robot.
    planners: Vec<Name>,
}

impl World {
    /// The world of a scenario whose robots name their planners; `given` is for all whom it suits.
    ///
    /// # Errors
    /// Exit code 2 if a planner does not suit its robot.
    pub fn of(resolved: ResolvedScenario, given: Option<Name>) -> Result<Self, Failure> {
        let planners =
            planner::assigned(&resolved.brief, given, &resolved.planners).map_err(Failure::usage)?;
        Ok(Self { resolved, planners })
    }

    /// The world of a built-in scenario or of a file.
    ///
    /// # Errors
    /// Exit code 2 if it cannot be read or resolved.
    pub fn named(scenario: &str) -> Result<Self, Failure> {
        let (scenario, pace) = (Some(scenario.into()), Pace::Max);
        let mission = MissionArgs {
            scenario,
            seed: None,
            profile: None,
            dynamics: None,
            preset: None,
            table: None,
            budget: None,
            dem: None,
            elevation: Default::default(),
            pace,
        };
        Self::of(mission.scenario()?.resolve().map_err(Failure::usage)?, None)
    }

    /// Whether it is a single hopper's.
    #[must_use]
    pub fn is_alone(&self) -> bool {
        !self.resolved.brief.has_team()
    }

    /// The planner processes: one for each algorithm, with all robots that name it.
    #[must_use]
    pub fn seats(&self) -> Vec<Seat> {
        let mut seats: Vec<Seat> = Vec::new();
        for (robot, planner) in (0..).map(RobotId).zip(&self.planners) {
            match seats.iter_mut().find(|seat| seat.planner == *planner) {
                Some(seat) => seat.robots = seat.robots.with(robot),
                None => seats.push(Seat { planner: *planner, robots: RobotSet(0).with(robot) }),
            }
        }
        seats
    }

    /// Writes the scenario down.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, file: &Path) -> Result<(), Failure> {
        std::fs::write(file, &self.resolved.resolved).map_err(Failure::run)
    }

    /// The mission of `seed` without faults, in lockstep.
    ///
    /// # Errors
    /// If a planner does not suit its robot.
    pub fn fly(&self, seed: u64) -> Result<Undisturbed, Failure> {
        let mission = Mission::of(&self.resolved, seed);
        let schedule = PlannerSchedule::of_robots(&self.planners);
        let flown =
            lockstep::fly(mission, &schedule, &mut || MonotonicNs(0), &mut |_| {}).map_err(Failure::run)?;
        let contract::State { digest, status: outcome, decision, .. } = flown.state;
        Ok(Undisturbed { digest, outcome, decisions: decision.0 })
    }
}
