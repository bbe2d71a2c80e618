//! How the goal of each robot stands, and with it the mission.
//!
//! A robot is done once its goal is reached: a hopper on its cell, a rover within reach of its point, all rovers that cover
//! ground once it is covered. Then it stays where it is. The mission reaches its goal once all robots are done that it
//! requires, and fails as soon as one of those cannot be any more: it is lost, has given up or used up its actions, or is a
//! hopper on whose goal another robot has stopped for good. Others that fail end their own part only. Helicopters look ahead
//! for others: they have nothing to reach, and no mission requires them.

use contract::{Cell, RobotId, Standing, Status, Vehicle};
use terrain::Terrain;

use super::coverage::Coverage;
use super::travels::START_TOLERANCE_M;
use super::{Account, RobotTeam};

/// How the goal of a robot stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Open,
    Done,
    Failed(Status),
}

impl RobotTeam {
    /// How the mission stands, with the steps of its state.
    pub(super) fn status(&self, steps: u64) -> Status {
        let roster = &self.roster;
        let mut is_open = false;
        for robot in self.required.of(roster.count()).iter() {
            match self.part(robot) {
                Part::Done => {}
                Part::Open => is_open = true,
                Part::Failed(status) => return status,
            }
        }
        if !is_open {
            Status::Goal
        } else if roster.due().is_none() || self.is_out_of_steps(steps) {
            Status::Deadlock
        } else {
            Status::Underway
        }
    }

    /// Whether the mission has no more steps.
    fn is_out_of_steps(&self, steps: u64) -> bool {
        let roster = &self.roster;
        match self.account {
            Account::Hopper => self.brief.patrol.is_none() && steps >= self.brief.limits.steps_max,
            Account::Actions | Account::ActionsWithoutWaits => {
                roster.due().is_some_and(|robot| self.required.has(robot) && roster.is_spent(robot))
            }
        }
    }

    /// How the goal of `robot` stands.
    fn part(&self, robot: RobotId) -> Part {
        let roster = &self.roster;
        let entry = roster.entry(robot);
        if let (Vehicle::Rover { .. }, Some(coverage)) = (entry.robot.vehicle, &self.coverage) {
            return if coverage.is_covered() {
                Part::Done
            } else if coverage.is_at_work(roster) {
                Part::Open
            } else {
                Part::Failed(Status::Lost)
            };
        }
        match (entry.standing, entry.robot.vehicle) {
            (Standing::Stranded, vehicle) if vehicle.hops() && !self.brief.grid.contains(entry.at.cell) => {
                Part::Failed(Status::LeftMap)
            }
            (Standing::Active, Vehicle::HopperTo { goal }) if self.is_taken(robot, goal) => {
                Part::Failed(Status::Deadlock)
            }
            (Standing::Stranded, _) => Part::Failed(Status::Lost),
            (Standing::Active, _) => Part::Open,
            (Standing::GaveUp, _) => Part::Failed(Status::Deadlock),
            (Standing::Done, _) => Part::Done,
        }
    }

    /// Whether a robot other than `robot` stands on `cell` for good.
    fn is_taken(&self, robot: RobotId, cell: Cell) -> bool {
        let mut others = self.roster.entries().filter(|(other, _)| *other != robot);
        others.any(|(_, entry)| {
            let stops = entry.standing != Standing::Active && entry.robot.vehicle.is_on_ground();
            stops && entry.at.cell == cell
        })
    }

    /// Ends the part of `robot`, which has acted or begins, if it is at its goal, lost, or has used up its actions in a mission
    /// that does not require it. `steps` are those of the hopper, where the mission counts them.
    pub(super) fn end_if_over(&mut self, terrain: &Terrain, robot: RobotId, steps: u64) {
        let was_active = self.roster.entry(robot).standing == Standing::Active;
        if was_active {
            if let Some(standing) = self.end_of(terrain, robot, steps) {
                self.roster.end(robot, standing);
            } else {
                // Where the steps of the hopper are limited, the actions of the others are not.
                let is_limited = self.account != Account::Hopper && !self.required.has(robot);
                let gives_up = is_limited && self.roster.is_spent(robot);
                if gives_up {
                    self.roster.give_up(robot);
                }
            }
        }
        let entry = self.roster.entry(robot);
        let stays = match (entry.robot.vehicle, entry.standing) {
            (_, Standing::Active) | (Vehicle::Helicopter { .. }, _) => false,
            // Rovers that are done have covered their own cell, and count as before.
            (Vehicle::Rover { .. }, standing) => standing == Standing::Stranded,
            _ => true,
        };
        if let (true, Some(coverage)) = (stays, &mut self.coverage) {
            coverage.close_ways(&mut self.roster, terrain);
        }
    }

    /// With which standing the part of `robot`, which is active, ends where it is, if it does.
    fn end_of(&self, terrain: &Terrain, robot: RobotId, steps: u64) -> Option<Standing> {
        let entry = self.roster.entry(robot);
        match entry.robot.vehicle {
            Vehicle::Hopper | Vehicle::HopperTo { .. } => {
                let survives = terrain.ground(entry.at.cell).is_some_and(|ground| ground.passable);
                if survives {
                    self.is_at_goal(robot, steps).then_some(Standing::Done)
                } else {
                    Some(Standing::Stranded)
                }
            }
            Vehicle::Driver { goal, goal_radius_m, .. } => {
                let travel = self.travels.get(robot)?;
                let is_there = travel.at.distance_m(goal) <= goal_radius_m + START_TOLERANCE_M;
                (is_there && !travel.is_under_way()).then_some(Standing::Done)
            }
            Vehicle::Rover { .. } | Vehicle::Helicopter { .. } => None,
        }
    }

    /// Whether the hopper `robot` has reached its goal; on a patrol, has flown its hops.
    fn is_at_goal(&self, robot: RobotId, steps: u64) -> bool {
        let entry = self.roster.entry(robot);
        match (entry.robot.vehicle, &self.brief.patrol) {
            (Vehicle::HopperTo { goal }, _) => entry.at.cell == goal,
            (_, Some(patrol)) => self.roster.actions(robot) >= patrol.hops_max,
            (_, None) => entry.at.cell == self.brief.goal && steps <= self.brief.limits.steps_max,
        }
    }

    /// Distinct cells that rovers have covered.
    pub(super) fn visited_cells(&self) -> u64 {
        self.coverage.as_ref().map_or(0, Coverage::visited_cells)
    }
}
