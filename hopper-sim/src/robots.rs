//! Executes the actions of several robots: where each stands, whose turn it is, and how the mission stands after it.
//!
//! A rover's step ends where it was meant to, whatever the ground, since the guard has refused all others: a rover drives
//! to a free neighbouring cell that no other robot stands on. What a step takes is its way divided by the rover's speed;
//! to hold takes a second. A robot may fail at an action of its own that the scenario names: it stays where it is for good
//! and still occupies its cell.

use contract::{
    Action, Branch, Brief, Cell, Collected, Cover, CoverMode, Decision, Direction, Flight, Leader, Member,
    Outcome, Placement, Pose, Record, Refusal, Robot, RobotId, Standing, State, Status, Team, Vehicle,
};
use coverage_world::Progress;
use scenario::Fleet;
use terrain::Terrain;

use crate::dynamics::Execution;
use crate::turn_order::{Due, TurnOrder, duration_ns};

/// Where the robots of a mission stand.
#[derive(Clone, Debug)]
pub struct Robots {
    order: TurnOrder,
    /// In the order of their numbers.
    robot_states: Vec<RobotState>,
    progress: Progress,
    /// Actions of a robot after which the mission is a deadlock.
    actions_max: u64,
    /// The robot that acted last.
    actor: Option<RobotId>,
}

/// One robot.
#[derive(Clone, Copy, Debug)]
struct RobotState {
    robot: Robot,
    at: Placement,
    standing: Standing,
    leader: Leader,
    last: Option<Decision>,
    actions: u64,
    /// The number of the action, from 1, at which it fails.
    fails_at: Option<u64>,
}

impl Robots {
    /// The robots before their first action: the starts are visited.
    ///
    /// # Panics
    /// If a robot starts off the grid, there is none, or the brief's task is none for them; scenarios are checked.
    #[must_use]
    pub fn new(brief: &Brief, terrain: &Terrain, fleet: &Fleet) -> Self {
        let robot_state = |(number, robot): (u16, &Robot)| {
            let fault = fleet.faults.iter().find(|fault| fault.robot == RobotId(number));
            RobotState {
                robot: *robot,
                at: robot.start,
                standing: Standing::Active,
                leader: Leader::default(),
                last: None,
                actions: 0,
                fails_at: fault.map(|fault| fault.action),
            }
        };
        let robot_states: Vec<RobotState> = (0..).zip(&fleet.robots).map(robot_state).collect();
        let starts: Vec<Cell> = robot_states.iter().map(|robot_state| robot_state.at.cell).collect();
        let Cover { percent, mode } = brief.cover.unwrap_or(Cover { percent: 100, mode: CoverMode::Overlap });
        let mut progress = Progress::new(brief.grid, |cell| is_free(terrain, cell), &starts, mode, percent);
        for (robot, start) in starts.iter().enumerate() {
            progress.visit(robot, *start);
        }
        let order = TurnOrder::new(robot_states.len() as u16);
        let mut robots =
            Self { order, robot_states, progress, actions_max: brief.limits.steps_max, actor: None };
        robots.finish_those_done();
        robots
    }

    /// Whose turn it is; `None` once nobody acts any more.
    #[must_use]
    pub fn due(&self) -> Option<RobotId> {
        match self.order.due() {
            Due::Robot(robot) => Some(robot),
            Due::Deadlock | Due::AllDone => None,
        }
    }

    /// Number of robots.
    #[must_use]
    pub fn count(&self) -> u16 {
        self.robot_states.len() as u16
    }

    /// Who commands `robot`.
    ///
    /// # Panics
    /// If the mission has no such robot.
    #[must_use]
    pub fn leader(&self, robot: RobotId) -> Leader {
        self.robot_states[usize::from(robot.0)].leader
    }

    /// Whether `robot` takes turns still.
    #[must_use]
    pub fn is_active(&self, robot: RobotId) -> bool {
        self.robot_states[usize::from(robot.0)].standing == Standing::Active
    }

    /// Cells visited.
    #[must_use]
    pub fn visited_cells(&self) -> u64 {
        self.progress.visited_cells() as u64
    }

    /// How the mission stands: reached once all is covered; lost if nobody can act any more before; a deadlock if the robot
    /// that is due has used up its actions.
    #[must_use]
    pub fn status(&self) -> Status {
        match self.due() {
            _ if self.progress.is_covered() => Status::Goal,
            None => Status::Lost,
            Some(robot) if self.robot_states[usize::from(robot.0)].actions >= self.actions_max => {
                Status::Deadlock
            }
            Some(_) => Status::Underway,
        }
    }

    /// Why the robot that is due shall not execute `action`, if there is a reason: the guard of robots, which asks for
    /// what their sensors show from where they stand, and for where the others are.
    #[must_use]
    pub fn refusal(&self, terrain: &Terrain, action: Action) -> Option<Refusal> {
        let robot_state = self.robot_states.get(usize::from(self.due()?.0))?;
        let vetoed = Refusal::Vetoed { action, need: 0.0, got: 1.0 };
        match (robot_state.robot.vehicle, action) {
            (_, Action::Hold) => None,
            (Vehicle::Rover { .. }, Action::Step(direction)) => {
                let to = beside(robot_state.at.cell, direction);
                let holder = self.robot_states.iter().position(|other| other.at.cell == to);
                match holder {
                    Some(holder) => {
                        Some(Refusal::Occupied { action, cell: to, robot: RobotId(holder as u16) })
                    }
                    None => (!is_free(terrain, to)).then_some(vetoed),
                }
            }
            _ => Some(Refusal::malformed("command.action", "a step or hold: the robot is a rover", action)),
        }
    }

    /// Executes `action`, which was not refused, at `decision` of the robot that is due, and takes note of it.
    ///
    /// # Panics
    /// If nobody is due.
    pub fn execute(
        &mut self,
        terrain: &Terrain,
        decision: Decision,
        leader: Leader,
        action: Action,
    ) -> (RobotId, Execution) {
        let robot = self.due().expect("a mission underway has a robot that is due");
        let outcome = self.outcome(terrain, robot, action);
        let (steps, status) = self.take(terrain, robot, decision, leader, action, &outcome);
        let height_m = terrain.ground(outcome.to).map_or(0.0, |ground| ground.height_m);
        let execution = Execution {
            outcome,
            pose: Pose { cell: outcome.to, height_m },
            collected: Collected::default(),
            steps,
            visits: self.visited_cells(),
            status,
        };
        (robot, execution)
    }

    /// Takes note of a decision of an earlier life.
    ///
    /// # Panics
    /// If another robot was due; the digest chain of a journal is checked when it is opened.
    pub fn recall(&mut self, terrain: &Terrain, record: &Record) {
        let Record { robot, decision, leader, action, outcome, .. } = record;
        self.take(terrain, *robot, *decision, *leader, *action, outcome);
    }

    /// All of them, as published with `state`.
    #[must_use]
    pub fn team(&self, state: &State) -> Team {
        let member = |(number, robot_state): (u16, &RobotState)| Member {
            robot: robot_state.robot,
            at: robot_state.at,
            ready_at_ns: self.order.ready_at_ns(RobotId(number)),
            standing: robot_state.standing,
            leader: robot_state.leader,
            last: robot_state.last,
            travel: None,
        };
        Team {
            run: state.run,
            decision: state.decision,
            digest: state.digest,
            due: self.due().or(self.actor).unwrap_or_default(),
            actor: self.actor,
            members: (0..).zip(&self.robot_states).map(member).collect(),
        }
    }

    fn outcome(&self, terrain: &Terrain, robot: RobotId, action: Action) -> Outcome {
        let robot_state = &self.robot_states[usize::from(robot.0)];
        let from = robot_state.at.cell;
        let speed_mps = match robot_state.robot.vehicle {
            Vehicle::Rover { speed_mps } | Vehicle::Helicopter { speed_mps, .. } => speed_mps,
            // Scenarios that cover ground have rovers only.
            Vehicle::Driver { .. } => 1.0,
        };
        let stays = |branch| {
            let flight = Flight { flight_time_s: 1.0, flights: 1, ..Flight::default() };
            Outcome { branch, from, to: from, flight }
        };
        match action {
            _ if robot_state.fails_at == Some(robot_state.actions + 1) => stays(Branch::Stranded),
            Action::Step(direction) => {
                let to = beside(from, direction);
                let height_m = |cell| terrain.ground(cell).map_or(0.0, |ground| ground.height_m);
                let (range_m, rise_m) = (terrain.grid.cell_size_m, height_m(to) - height_m(from));
                let way_m = range_m.hypot(rise_m);
                let flight = Flight {
                    range_m,
                    rise_m,
                    flight_time_s: way_m / speed_mps,
                    flights: 1,
                    ..Flight::default()
                };
                Outcome { branch: Branch::Intended, from, to, flight }
            }
            _ => stays(Branch::Held),
        }
    }

    /// Steps and status after an action with that outcome.
    fn take(
        &mut self,
        terrain: &Terrain,
        robot: RobotId,
        decision: Decision,
        leader: Leader,
        action: Action,
        outcome: &Outcome,
    ) -> (u64, Status) {
        let number = usize::from(robot.0);
        self.order.act(robot, duration_ns(outcome.flight.flight_time_s));
        self.actor = Some(robot);
        let robot_state = &mut self.robot_states[number];
        (robot_state.last, robot_state.leader) = (Some(decision), leader);
        robot_state.actions += 1;
        if outcome.branch == Branch::Stranded {
            robot_state.standing = Standing::Stranded;
            self.order.finish(robot);
            let active =
                self.robot_states.iter().filter(|robot_state| robot_state.standing == Standing::Active);
            let stranded: Vec<Cell> = self
                .robot_states
                .iter()
                .filter(|robot_state| robot_state.standing == Standing::Stranded)
                .map(|robot_state| robot_state.at.cell)
                .collect();
            let is_open = |cell| is_free(terrain, cell) && !stranded.contains(&cell);
            self.progress.strand(active.map(|robot_state| robot_state.at.cell), is_open);
        } else if let Action::Step(heading) = action {
            robot_state.at = Placement { cell: outcome.to, heading };
            self.progress.visit(number, outcome.to);
        }
        self.finish_those_done();
        let steps = self.robot_states.iter().map(|robot_state| robot_state.actions).max().unwrap_or_default();
        (steps, self.status())
    }

    /// Whoever has nothing left to cover acts no more.
    fn finish_those_done(&mut self) {
        for (number, robot_state) in self.robot_states.iter_mut().enumerate() {
            if robot_state.standing == Standing::Active && self.progress.is_done(number) {
                robot_state.standing = Standing::Done;
                self.order.finish(RobotId(number as u16));
            }
        }
    }
}

/// Whether a ground robot can stand on `cell`.
fn is_free(terrain: &Terrain, cell: Cell) -> bool {
    terrain.ground(cell).is_some_and(|ground| ground.passable)
}

fn beside(cell: Cell, direction: Direction) -> Cell {
    let (dx, dy) = direction.step();
    Cell::new(cell.x + dx, cell.y + dy)
}
