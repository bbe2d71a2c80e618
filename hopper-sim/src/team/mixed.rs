//! Robots of any kind, each with a start and a task of its own.
//!
//! Each robot acts as in the missions of its kind: a hopper as one that has helicopters ([`super::hop`]), a rover with a goal
//! and its helicopters as on uncertain ground ([`super::scout`]), rovers without a goal as where ground is covered
//! ([`super::cover`]). Robots on the ground never share a cell. A step, a hop, or a drive that aims at an occupied one is
//! refused by name; a hop that would stray onto one ends where it began, so that all landings are whole hops apart. The end of a
//! drive on which a rover gets stuck is exempt, since nobody chose it. Rovers that cover ground keep off the goals of hoppers.
//! Any robot may wait until another has acted, which counts as no step.
//!
//! A robot is done once its task is: a hopper on its goal, a rover within reach of its own, all rovers that cover ground once
//! it is covered. Then it stays where it is. The mission reaches its goal once all robots are done that the scenario requires,
//! and fails as soon as one of those cannot be any more: it is lost, has given up or used up its actions, or is a hopper on whose
//! goal another robot has stopped for good. Others that
//! fail end their own part only. All steps are counted as actions of a robot.

use contract::{
    Action, Branch, Brief, Cell, Collected, Decision, Flight, Leader, Outcome, Pose, Record, Refusal,
    RobotId, RobotSet, Sensor, Standing, State, Status, Vehicle,
};
use terrain::Terrain;

use super::cover::CoverTeam;
use super::hop::{HopTeam, take_hop};
use super::roster::{Roster, Turn};
use super::scout::ScoutTeam;
use super::travels::Travels;
use crate::Mission;
use crate::dynamics::{Execution, outcome_of_hop};

/// All robots of a mission, by what they do.
#[derive(Clone, Debug)]
pub struct MixedTeam {
    brief: Brief,
    required: RobotSet,
    ways: Ways,
    /// The team of rovers that cover ground, if there are any.
    cover: Option<CoverTeam>,
}

/// The robots that go from point to point.
#[derive(Clone, Debug)]
enum Ways {
    /// Rovers on ground of uncertain speed, with their helicopters.
    Uncertain(Box<ScoutTeam>),
    /// Helicopters alone, on any ground.
    Flights(HopTeam),
}

/// How the task of a robot stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Open,
    Done,
    Failed(Status),
}

impl MixedTeam {
    /// Before the first action; who has nothing to do is done.
    ///
    /// # Panics
    /// If brief, terrain and robots are not of one scenario.
    #[must_use]
    pub fn new(roster: &mut Roster, brief: &Brief, terrain: &Terrain) -> Self {
        let ways = match brief.scout {
            Some(_) => Ways::Uncertain(Box::new(ScoutTeam::new(roster, brief, terrain))),
            None => Ways::Flights(HopTeam::new(roster, brief)),
        };
        let required = brief.mixed.map_or(RobotSet::ALL, |mixed| mixed.required);
        let cover = brief.cover.map(|_| CoverTeam::new(roster, brief, terrain));
        let mut team = Self { brief: *brief, required, ways, cover };
        for robot in (0..roster.count()).map(RobotId) {
            team.look_around(roster, terrain, robot);
            team.end_if_over(roster, terrain, robot);
        }
        team
    }

    /// How far robots are that go from point to point.
    #[must_use]
    pub fn travels(&self) -> &Travels {
        match &self.ways {
            Ways::Uncertain(scout) => scout.travels(),
            Ways::Flights(flights) => flights.travels(),
        }
    }

    /// The routes of the mission, to add some.
    pub fn travels_mut(&mut self) -> &mut Travels {
        match &mut self.ways {
            Ways::Uncertain(scout) => scout.travels_mut(),
            Ways::Flights(flights) => flights.travels_mut(),
        }
    }

    /// Distinct cells that rovers have covered.
    #[must_use]
    pub fn visited_cells(&self) -> u64 {
        self.cover.as_ref().map_or(0, CoverTeam::visited_cells)
    }

    /// How the mission stands.
    #[must_use]
    pub fn status(&self, roster: &Roster) -> Status {
        let mut is_open = false;
        for robot in self.required.of(roster.count()).iter() {
            match self.part(roster, robot) {
                Part::Done => {}
                Part::Open => is_open = true,
                Part::Failed(status) => return status,
            }
        }
        match roster.due() {
            _ if !is_open => Status::Goal,
            Some(robot) if !(self.required.has(robot) && roster.is_spent(robot)) => Status::Underway,
            _ => Status::Deadlock,
        }
    }

    /// How the task of `robot` stands.
    fn part(&self, roster: &Roster, robot: RobotId) -> Part {
        let entry = roster.entry(robot);
        let is_on_map = self.brief.grid.contains(entry.at.cell);
        match (entry.robot.vehicle, entry.standing, &self.cover) {
            (Vehicle::Rover { .. }, _, Some(cover)) if cover.is_covered() => Part::Done,
            (Vehicle::Rover { .. }, _, Some(cover)) if cover.is_at_work(roster) => Part::Open,
            (Vehicle::HopperTo { .. }, Standing::Stranded, _) if !is_on_map => Part::Failed(Status::LeftMap),
            (Vehicle::HopperTo { goal }, Standing::Active, _) if is_taken(roster, robot, goal) => {
                Part::Failed(Status::Deadlock)
            }
            (Vehicle::Rover { .. }, ..) | (_, Standing::Stranded, _) => Part::Failed(Status::Lost),
            (_, Standing::Active, _) => Part::Open,
            (_, Standing::GaveUp, _) => Part::Failed(Status::Deadlock),
            (_, Standing::Done, _) => Part::Done,
        }
    }

    fn has_arrived(&self, robot: RobotId, vehicle: Vehicle) -> bool {
        matches!(&self.ways, Ways::Uncertain(scout) if scout.has_arrived(robot, vehicle))
    }

    /// Why `robot`, which is due, shall not execute `action`, if there is a reason. Whether a hop is too dangerous is for the
    /// guard to say.
    #[must_use]
    pub fn refusal(
        &self,
        roster: &Roster,
        terrain: &Terrain,
        robot: RobotId,
        action: Action,
    ) -> Option<Refusal> {
        let entry = roster.entry(robot);
        if action == Action::Wait {
            // Any robot of such a mission may.
            return None;
        }
        match (entry.robot.vehicle, &self.ways, &self.cover) {
            (Vehicle::Rover { .. }, _, Some(cover)) => cover.refusal(roster, terrain, robot, action),
            (Vehicle::Driver { .. } | Vehicle::Helicopter { .. }, Ways::Uncertain(scout), _) => {
                scout.refusal(roster, robot, action)
            }
            (Vehicle::Helicopter { .. }, Ways::Flights(flights), _) => flights.refusal(roster, robot, action),
            _ => {
                let Action::Hop(direction) = action else { return None };
                let cell = self.brief.grid.hop(entry.at.cell, direction);
                self.occupant(roster, robot, cell).map(|robot| Refusal::Occupied { action, cell, robot })
            }
        }
    }

    /// Executes `action`, which was not refused, at the decision of `state` of `robot`, which is due, and takes note of it.
    pub fn execute(
        &mut self,
        roster: &mut Roster,
        mission: &Mission,
        state: &State,
        robot: RobotId,
        leader: Leader,
        action: Action,
    ) -> Execution {
        let (terrain, decision): (&Terrain, Decision) = (&mission.terrain, state.decision);
        let mut collected = state.collected;
        let outcome = match (roster.entry(robot).robot.vehicle, &mut self.ways, &mut self.cover) {
            (Vehicle::Rover { .. } | Vehicle::HopperTo { .. }, ..) if waits(roster, robot, action) => {
                let from = roster.entry(robot).at.cell;
                roster.act(robot, decision, leader, Turn::Waits);
                Outcome { branch: Branch::Held, from, to: from, flight: Flight::default() }
            }
            (Vehicle::Rover { .. }, _, Some(cover)) => {
                cover.execute(roster, terrain, robot, decision, leader, action).outcome
            }
            (Vehicle::Driver { .. } | Vehicle::Helicopter { .. }, Ways::Uncertain(scout), _) => {
                scout.execute(roster, terrain, robot, decision, leader, action).outcome
            }
            (Vehicle::Helicopter { .. }, Ways::Flights(flights), _) => {
                flights.execute_flight(roster, (robot, decision, leader), action)
            }
            _ => {
                let outcome = self.hop(roster, mission, robot, decision, action);
                take_hop(roster, (robot, decision, leader), &outcome);
                collected = collected.landing(&terrain.treasures, outcome.to);
                outcome
            }
        };
        self.look_around(roster, terrain, robot);
        self.end_if_over(roster, terrain, robot);
        self.execution(roster, terrain, outcome, collected)
    }

    fn execution(
        &self,
        roster: &Roster,
        terrain: &Terrain,
        outcome: Outcome,
        collected: Collected,
    ) -> Execution {
        let ground = |cell| terrain.ground(cell);
        let height_m =
            ground(outcome.to).or_else(|| ground(outcome.from)).map_or(0.0, |ground| ground.height_m);
        Execution {
            outcome,
            pose: Pose { cell: outcome.to, height_m },
            collected,
            steps: roster.steps_without_waits(),
            visits: self.visited_cells(),
            status: self.status(roster),
        }
    }

    /// What becomes of a hop among other robots.
    fn hop(
        &self,
        roster: &Roster,
        mission: &Mission,
        robot: RobotId,
        decision: Decision,
        action: Action,
    ) -> Outcome {
        let from = roster.entry(robot).at.cell;
        if roster.fails_now(robot) {
            return Outcome { branch: Branch::Stranded, from, to: from, flight: Flight::default() };
        }
        let outcome = outcome_of_hop(mission, robot, decision, from, action);
        match self.occupant(roster, robot, outcome.to) {
            Some(_) => Outcome { to: from, ..outcome },
            None => outcome,
        }
    }

    /// Another robot that takes up `cell` of the map.
    fn occupant(&self, roster: &Roster, robot: RobotId, cell: Cell) -> Option<RobotId> {
        if self.brief.grid.contains(cell) { roster.other_on_ground(robot, cell) } else { None }
    }

    /// Takes note of a decision of an earlier life, whose route, if it announced one, is recalled already.
    ///
    /// # Panics
    /// If another robot was due.
    pub fn recall(&mut self, roster: &mut Roster, terrain: &Terrain, record: &Record) {
        let Record { robot, decision, leader, action, ref outcome, .. } = *record;
        match (roster.entry(robot).robot.vehicle, &mut self.ways, &mut self.cover) {
            (Vehicle::Rover { .. } | Vehicle::HopperTo { .. }, ..) if waits(roster, robot, action) => {
                roster.act(robot, decision, leader, Turn::Waits);
            }
            (Vehicle::Rover { .. }, _, Some(cover)) => cover.recall(roster, terrain, record),
            (Vehicle::Driver { .. } | Vehicle::Helicopter { .. }, Ways::Uncertain(scout), _) => {
                scout.recall(roster, record);
            }
            (Vehicle::Helicopter { .. }, Ways::Flights(flights), _) => flights.recall_flight(roster, record),
            _ => take_hop(roster, (robot, decision, leader), outcome),
        }
        self.look_around(roster, terrain, robot);
        self.end_if_over(roster, terrain, robot);
    }

    /// What a robot sees that goes from cell to cell planners of drives know by the map, and so the guard of drives knows it.
    fn look_around(&mut self, roster: &Roster, terrain: &Terrain, robot: RobotId) {
        let (Ways::Uncertain(scout), entry) = (&mut self.ways, roster.entry(robot)) else { return };
        let (grid, at) = (self.brief.grid, entry.at.cell);
        let (is_disc, reach_cells) = match (entry.robot.sensor, terrain.ground(at)) {
            (Sensor::Disc, Some(ground)) => {
                (true, self.brief.sensor_of(robot).reach_cells(&grid, ground.height_m))
            }
            (Sensor::Square { range_cells }, Some(_)) => (false, f64::from(range_cells)),
            _ => return,
        };
        let clip = |at: i32, side: u32| {
            let reach = reach_cells as i32;
            at.saturating_sub(reach).max(0)..=at.saturating_add(reach).min(side as i32 - 1)
        };
        let columns = clip(at.x, grid.width);
        let cells = clip(at.y, grid.height).flat_map(|y| columns.clone().map(move |x| Cell::new(x, y)));
        let seen = cells.filter(|cell| !is_disc || cell.distance_cells(at) <= reach_cells);
        scout.show(seen.filter_map(|cell| grid.index(cell)));
    }

    /// Whoever is at its goal is done. A robot that the mission does not need gives up once it has used up its actions. A hopper
    /// that has left the map, or landed where none survives, is lost.
    fn end_if_over(&mut self, roster: &mut Roster, terrain: &Terrain, robot: RobotId) {
        let entry = roster.entry(robot);
        let was_active = entry.standing == Standing::Active;
        let survives = terrain.ground(entry.at.cell).is_some_and(|ground| ground.passable);
        let is_over = match entry.robot.vehicle {
            Vehicle::HopperTo { goal } if survives => (entry.at.cell == goal).then_some(Standing::Done),
            Vehicle::HopperTo { .. } => Some(Standing::Stranded),
            vehicle => self.has_arrived(robot, vehicle).then_some(Standing::Done),
        };
        let gives_up = roster.is_spent(robot) && !self.required.has(robot);
        match is_over {
            Some(standing) if was_active => roster.end(robot, standing),
            None if was_active && gives_up => roster.give_up(robot),
            _ => {}
        }
        let entry = roster.entry(robot);
        let closes =
            entry.robot.vehicle.is_on_ground() && !matches!(entry.robot.vehicle, Vehicle::Rover { .. });
        if closes
            && entry.standing != Standing::Active
            && let Some(cover) = &mut self.cover
        {
            cover.close_ways(roster, terrain);
        }
    }

    /// Where the hopper `robot` stands.
    #[must_use]
    pub fn pose(&self, roster: &Roster, terrain: &Terrain, robot: RobotId) -> Pose {
        let cell = roster.entry(robot).at.cell;
        Pose { cell, height_m: terrain.ground(cell).map_or(0.0, |ground| ground.height_m) }
    }
}

/// Whether `robot` waits for others by `action`, and does not fail instead.
fn waits(roster: &Roster, robot: RobotId, action: Action) -> bool {
    action == Action::Wait && !roster.fails_now(robot)
}

/// Whether a robot other than `robot` stands on `cell` for good.
fn is_taken(roster: &Roster, robot: RobotId, cell: Cell) -> bool {
    let mut others = roster.entries().filter(|(other, _)| *other != robot);
    others.any(|(_, entry)| {
        let stops = entry.standing != Standing::Active && entry.robot.vehicle.is_on_ground();
        stops && entry.at.cell == cell
    })
}
