//! How the goal of each robot stands, and with it the mission.
//!
//! A robot is done once its goal is reached: a hopper on its cell, a rover within reach of its point, all rovers that cover
//! ground once it is covered. Then it stays where it is. The mission reaches its goal once all robots are done that it
//! requires, and fails as soon as one of those cannot be any more: it is lost, has given up or used up its actions, or is a
//! hopper on whose goal another robot has stopped for good. Others that fail end their own part only. Helicopters look ahead
//! for others: they have nothing to reach, and no mission requires them.

use contract::{Account, Cell, Goal, RobotId, RobotSet, Standing, Status};
use terrain::Terrain;

use super::RobotTeam;
use super::coverage::{Coverage, closes_way};
use super::travels::START_TOLERANCE_M;

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
        let roster = &self.roster;
        let entry = roster.entry(robot);
        if let (Goal::Cover(_), Some(coverage)) = (entry.robot.goal, &self.coverage) {
            return if coverage.is_covered() {
                Part::Done
            } else if coverage.is_at_work(roster) {
                Part::Open
            } else {
                Part::Failed(Status::Lost)
            };
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
        self.is_at_goal(robot, steps).then_some(Standing::Done)
    }

    /// Whether `robot`, which is active, has reached its goal or made its visits. [`Coverage`] decides when those that cover ground
    /// are done, and a robot that looks ahead never is.
    fn is_at_goal(&self, robot: RobotId, steps: u64) -> bool {
        let entry = self.roster.entry(robot);
        match (entry.robot.goal, self.travels.get(robot)) {
            (Goal::Reach(reach), Some(travel)) => {
                let is_near = travel.at.distance_m(reach.at) <= reach.radius_m + START_TOLERANCE_M;
                is_near && !travel.is_under_way()
            }
            (Goal::Reach(reach), None) => {
                let in_time = self.brief.account != Account::Hopper || steps <= self.brief.limits.steps_max;
                entry.at.cell == reach.at.cell_of(&self.brief.grid) && in_time
            }
            (Goal::Visit(visit), _) => self.roster.actions(robot) >= visit.hops_max,
            (Goal::Cover(_) | Goal::LookAhead(_), _) => false,
        }
    }

    /// Distinct cells that rovers have covered.
    pub(super) fn visited_cells(&self) -> u64 {
        self.coverage.as_ref().map_or(0, Coverage::visited_cells)
    }
}
