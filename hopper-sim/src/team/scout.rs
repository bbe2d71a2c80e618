//! Robots that go from point to point: a rover on ground of uncertain speed, and helicopters that look ahead for it.
//!
//! In all stages but the last a rover drives for a Sol at most. The drive that uses it up ends there, on the way
//! ([`Branch::Halted`]), and the next stage begins: the helicopters that still act are with the rover again, have their whole
//! budget, and announce another flight. Their way back takes neither time nor budget, as in the study.
//!
//! A robot announces a route, and then drives or flies to its points one after the other. A drive takes what the true
//! speeds make of it and ends at the border of a cell of speed 0, where the rover is stranded for good; a flight takes its
//! length divided by the helicopter's speed. To announce and to hold take a second; to wait and to be done take no time.
//!
//! The guard asks for the kind of the action, the length of the route, the flight budget, and the largest probability of
//! getting stuck along a drive as far as anybody can know it: by the prior, or by what the sensors have shown of a cell.

use std::ops::ControlFlow;

use contract::{
    Action, Branch, Brief, Cell, Collected, Decision, DriveSpeed, Grid, Leader, Outcome, Pose, Record,
    Refusal, Robot, RobotId, SpeedPrior, Standing, Status, Travel, Vehicle, Waypoint,
};
use helicopter::{Sensor, Sighting};
use rover::{Drive, DriveEnd, Point, SOL_HOURS, Segment, Speed, SpeedDistribution, traverse};
use scout_world::{StageClock, TrueGround};
use terrain::Terrain;

use super::roster::Roster;
use super::travels::{Arrival, START_TOLERANCE_M, Travels};
use crate::dynamics::Execution;

/// How far robots are on their routes, and what their sensors have shown.
#[derive(Clone, Debug)]
pub struct ScoutTeam {
    travels: Travels,
    /// Of each robot, in the order of their numbers; only those of rovers run.
    clocks: Vec<StageClock>,
    grid: Grid,
    ground: TrueGround,
    prior: Vec<SpeedPrior>,
    /// In index order.
    sights: Vec<Sight>,
    /// The camera of those helicopters that err.
    camera: Option<Sensor>,
    /// What it reads of each cell, in index order; nothing where none errs.
    readings: Vec<Option<DriveSpeed>>,
    hazard_max: f64,
}

/// What sensors have shown of a cell's speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sight {
    /// Nothing.
    Unseen,
    /// What a camera that errs reads.
    Read,
    /// The true one.
    Seen,
}

impl ScoutTeam {
    /// Before the first action: the rover sees where it stands.
    ///
    /// # Panics
    /// If the terrain has no speeds; scenarios are checked.
    #[must_use]
    pub fn new(roster: &Roster, brief: &Brief, terrain: &Terrain) -> Self {
        assert_eq!(terrain.prior.len(), terrain.cells.len(), "uncertain ground has a prior for each cell");
        let travels = Travels::new(roster.entries().map(|(_, entry)| entry.robot.vehicle.start()));
        let ground =
            TrueGround::new(brief.grid, &terrain.cells).expect("a grid is within the limits of a lattice");
        let mut accuracies = roster.entries().filter_map(|(_, entry)| entry.robot.sensor.accuracy());
        let stages = brief.scout.map_or(1, |scout| scout.stages);
        let mut team = Self {
            travels,
            clocks: vec![StageClock::new(stages); usize::from(roster.count())],
            grid: brief.grid,
            ground,
            prior: terrain.prior.clone(),
            sights: vec![Sight::Unseen; brief.grid.cells()],
            camera: accuracies.next().and_then(|accuracy| Sensor::with_accuracy(accuracy).ok()),
            readings: terrain.cells.iter().map(|ground| ground.reading).collect(),
            hazard_max: brief.guard.hazard_max,
        };
        for (_, entry) in roster.entries() {
            if let Vehicle::Driver { start, .. } = entry.robot.vehicle {
                let cells = team.ground.seen(entry.robot.sensor, start, start);
                team.see(&entry.robot, &cells);
            }
        }
        team
    }

    /// How far robots are on their routes.
    #[must_use]
    pub fn travels(&self) -> &Travels {
        &self.travels
    }

    /// The same, to add routes.
    pub fn travels_mut(&mut self) -> &mut Travels {
        &mut self.travels
    }

    /// How far `robot` is on its way.
    ///
    /// # Panics
    /// If it goes from cell to cell; so for all robots named here.
    fn travel(&self, robot: RobotId) -> Travel {
        self.travels.get(robot).expect("a robot that goes from point to point")
    }

    /// Whether a rover stands at its goal and has no further point to go to.
    #[must_use]
    pub fn has_arrived(&self, robot: RobotId, vehicle: Vehicle) -> bool {
        let Vehicle::Driver { goal, goal_radius_m, .. } = vehicle else { return false };
        let travel = self.travel(robot);
        travel.at.distance_m(goal) <= goal_radius_m + START_TOLERANCE_M && !travel.is_under_way()
    }

    /// How the mission stands: reached once the rover stands at the goal and has no further point to go to; lost if it is
    /// stranded; a deadlock if nobody can act, the rover has given up, or the robot that is due has used up its actions.
    #[must_use]
    pub fn status(&self, roster: &Roster) -> Status {
        for (robot, entry) in roster.entries() {
            let Vehicle::Driver { .. } = entry.robot.vehicle else { continue };
            match entry.standing {
                Standing::Stranded => return Status::Lost,
                _ if self.has_arrived(robot, entry.robot.vehicle) => return Status::Goal,
                Standing::Done | Standing::GaveUp => return Status::Deadlock,
                Standing::Active => {}
            }
        }
        match roster.due() {
            Some(robot) if !roster.is_spent(robot) => Status::Underway,
            _ => Status::Deadlock,
        }
    }

    /// Why `robot`, which is due, shall not execute `action`, if there is a reason.
    #[must_use]
    pub fn refusal(&self, roster: &Roster, robot: RobotId, action: Action) -> Option<Refusal> {
        let (vehicle, travel) = (roster.entry(robot).robot.vehicle, self.travel(robot));
        let needs = |need: &str| Some(Refusal::malformed("command.action", need, action));
        match (vehicle, action) {
            (_, Action::Hold | Action::Wait | Action::Done) => None,
            (_, Action::Announce(id)) => {
                let lattice = self.ground.lattice();
                self.travels.refusal_of_route(vehicle, robot, id, |at| lattice.contains(point(at)))
            }
            (Vehicle::Helicopter { .. }, _) => self.travels.refusal_of_flight(vehicle, robot, action),
            (Vehicle::Driver { .. }, Action::Drive) => match self.travels.next(travel) {
                None => needs("an announced route with a point to go to"),
                Some(to) => {
                    let (need, got) = (self.hazard_max, self.hazard(travel.at, to));
                    let cell = self.cell(to);
                    match roster.other_on_ground(robot, cell) {
                        Some(robot) => Some(Refusal::Occupied { action, cell, robot }),
                        None => (got > need).then_some(Refusal::Vetoed { action, need, got }),
                    }
                }
            },
            _ => needs("drive, announce, wait, done or hold: the robot is a rover on uncertain ground"),
        }
    }

    /// The largest probability of getting stuck in a cell between two points, as far as it is known.
    fn hazard(&self, from: Waypoint, to: Waypoint) -> f64 {
        let mut hazard = 0.0_f64;
        let segment = Segment { from: point(from), to: point(to) };
        let _ = traverse(self.ground.lattice(), segment, |cell, _| {
            hazard = hazard.max(self.stuck(cell));
            ControlFlow::<()>::Continue(())
        });
        hazard
    }

    /// The probability of getting stuck in a cell, as far as it is known.
    fn stuck(&self, cell: usize) -> f64 {
        let sighting = match self.sights[cell] {
            Sight::Seen => Sighting { speed: Some(self.ground.speed(cell)), reading: None },
            Sight::Read => Sighting { speed: None, reading: self.readings[cell].map(scout_world::speed) },
            Sight::Unseen => Sighting::default(),
        };
        let prior = SpeedDistribution::as_given(self.prior[cell].probabilities());
        prior.map_or(1.0, |prior| sighting.belief(prior, self.camera.as_ref()).probability(Speed::Zero))
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
        self.travels.keep_announced(robot, action);
        let outcome = self.take(roster, robot, decision, leader, action);
        Execution {
            outcome,
            pose: Pose {
                cell: outcome.to,
                height_m: terrain.ground(outcome.to).map_or(0.0, |ground| ground.height_m),
            },
            collected: Collected::default(),
            steps: roster.steps(),
            visits: 0,
            status: self.status(roster),
        }
    }

    /// Takes note of a decision of an earlier life, whose route, if it announced one, is recalled already.
    ///
    /// # Panics
    /// If another robot was due.
    pub fn recall(&mut self, roster: &mut Roster, record: &Record) {
        self.take(roster, record.robot, record.decision, record.leader, record.action);
    }

    /// What a drive of `robot` to the next point of its route comes to; `None` for any other action, or if it fails.
    fn drive(&self, roster: &Roster, robot: RobotId, action: Action) -> Option<Drive> {
        let travel = self.travel(robot);
        let to = self.travels.next(travel).filter(|_| action == Action::Drive && !roster.fails_now(robot))?;
        Some(self.ground.drive(travel.at, to, self.clocks[usize::from(robot.0)].allowance()))
    }

    /// What `action` of `robot` comes to, which is `drive` if it is one.
    fn arrival(&self, roster: &Roster, robot: RobotId, action: Action, drive: Option<&Drive>) -> Arrival {
        let Some(drive) = drive else {
            let flight = self.travels.flight(roster, robot, action, |at| self.cell(at));
            return flight.expect("a robot that goes from point to point");
        };
        let at = Waypoint { x_m: drive.at.x_m, y_m: drive.at.y_m };
        let branch = match drive.end {
            DriveEnd::Stuck { .. } => Branch::Stranded,
            DriveEnd::Arrived => Branch::Intended,
            DriveEnd::OutOfTime => Branch::Halted,
        };
        let cells = [roster.entry(robot).at.cell, self.cell(at)];
        let seconds = drive.duration_sol * SOL_HOURS * 3600.0;
        Arrival::goes(cells, at, branch, drive.length_m, seconds)
    }

    /// Takes note of an action; what it came to.
    fn take(
        &mut self,
        roster: &mut Roster,
        robot: RobotId,
        decision: Decision,
        leader: Leader,
        action: Action,
    ) -> Outcome {
        let drive = self.drive(roster, robot, action);
        let arrival = self.arrival(roster, robot, action, drive.as_ref());
        let (before, seer) = (self.travel(robot), roster.entry(robot).robot);
        // A robot that fails on the spot has gone nowhere, and shows nothing.
        let has_gone = arrival.outcome.branch != Branch::Stranded || arrival.at != before.at;
        let to = self.travels.next(before).filter(|_| has_gone && action == Action::Fly);
        if let Some(to) = to {
            let cells = self.ground.seen(seer.sensor, before.at, to);
            self.see(&seer, &cells);
        }
        if let Some(drive) = &drive {
            self.clocks[usize::from(robot.0)].drove(drive);
        }
        if let Some(drive) = drive.filter(|_| has_gone) {
            self.see(&seer, &drive.sensed);
        }
        self.travels.settle(roster, (robot, decision, leader), action, &arrival);
        if arrival.outcome.branch == Branch::Halted {
            self.clocks[usize::from(robot.0)].begin_next();
            self.travels.rejoin(roster, robot);
        }
        arrival.outcome
    }

    /// Takes note of cells that a robot which goes from cell to cell has seen.
    pub fn show(&mut self, cells: impl Iterator<Item = usize>) {
        cells.for_each(|cell| self.sights[cell] = Sight::Seen);
    }

    /// Takes note of what a robot sees of these cells.
    fn see(&mut self, robot: &Robot, cells: &[usize]) {
        let errs = robot.sensor.accuracy().is_some();
        for &cell in cells {
            self.sights[cell] = match (errs, self.sights[cell]) {
                (true, Sight::Unseen | Sight::Read) => Sight::Read,
                (false, _) | (true, Sight::Seen) => Sight::Seen,
            };
        }
    }

    fn cell(&self, at: Waypoint) -> Cell {
        self.grid.cell(self.ground.lattice().cell(point(at)))
    }
}

fn point(at: Waypoint) -> Point {
    Point::new(at.x_m, at.y_m)
}
