//! Rovers that cover ground as they should: whose turn it is, where a step leads, when a rover fails, what is left to
//! cover, by code that shares nothing with the product's.

use contract::{
    Action, Branch, Cell, Decision, Digest, Direction, Flight, Leader, Outcome, Placement, Pose, Record,
    Robot, RobotId, RunId, Sensor, Standing, Status, Team, Vehicle, Vetoed,
};
use hopper_sim::Mission;
use hopper_sim::dynamics::Execution;

use crate::covered::{Covered, index, is_free};

const SECOND_NS: u64 = 1_000_000_000;

#[derive(Clone, Debug)]
struct Rover {
    robot: Robot,
    at: Placement,
    clock_ns: u64,
    actions: u64,
    standing: Standing,
    leader: Leader,
    last: Option<Decision>,
    fails_at: Option<u64>,
}

/// The rovers of a mission after some decisions.
#[derive(Clone, Debug)]
pub(crate) struct Rovers {
    actions_max: u64,
    rovers: Vec<Rover>,
    covered: Covered,
    actor: Option<usize>,
    /// When the last action began, nanoseconds of simulated time.
    acted_at_ns: u64,
}

impl Rovers {
    /// Before the first decision; `None` if the mission is that of a hopper.
    pub fn begin(mission: &Mission) -> Option<Self> {
        let fleet = mission.fleet.as_ref()?;
        let fails_at = |number: usize| {
            let fault = fleet.faults.iter().find(|fault| usize::from(fault.robot.0) == number);
            fault.map(|fault| fault.action)
        };
        let rover = |(number, robot): (usize, &Robot)| Rover {
            robot: *robot,
            at: robot.start,
            clock_ns: 0,
            actions: 0,
            standing: Standing::Active,
            leader: Leader::default(),
            last: None,
            fails_at: fails_at(number),
        };
        let starts = fleet.robots.iter().map(|robot| robot.start.cell).collect();
        let mut rovers = Self {
            actions_max: mission.brief.limits.steps_max,
            rovers: fleet.robots.iter().enumerate().map(rover).collect(),
            covered: Covered::begin(mission, starts, Vec::new())?,
            actor: None,
            acted_at_ns: 0,
        };
        rovers.retire(mission);
        Some(rovers)
    }

    /// Who acts next; once nobody does, who acted last.
    pub fn due(&self) -> RobotId {
        let due = self.next().or(self.actor).unwrap_or_default();
        RobotId(due as u16)
    }

    fn next(&self) -> Option<usize> {
        let active = |number: &usize| self.rovers[*number].standing == Standing::Active;
        (0..self.rovers.len()).filter(active).min_by_key(|&number| (self.rovers[number].clock_ns, number))
    }

    /// Simulated time from the beginning of the last action to that of the next, nanoseconds.
    pub fn lasts_ns(&self) -> u64 {
        let next = self.next().or(self.actor).map(|number| self.rovers[number].clock_ns);
        next.map_or(0, |next_ns| next_ns.saturating_sub(self.acted_at_ns))
    }

    pub fn leader(&self, robot: RobotId) -> Leader {
        self.rovers.get(usize::from(robot.0)).map_or(Leader::default(), |rover| rover.leader)
    }

    pub fn status(&self, mission: &Mission) -> Status {
        match self.next() {
            _ if self.covered.is_all_covered(mission) => Status::Goal,
            None => Status::Lost,
            Some(due) if self.rovers[due].actions >= self.actions_max => Status::Deadlock,
            Some(_) => Status::Underway,
        }
    }

    /// What each rover sees from where it stands: the range in cells, and the cell.
    pub fn views(&self) -> Vec<(i32, Cell)> {
        self.rovers.iter().map(|rover| view(&rover.robot, rover.at.cell)).collect()
    }

    /// What the rover of `record` sees anew, if it moved.
    pub fn view_after(&self, record: &Record) -> Option<(i32, Cell)> {
        let rover = &self.rovers[usize::from(record.robot.0)];
        let moved = record.outcome.branch == Branch::Intended && matches!(record.action, Action::Step(_));
        moved.then(|| view(&rover.robot, record.outcome.to))
    }

    /// Steps of the due rover that are no ground to stand on, or where another one stands.
    pub fn blocked(&self, mission: &Mission) -> Vetoed {
        let Some(due) = self.next() else { return Vetoed::NONE };
        let from = self.rovers[due].at.cell;
        let is_blocked = |action: &Action| {
            let Action::Step(_) = action else { return false };
            let to = beside(from, *action);
            !is_free(mission, to) || self.rovers.iter().any(|other| other.at.cell == to)
        };
        Action::ALL.into_iter().filter(is_blocked).fold(Vetoed::NONE, Vetoed::with)
    }

    /// A step that is blocked, to the cell of another rover if one is.
    pub fn blocked_step(&self, mission: &Mission) -> Option<Action> {
        let from = self.rovers[self.next()?].at.cell;
        let blocked = self.blocked(mission);
        let is_held = |action: Action| self.rovers.iter().any(|other| other.at.cell == beside(from, action));
        let steps = Action::ALL.into_iter().filter(|action| blocked.has(*action));
        steps.max_by_key(|action| is_held(*action))
    }

    /// How the due rover's `action` comes out.
    pub fn execute(&self, mission: &Mission, action: Action) -> Option<(RobotId, Execution)> {
        let due = self.next()?;
        let rover = &self.rovers[due];
        let from = rover.at.cell;
        let fails = rover.fails_at == Some(rover.actions + 1);
        if !matches!(action, Action::Hold | Action::Step(_)) {
            return None;
        }
        let outcome = outcome(mission, &rover.robot, from, action, fails)?;
        let mut after = self.clone();
        after.act(mission, due, action, &outcome);
        let execution = Execution {
            outcome,
            pose: Pose { cell: outcome.to, height_m: height_m(mission, outcome.to) },
            collected: contract::Collected::default(),
            steps: after.rovers.iter().map(|rover| rover.actions).max().unwrap_or_default(),
            visits: after.covered.visits(),
            status: after.status(mission),
        };
        Some((RobotId(due as u16), execution))
    }

    /// A record was committed.
    pub fn committed(&mut self, mission: &Mission, record: &Record) {
        let number = usize::from(record.robot.0);
        if number >= self.rovers.len() {
            return;
        }
        self.act(mission, number, record.action, &record.outcome);
        (self.rovers[number].leader, self.rovers[number].last) = (record.leader, Some(record.decision));
    }

    fn act(&mut self, mission: &Mission, number: usize, action: Action, outcome: &Outcome) {
        let rover = &mut self.rovers[number];
        self.acted_at_ns = rover.clock_ns;
        rover.clock_ns += ((outcome.flight.flight_time_s * 1e9).round() as u64).max(SECOND_NS);
        rover.actions += 1;
        self.actor = Some(number);
        if outcome.branch == Branch::Stranded {
            rover.standing = Standing::Stranded;
            let (active, stranded) = (self.cells_of(Standing::Active), self.cells_of(Standing::Stranded));
            self.covered.close(mission, &active, &stranded);
        } else if let Action::Step(heading) = action {
            rover.at = Placement { cell: outcome.to, heading };
            self.covered.visit(mission, number, outcome.to);
        }
        self.retire(mission);
    }

    fn cells_of(&self, standing: Standing) -> Vec<Cell> {
        let those = self.rovers.iter().filter(|rover| rover.standing == standing);
        those.map(|rover| rover.at.cell).collect()
    }

    fn retire(&mut self, mission: &Mission) {
        for (number, rover) in self.rovers.iter_mut().enumerate() {
            if rover.standing == Standing::Active && self.covered.has_covered(mission, number) {
                rover.standing = Standing::Done;
            }
        }
    }

    /// The message about all rovers as of the state of `decision` with `digest`.
    pub fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        let member = |rover: &Rover| contract::Member {
            robot: rover.robot,
            at: rover.at,
            ready_at_ns: rover.clock_ns,
            standing: rover.standing,
            waits: false,
            leader: rover.leader,
            last: rover.last,
            travel: None,
        };
        let members = self.rovers.iter().map(member).collect();
        let actor = self.actor.map(|actor| RobotId(actor as u16));
        Team { run, decision, digest, due: self.due(), actor, members }
    }
}

fn view(robot: &Robot, cell: Cell) -> (i32, Cell) {
    match robot.sensor {
        Sensor::Square { range_cells } => (range_cells as i32, cell),
        _ => (0, cell),
    }
}

/// The cell to which a step leads.
pub(crate) fn beside(cell: Cell, action: Action) -> Cell {
    match action {
        Action::Step(Direction::North) => Cell::new(cell.x, cell.y + 1),
        Action::Step(Direction::East) => Cell::new(cell.x + 1, cell.y),
        Action::Step(Direction::South) => Cell::new(cell.x, cell.y - 1),
        Action::Step(Direction::West) => Cell::new(cell.x - 1, cell.y),
        _ => cell,
    }
}

/// What `action` of a rover on `from` comes to, which fails at it if `fails`.
pub(crate) fn outcome(
    mission: &Mission,
    robot: &Robot,
    from: Cell,
    action: Action,
    fails: bool,
) -> Option<Outcome> {
    let still = Flight { flight_time_s: 1.0, flights: 1, ..Flight::default() };
    if fails {
        return Some(Outcome { branch: Branch::Stranded, from, to: from, flight: still });
    }
    let Action::Step(_) = action else {
        return Some(Outcome { branch: Branch::Held, from, to: from, flight: still });
    };
    let to = beside(from, action);
    let range_m = mission.brief.grid.cell_size_m;
    let rise_m = height_m(mission, to) - height_m(mission, from);
    let Vehicle::Rover { speed_mps } = robot.vehicle else { return None };
    let flight_time_s = libm::hypot(range_m, rise_m) / speed_mps;
    let flight = Flight { range_m, rise_m, flight_time_s, flights: 1, ..Flight::default() };
    Some(Outcome { branch: Branch::Intended, from, to, flight })
}

fn height_m(mission: &Mission, cell: Cell) -> f64 {
    mission.terrain.cells[index(mission, cell)].height_m
}
