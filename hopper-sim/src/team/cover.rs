//! Rovers that cover ground, from cell to cell.
//!
//! A rover's step ends where it was meant to, whatever the ground, since the guard has refused all others: a rover drives
//! to a free neighbouring cell that no other robot stands on. What a step takes is its way divided by the rover's speed;
//! to hold takes a second. A robot may fail at an action of its own that the scenario names: it stays where it is for good
//! and still occupies its cell.

use contract::{
    Action, Branch, Brief, Cell, Collected, Cover, CoverMode, Decision, Direction, Flight, Leader, Outcome,
    Placement, Pose, Record, Refusal, RobotId, Standing, Status, Vehicle,
};
use coverage_world::Progress;
use terrain::Terrain;

use super::roster::{Entry, Roster, Turn};
use super::turn_order::duration_ns;
use crate::dynamics::Execution;

/// What rovers have covered so far.
#[derive(Clone, Debug)]
pub struct CoverTeam {
    progress: Progress,
    /// The robots that cover ground, in the order of their numbers, by which `progress` knows them.
    rovers: Vec<RobotId>,
    /// Where hoppers go, whom no rover shall be in the way: closed to rovers, and no ground to cover.
    goals: Vec<Cell>,
}

impl CoverTeam {
    /// Before the first action: the starts are visited, and who has nothing else to cover is done.
    ///
    /// # Panics
    /// If a robot starts off the grid; scenarios are checked.
    #[must_use]
    pub fn new(roster: &mut Roster, brief: &Brief, terrain: &Terrain) -> Self {
        let covers = |entry: &Entry| matches!(entry.robot.vehicle, Vehicle::Rover { .. });
        let (rovers, starts): (Vec<RobotId>, Vec<Cell>) = roster
            .entries()
            .filter(|(_, entry)| covers(entry))
            .map(|(robot, entry)| (robot, entry.at.cell))
            .unzip();
        let Cover { percent, mode } = brief.cover.unwrap_or(Cover { percent: 100, mode: CoverMode::Overlap });
        let goals: Vec<Cell> =
            roster.entries().filter_map(|(_, entry)| entry.robot.vehicle.hop_goal()).collect();
        let is_open = |cell| is_free(terrain, cell) && !goals.contains(&cell);
        let mut progress = Progress::new(brief.grid, is_open, &starts, mode, percent);
        for (robot, start) in starts.iter().enumerate() {
            progress.visit(robot, *start);
        }
        let team = Self { progress, rovers, goals };
        team.end_those_done(roster);
        team
    }

    /// Distinct cells that at least one rover stood on.
    #[must_use]
    pub fn visited_cells(&self) -> u64 {
        self.progress.visited_cells() as u64
    }

    /// Whether all ground is covered that was asked for.
    #[must_use]
    pub fn is_covered(&self) -> bool {
        self.progress.is_covered()
    }

    /// Whether a rover is left that can cover what is not covered yet.
    #[must_use]
    pub fn is_at_work(&self, roster: &Roster) -> bool {
        self.rovers.iter().any(|robot| roster.entry(*robot).standing == Standing::Active)
    }

    /// How the mission stands: reached once all is covered; lost if nobody can act any more before; a deadlock if the robot
    /// that is due has used up its actions.
    #[must_use]
    pub fn status(&self, roster: &Roster) -> Status {
        match roster.due() {
            _ if self.progress.is_covered() => Status::Goal,
            None => Status::Lost,
            Some(robot) if roster.is_spent(robot) => Status::Deadlock,
            Some(_) => Status::Underway,
        }
    }

    /// Why `robot`, which is due, shall not execute `action`, if there is a reason: the guard of rovers, which asks for
    /// what their sensors show from where they stand, and for where the others are.
    #[must_use]
    pub fn refusal(
        &self,
        roster: &Roster,
        terrain: &Terrain,
        robot: RobotId,
        action: Action,
    ) -> Option<Refusal> {
        let entry = roster.entry(robot);
        match (entry.robot.vehicle, action) {
            (_, Action::Hold) => None,
            (Vehicle::Rover { .. }, Action::Step(direction)) => {
                let to = beside(entry.at.cell, direction);
                let vetoed = Refusal::Vetoed { action, need: 0.0, got: 1.0 };
                match roster.other_on_ground(robot, to) {
                    Some(robot) => Some(Refusal::Occupied { action, cell: to, robot }),
                    None => (!is_free(terrain, to) || self.goals.contains(&to)).then_some(vetoed),
                }
            }
            _ => Some(Refusal::malformed("command.action", "a step or hold: the robot is a rover", action)),
        }
    }

    /// Executes `action`, which was not refused, at `decision` of `robot`, which is due, and takes note of it.
    pub fn execute(
        &mut self,
        roster: &mut Roster,
        terrain: &Terrain,
        robot: RobotId,
        decision: Decision,
        leader: Leader,
        action: Action,
    ) -> Execution {
        let outcome = outcome(roster, terrain, robot, action);
        self.take(roster, terrain, robot, decision, leader, action, &outcome);
        let height_m = terrain.ground(outcome.to).map_or(0.0, |ground| ground.height_m);
        Execution {
            outcome,
            pose: Pose { cell: outcome.to, height_m },
            collected: Collected::default(),
            steps: roster.steps(),
            visits: self.visited_cells(),
            status: self.status(roster),
        }
    }

    /// Takes note of a decision of an earlier life.
    ///
    /// # Panics
    /// If another robot was due.
    pub fn recall(&mut self, roster: &mut Roster, terrain: &Terrain, record: &Record) {
        let Record { robot, decision, leader, action, outcome, .. } = record;
        self.take(roster, terrain, *robot, *decision, *leader, *action, outcome);
    }

    #[allow(clippy::too_many_arguments, reason = "the parts of a record, which may not exist yet")]
    fn take(
        &mut self,
        roster: &mut Roster,
        terrain: &Terrain,
        robot: RobotId,
        decision: Decision,
        leader: Leader,
        action: Action,
        outcome: &Outcome,
    ) {
        roster.act(robot, decision, leader, Turn::Lasts(duration_ns(outcome.flight.flight_time_s)));
        if outcome.branch == Branch::Stranded {
            roster.end(robot, Standing::Stranded);
            self.close_ways(roster, terrain);
        } else if let (Action::Step(heading), Some(rover)) = (action, self.number(robot)) {
            roster.place(robot, Placement { cell: outcome.to, heading });
            self.progress.visit(rover, outcome.to);
        }
        self.end_those_done(roster);
    }

    /// A robot stays where it is for good: what can no longer be reached does not count any more. Rovers that are done have
    /// covered their own cell, and count as before.
    pub fn close_ways(&mut self, roster: &mut Roster, terrain: &Terrain) {
        let stays = |entry: &Entry| match entry.standing {
            Standing::Active => false,
            Standing::Stranded => entry.robot.vehicle.is_on_ground(),
            Standing::Done | Standing::GaveUp => {
                entry.robot.vehicle.is_on_ground() && !matches!(entry.robot.vehicle, Vehicle::Rover { .. })
            }
        };
        let stopped = roster.entries().filter(|(_, entry)| stays(entry)).map(|(_, entry)| entry.at.cell);
        let closed: Vec<Cell> = stopped.chain(self.goals.iter().copied()).collect();
        let is_open = |cell| is_free(terrain, cell) && !closed.contains(&cell);
        let active = self.rovers.iter().map(|robot| roster.entry(*robot));
        let active = active.filter(|entry| entry.standing == Standing::Active).map(|entry| entry.at.cell);
        self.progress.strand(active, is_open);
        self.end_those_done(roster);
    }

    /// By which number `progress` knows that robot.
    fn number(&self, robot: RobotId) -> Option<usize> {
        self.rovers.binary_search(&robot).ok()
    }

    /// Whoever has nothing left to cover acts no more.
    fn end_those_done(&self, roster: &mut Roster) {
        for (number, robot) in self.rovers.iter().enumerate() {
            let is_active = roster.entry(*robot).standing == Standing::Active;
            if is_active && self.progress.is_done(number) {
                roster.end(*robot, Standing::Done);
            }
        }
    }
}

fn outcome(roster: &Roster, terrain: &Terrain, robot: RobotId, action: Action) -> Outcome {
    let entry = roster.entry(robot);
    let from = entry.at.cell;
    let speed_mps = match entry.robot.vehicle {
        Vehicle::Rover { speed_mps } => speed_mps,
        // No others cover ground.
        _ => 1.0,
    };
    let stays = |branch| {
        let flight = Flight { flight_time_s: 1.0, flights: 1, ..Flight::default() };
        Outcome { branch, from, to: from, flight }
    };
    match action {
        _ if roster.fails_now(robot) => stays(Branch::Stranded),
        Action::Step(direction) => {
            let to = beside(from, direction);
            let height_m = |cell| terrain.ground(cell).map_or(0.0, |ground| ground.height_m);
            let (range_m, rise_m) = (terrain.grid.cell_size_m, height_m(to) - height_m(from));
            let flight_time_s = libm::hypot(range_m, rise_m) / speed_mps;
            let flight = Flight { range_m, rise_m, flight_time_s, flights: 1, ..Flight::default() };
            Outcome { branch: Branch::Intended, from, to, flight }
        }
        _ => stays(Branch::Held),
    }
}

/// Whether a ground robot can stand on `cell`.
fn is_free(terrain: &Terrain, cell: Cell) -> bool {
    terrain.ground(cell).is_some_and(|ground| ground.is_drivable())
}

fn beside(cell: Cell, direction: Direction) -> Cell {
    let (dx, dy) = direction.step();
    Cell::new(cell.x + dx, cell.y + dy)
}
