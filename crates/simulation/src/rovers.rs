//! Rovers that cover ground as they should: whose turn it is, where a step leads, when a rover fails, what is left to
//! cover, by code that shares nothing with the product's.

use contract::{
    Action, Branch, Cell, Cover, CoverMode, Decision, Digest, Direction, Flight, Leader, Outcome, Placement,
    Pose, Record, Robot, RobotId, RunId, Sensor, Standing, Status, Team, Vehicle, Vetoed,
};
use hopper_sim::Mission;
use hopper_sim::dynamics::Execution;

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
    /// Cells that it was the first to enter.
    first_visits: usize,
}

/// The rovers of a mission after some decisions.
#[derive(Clone, Debug)]
pub(crate) struct Rovers {
    cover: Cover,
    actions_max: u64,
    rovers: Vec<Rover>,
    visited: Vec<bool>,
    /// Of the ground that all rovers share: the cells that count.
    shared: Vec<bool>,
    actor: Option<usize>,
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
            first_visits: 0,
        };
        let mut rovers = Self {
            cover: mission.brief.cover?,
            actions_max: mission.brief.limits.steps_max,
            rovers: fleet.robots.iter().enumerate().map(rover).collect(),
            visited: vec![false; mission.brief.grid.cells()],
            shared: Vec::new(),
            actor: None,
        };
        let starts: Vec<Cell> = rovers.starts().collect();
        rovers.shared = flood(mission, &starts, |_| true);
        (0..starts.len()).for_each(|number| rovers.visit(mission, number));
        rovers.retire(mission);
        Some(rovers)
    }

    fn starts(&self) -> impl Iterator<Item = Cell> + '_ {
        self.rovers.iter().map(|rover| rover.robot.start.cell)
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

    pub fn leader(&self, robot: RobotId) -> Leader {
        self.rovers.get(usize::from(robot.0)).map_or(Leader::default(), |rover| rover.leader)
    }

    pub fn status(&self, mission: &Mission) -> Status {
        let all_covered = (0..self.rovers.len()).all(|number| self.has_covered(mission, number));
        match self.next() {
            _ if all_covered => Status::Goal,
            None => Status::Lost,
            Some(due) if self.rovers[due].actions >= self.actions_max => Status::Deadlock,
            Some(_) => Status::Underway,
        }
    }

    /// Cells visited by anybody.
    pub fn visits(&self) -> u64 {
        self.visited.iter().filter(|visited| **visited).count() as u64
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

    /// One of them, that to another rover if there is one.
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
        let height_m = |cell: Cell| mission.terrain.cells[index(mission, cell)].height_m;
        let still = Flight { flight_time_s: 1.0, flights: 1, ..Flight::default() };
        let outcome = if rover.fails_at == Some(rover.actions + 1) {
            Outcome { branch: Branch::Stranded, from, to: from, flight: still }
        } else if let Action::Step(_) = action {
            let to = beside(from, action);
            let (range_m, rise_m) = (mission.brief.grid.cell_size_m, height_m(to) - height_m(from));
            let Vehicle::Rover { speed_mps } = rover.robot.vehicle else { return None };
            let flight_time_s = libm::hypot(range_m, rise_m) / speed_mps;
            let flight = Flight { range_m, rise_m, flight_time_s, flights: 1, ..Flight::default() };
            Outcome { branch: Branch::Intended, from, to, flight }
        } else {
            Outcome { branch: Branch::Held, from, to: from, flight: still }
        };
        let mut after = self.clone();
        after.act(mission, due, action, &outcome);
        let execution = Execution {
            outcome,
            pose: Pose { cell: outcome.to, height_m: height_m(outcome.to) },
            collected: contract::Collected::default(),
            steps: after.rovers.iter().map(|rover| rover.actions).max().unwrap_or_default(),
            visits: after.visits(),
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
        rover.clock_ns += ((outcome.flight.flight_time_s * 1e9).round() as u64).max(SECOND_NS);
        rover.actions += 1;
        self.actor = Some(number);
        if outcome.branch == Branch::Stranded {
            rover.standing = Standing::Stranded;
            self.share_anew(mission);
        } else if let Action::Step(heading) = action {
            rover.at = Placement { cell: outcome.to, heading };
            self.visit(mission, number);
        }
        self.retire(mission);
    }

    /// Without the one that failed: what the others can still reach counts, and what has been visited.
    fn share_anew(&mut self, mission: &Mission) {
        let cells_of = |standing: Standing| {
            let those = self.rovers.iter().filter(move |rover| rover.standing == standing);
            those.map(|rover| rover.at.cell).collect::<Vec<_>>()
        };
        let (active, stranded) = (cells_of(Standing::Active), cells_of(Standing::Stranded));
        let reached = flood(mission, &active, |cell| !stranded.contains(&cell));
        self.shared =
            reached.iter().zip(&self.visited).map(|(reached, visited)| *reached || *visited).collect();
    }

    fn visit(&mut self, mission: &Mission, number: usize) {
        let rover = &mut self.rovers[number];
        let visited = &mut self.visited[index(mission, rover.at.cell)];
        rover.first_visits += usize::from(!*visited);
        *visited = true;
    }

    fn retire(&mut self, mission: &Mission) {
        for number in 0..self.rovers.len() {
            if self.rovers[number].standing == Standing::Active && self.has_covered(mission, number) {
                self.rovers[number].standing = Standing::Done;
            }
        }
    }

    /// Whether a rover has nothing left to cover: of the shared ground, or of its own region.
    fn has_covered(&self, mission: &Mission, number: usize) -> bool {
        let (counts, visited) = match self.cover.mode {
            CoverMode::Overlap => (self.shared.clone(), self.visits() as usize),
            CoverMode::Voronoi => {
                let start = self.rovers[number].robot.start.cell;
                let own = |cell: Cell| {
                    let away = |start: Cell| (start.x - cell.x).pow(2) + (start.y - cell.y).pow(2);
                    let nearest =
                        self.starts().enumerate().min_by_key(|(other, start)| (away(*start), *other));
                    nearest.is_some_and(|(nearest, _)| nearest == number)
                };
                (flood(mission, &[start], own), self.rovers[number].first_visits)
            }
        };
        let cells = counts.into_iter().filter(|counts| *counts).count();
        100 * visited >= self.cover.percent as usize * cells
    }

    /// The message about all rovers as of the state of `decision` with `digest`.
    pub fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        let member = |rover: &Rover| contract::Member {
            robot: rover.robot,
            at: rover.at,
            ready_at_ns: rover.clock_ns,
            standing: rover.standing,
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

fn beside(cell: Cell, action: Action) -> Cell {
    match action {
        Action::Step(Direction::North) => Cell::new(cell.x, cell.y + 1),
        Action::Step(Direction::East) => Cell::new(cell.x + 1, cell.y),
        Action::Step(Direction::South) => Cell::new(cell.x, cell.y - 1),
        Action::Step(Direction::West) => Cell::new(cell.x - 1, cell.y),
        _ => cell,
    }
}

fn index(mission: &Mission, cell: Cell) -> usize {
    (cell.y * mission.brief.grid.width as i32 + cell.x) as usize
}

fn is_free(mission: &Mission, cell: Cell) -> bool {
    let grid = mission.brief.grid;
    let inside = (0..grid.width as i32).contains(&cell.x) && (0..grid.height as i32).contains(&cell.y);
    inside && mission.terrain.cells[index(mission, cell)].passable
}

/// Cells that can be reached by steps from any of `from`, over cells that are free and `open`.
fn flood(mission: &Mission, from: &[Cell], open: impl Fn(Cell) -> bool) -> Vec<bool> {
    let mut reached = vec![false; mission.brief.grid.cells()];
    let mut left: Vec<Cell> = from.to_vec();
    while let Some(cell) = left.pop() {
        if !is_free(mission, cell) || !open(cell) || reached[index(mission, cell)] {
            continue;
        }
        reached[index(mission, cell)] = true;
        left.extend([(0, 1), (1, 0), (0, -1), (-1, 0)].map(|(dx, dy)| Cell::new(cell.x + dx, cell.y + dy)));
    }
    reached
}
