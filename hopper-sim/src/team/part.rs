//! How the goal of each robot stands, and with it the mission.
//!
//! A robot is done once its goal is reached, as `goal` says. Then it stays where it is. The mission reaches its goal once all robots are done that it
//! requires, and fails as soon as one of those cannot be any more: it is lost, has given up or used up its actions, or is a
//! hopper on whose goal another robot has stopped for good. Others that fail end their own part only. Helicopters look ahead
//! for others: they have nothing to reach, and no mission requires them.

use contract::{Account, Cell, RobotId, RobotSet, Standing, Status};
use terrain::Terrain;

use super::RobotTeam;
use super::coverage::{Coverage, closes_way};
use super::goal::{self, Part};

impl RobotTeam {
    /// How the mission stands, with the steps of its state.
    pub(super) fn status(&self, steps: u64) -> Status {
        let roster = &self.roster;
        let mut is_open = false;
        for robot in self.required().iter() {
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
        match self.brief.account {
            Account::Hopper => self.brief.visits().is_none() && steps >= self.brief.limits.steps_max,
            Account::Actions | Account::ActionsWithoutWaits => {
                roster.due().is_some_and(|robot| self.is_required(robot) && roster.is_spent(robot))
            }
        }
    }

    /// How the goal of `robot` stands.
    fn part(&self, robot: RobotId) -> Part {
        let entry = self.roster.entry(robot);
        if let Some(part) = goal::of(&entry.robot.goal).common_part(self) {
            return part;
        }
        match entry.standing {
            Standing::Done => Part::Done,
            Standing::GaveUp => Part::Failed(Status::Deadlock),
            Standing::Stranded if entry.robot.body.hops() && !self.brief.grid.contains(entry.at.cell) => {
                Part::Failed(Status::LeftMap)
            }
            Standing::Stranded => Part::Failed(Status::Lost),
            Standing::Active => match entry.robot.goal.cell(&self.brief.grid, 0) {
                // Where the steps of the hopper count, no other robot is on the ground.
                Some(goal) if entry.robot.body.hops() && self.is_taken(robot, goal) => {
                    Part::Failed(Status::Deadlock)
                }
                _ => Part::Open,
            },
        }
    }

    /// The robots whose goals decide the mission.
    fn required(&self) -> RobotSet {
        self.brief.robots.those(|robot| robot.required)
    }

    fn is_required(&self, robot: RobotId) -> bool {
        self.roster.entry(robot).robot.required
    }

    /// Whether a robot other than `robot` stands on `cell` for good.
    fn is_taken(&self, robot: RobotId, cell: Cell) -> bool {
        let mut others = self.roster.entries().filter(|(other, _)| *other != robot);
        others.any(|(_, entry)| {
            let stops = entry.standing != Standing::Active && entry.robot.body.is_on_ground();
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
                let is_limited = self.brief.account != Account::Hopper && !self.is_required(robot);
                let gives_up = is_limited && self.roster.is_spent(robot);
                if gives_up {
                    self.roster.give_up(robot);
                }
            }
        }
        if let Some(coverage) = &mut self.coverage
            && closes_way(self.roster.entry(robot))
        {
            coverage.close_ways(&mut self.roster, terrain);
        }
    }

    /// With which standing the part of `robot`, which is active, ends where it is, if it does.
    fn end_of(&self, terrain: &Terrain, robot: RobotId, steps: u64) -> Option<Standing> {
        let entry = self.roster.entry(robot);
        if entry.robot.body.hops() && !terrain.ground(entry.at.cell).is_some_and(|ground| ground.passable) {
            return Some(Standing::Stranded);
        }
        let is_reached = goal::of(&entry.robot.goal).is_reached(self, terrain, robot, steps);
        is_reached.then_some(Standing::Done)
    }

    /// Distinct cells that rovers have covered.
    pub(super) fn visited_cells(&self) -> u64 {
        self.coverage.as_ref().map_or(0, Coverage::visited_cells)
    }
}
