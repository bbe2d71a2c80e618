//! The robots of a mission as they should be, by code that shares nothing with the product's: whose turn it is, what an action
//! comes to, what becomes of each robot, how the mission stands. How robots go from point to point is asked of
//! [`crate::scouts`], what covering comes to of [`crate::covered`], and what a rover's step comes to of [`crate::rovers`];
//! where a hop leads is drawn here.

use std::sync::Arc;

use contract::{
    Action, Announcement, Branch, Brief, Cell, Collected, Decision, Digest, Direction, Flight, Leader,
    Origin, Outcome, Pose, Record, Robot, RobotId, RobotSet, RunId, Sensor, Standing, State, Status, Team,
    Vehicle, Vetoed,
};
use hopper_sim::Mission;
use hopper_sim::dynamics::Execution;
use motion::{Domain, Draw};
use terrain::Terrain;

use crate::covered::{Covered, is_free};
use crate::expected::{Expected, Shown, design, disc, square};
use crate::rovers::{self, beside};
use crate::scouts::{Scouts, TOLERANCE_M, gave_up, point};

/// The robots of a mission after some decisions.
#[derive(Clone, Debug)]
pub(crate) struct Robots {
    /// All robots; of those that go from cell to cell only what all have.
    scouts: Scouts,
    required: RobotSet,
    /// Where each robot faces.
    headings: Vec<Direction>,
    /// The robots that cover ground.
    rovers: Vec<usize>,
    covered: Option<Covered>,
}

/// How the task of a robot stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    Open,
    Done,
    Failed(Status),
}

impl Robots {
    /// Before the first decision.
    pub fn begin(mission: &Mission) -> Self {
        let scouts = Scouts::begin(mission);
        let robots = || scouts.scouts.iter().map(|scout| scout.robot).enumerate();
        let rovers: Vec<usize> = robots()
            .filter(|(_, robot)| matches!(robot.vehicle, Vehicle::Rover { .. }))
            .map(|(number, _)| number)
            .collect();
        let starts = rovers.iter().map(|number| scouts.scouts[*number].cell).collect();
        let with_goals = robots().filter(|(_, robot)| !matches!(robot.vehicle, Vehicle::Helicopter { .. }));
        let with_goals = with_goals.fold(RobotSet::NONE, |set, (number, _)| set.with(RobotId(number as u16)));
        let covered =
            if rovers.is_empty() { None } else { Covered::begin(mission, starts, goals_of_hoppers(mission)) };
        let mut begun = Self {
            required: mission.brief.mixed.map_or(with_goals, |mixed| mixed.required),
            headings: robots().map(|(_, robot)| robot.start.heading).collect(),
            covered,
            rovers,
            scouts,
        };
        let count = begun.headings.len();
        (0..count).for_each(|number| begun.look_around(mission, number));
        begun.retire(mission);
        (0..count).for_each(|number| begun.end_if_over(mission, number, mission.brief.reading.opening_steps));
        begun
    }

    /// A planner publishes the points of a route.
    pub fn announce(&mut self, announcement: &Announcement) {
        self.scouts.announce(announcement);
    }

    /// Simulated time from the beginning of the last action, which came to `outcome`, to that of the next, nanoseconds: the
    /// whole action of a hopper alone.
    pub fn lasts_ns(&self, mission: &Mission, outcome: &Outcome) -> u64 {
        if mission.brief.has_team() {
            return self.scouts.lasts_ns();
        }
        let Flight { flight_time_s, flights, .. } = outcome.flight;
        (flight_time_s * f64::from(flights) * 1e9).round() as u64
    }

    /// What all see from their starts.
    pub fn open(&self, brief: &Brief, terrain: &Terrain, expected: &mut Expected) {
        if covers_only(brief) {
            let views: Vec<_> =
                self.scouts.scouts.iter().map(|scout| view(&scout.robot, scout.cell)).collect();
            return expected.enter(brief, terrain, &views);
        }
        self.rover_starts().for_each(|cell| expected.visit(brief, cell));
        expected.reveal(brief, terrain, self.scouts.shown());
        if let Some(start) = self.scouts.hopper_start(terrain) {
            expected.land(brief, terrain, start);
        }
    }

    /// What is seen after `record`, which was committed.
    pub fn see(&self, brief: &Brief, terrain: &Terrain, record: &Record, expected: &mut Expected) {
        let entered = self.entered(record);
        if covers_only(brief) {
            let robot = &self.scouts.scouts[usize::from(record.robot.0)].robot;
            let views: Vec<_> = entered.into_iter().map(|cell| view(robot, cell)).collect();
            return expected.enter(brief, terrain, &views);
        }
        let hops = self.scouts.is_hopper(record.robot);
        if hops && brief.is_of_hopper() {
            return expected.land(brief, terrain, record.pose);
        }
        entered.into_iter().for_each(|cell| expected.visit(brief, cell));
        expected.reveal(brief, terrain, self.scouts.shown());
        if hops {
            expected.collect(record.pose.cell);
        }
    }

    /// Whether it is the turn of a hopper.
    pub fn is_turn_of_hopper(&self) -> bool {
        self.scouts.is_hopper(self.scouts.due())
    }

    /// What all robots have, and those that go from point to point.
    pub fn scouts(&self) -> &Scouts {
        &self.scouts
    }

    /// What all robots have, to be changed.
    pub fn scouts_mut(&mut self) -> &mut Scouts {
        &mut self.scouts
    }

    /// Where the rovers begin that cover ground: each start is a visit.
    pub fn rover_starts(&self) -> impl Iterator<Item = Cell> {
        self.rovers.iter().map(|number| self.scouts.scouts[*number].robot.start.cell)
    }

    /// The cell that a rover which covers ground has entered by `record`.
    pub fn entered(&self, record: &Record) -> Option<Cell> {
        let is_rover = self.rovers.contains(&usize::from(record.robot.0));
        let has_moved = record.outcome.branch == Branch::Intended && matches!(record.action, Action::Step(_));
        (is_rover && has_moved).then_some(record.outcome.to)
    }

    /// Start, goal and place of the hopper that is due.
    pub fn own_way(&self) -> Option<[Cell; 3]> {
        let scout = &self.scouts.scouts[self.scouts.next()?];
        let Vehicle::HopperTo { goal } = scout.robot.vehicle else { return None };
        Some([scout.robot.start.cell, goal, scout.cell])
    }

    /// The robot that is due.
    pub fn due(&self) -> Option<RobotId> {
        self.scouts.next().map(|number| RobotId(number as u16))
    }

    /// How a robot stands.
    pub fn standing(&self, robot: RobotId) -> Option<Standing> {
        self.scouts.scouts.get(usize::from(robot.0)).map(|scout| scout.standing)
    }

    /// Whether the mission needs the task of a robot.
    pub fn needs(&self, robot: RobotId) -> bool {
        self.required.has(robot)
    }

    /// Whether a robot can still act.
    pub fn is_any_active(&self) -> bool {
        self.scouts.scouts.iter().any(|scout| scout.standing == Standing::Active)
    }

    /// Whether a rover is still at work on ground that is not covered.
    pub fn is_covering(&self) -> bool {
        self.rovers.iter().any(|number| self.scouts.scouts[*number].standing == Standing::Active)
    }

    /// Whether a robot on the ground other than `number` is on a cell.
    fn is_occupied(&self, mission: &Mission, number: usize, cell: Cell) -> bool {
        let mut scouts = self.scouts.scouts.iter().enumerate();
        scouts.any(|(other, scout)| {
            let flies = matches!(scout.robot.vehicle, Vehicle::Helicopter { .. });
            other != number && !flies && scout.cell == cell
        }) && mission.terrain.ground(cell).is_some()
    }

    /// Whether a robot on the ground other than `number` has stopped on a cell for good.
    fn is_taken_for_good(&self, number: usize, cell: Cell) -> bool {
        let mut scouts = self.scouts.scouts.iter().enumerate();
        scouts.any(|(other, scout)| {
            let flies = matches!(scout.robot.vehicle, Vehicle::Helicopter { .. });
            other != number && !flies && scout.standing != Standing::Active && scout.cell == cell
        })
    }

    /// What the robot that is due must not do: whatever ends where another is, a step to no ground to stand on, and a drive that
    /// may be a trap. What is dangerous to a hopper is not among it.
    pub fn blocked(&self, mission: &Mission) -> Vetoed {
        let Some(due) = self.scouts.next() else { return Vetoed::NONE };
        let scout = &self.scouts.scouts[due];
        let is_blocked = |action: &Action| match (action, scout.robot.vehicle) {
            (Action::Hop(direction), Vehicle::Hopper | Vehicle::HopperTo { .. }) => {
                self.is_occupied(mission, due, mission.brief.grid.hop(scout.cell, *direction))
            }
            (Action::Step(_), Vehicle::Rover { .. }) => {
                let to = beside(scout.cell, *action);
                let is_kept = goals_of_hoppers(mission).contains(&to);
                !is_free(mission, to) || is_kept || self.is_occupied(mission, due, to)
            }
            (Action::Drive, Vehicle::Driver { .. }) => {
                let is_taken = |to| self.is_occupied(mission, due, self.scouts.cell(to));
                self.scouts.blocked() != Vetoed::NONE || scout.next().is_some_and(is_taken)
            }
            _ => false,
        };
        Action::ALL.into_iter().filter(is_blocked).fold(Vetoed::NONE, Vetoed::with)
    }

    /// One of them: that onto the goal of a hopper if there is one, else that to another robot.
    pub fn blocked_action(&self, mission: &Mission) -> Option<Action> {
        let due = self.scouts.next()?;
        let blocked = self.blocked(mission);
        let rank = |action: &Action| {
            let Action::Step(_) = action else { return 1 };
            let to = beside(self.scouts.scouts[due].cell, *action);
            let is_kept = goals_of_hoppers(mission).contains(&to);
            if is_kept { 2 } else { usize::from(self.is_occupied(mission, due, to)) }
        };
        Action::ALL.into_iter().filter(|action| blocked.has(*action)).max_by_key(rank)
    }

    /// What is done at the deadline, unless a hopper is due: on along the route if that may be, or nothing.
    pub fn fallback(&self, mission: &Mission) -> (Action, Origin) {
        let along = self.scouts.next().and_then(|due| match self.scouts.scouts[due].robot.vehicle {
            Vehicle::Driver { .. } => Some((due, Action::Drive)),
            Vehicle::Helicopter { .. } => Some((due, Action::Fly)),
            _ => None,
        });
        let along = along.filter(|(due, action)| self.may(mission, *due, *action));
        along.map_or((Action::Hold, Origin::Hold), |(_, action)| (action, Origin::Policy))
    }

    /// Whether the robot that is due may do that.
    fn may(&self, mission: &Mission, due: usize, action: Action) -> bool {
        let is_of_kind = match self.scouts.scouts[due].robot.vehicle {
            Vehicle::Hopper => matches!(action, Action::Hold | Action::Hop(_)),
            Vehicle::HopperTo { .. } => matches!(action, Action::Hold | Action::Wait | Action::Hop(_)),
            Vehicle::Rover { .. } => matches!(action, Action::Hold | Action::Wait | Action::Step(_)),
            _ => self.scouts.may(due, action),
        };
        is_of_kind && !self.blocked(mission).has(action)
    }

    /// How the due robot's `action` comes out; `None` if it must be refused.
    pub fn execute(&self, mission: &Mission, before: &State, action: Action) -> Option<(RobotId, Execution)> {
        let due = self.scouts.next()?;
        if !self.may(mission, due, action) {
            return None;
        }
        let outcome = self.outcome(mission, due, before.decision, action)?;
        let robot = RobotId(due as u16);
        let ground = |cell| mission.terrain.ground(cell);
        // Who waits or fails lands nowhere.
        let lands =
            self.scouts.is_hopper(robot) && action != Action::Wait && outcome.branch != Branch::Stranded;
        let soil = ground(outcome.from).map(|ground| ground.soil);
        let hopped = soil.map_or(0, |soil| motion::steps(soil, action, outcome.branch));
        let hopper_steps = before.steps + if lands { hopped } else { 0 };
        let mut after = self.clone();
        after.take(mission, due, (before.decision, action), &outcome, hopper_steps);
        let height_m = ground(outcome.to).or(ground(outcome.from)).map_or(0.0, |ground| ground.height_m);
        let found = mission.terrain.treasures.iter().position(|cell| lands && *cell == outcome.to);
        let brief = &mission.brief;
        let goal = brief
            .patrol
            .map_or(brief.goal, |patrol| patrol.goals()[before.visits as usize % patrol.goals().len()]);
        let actions = |waits: bool| {
            let actions =
                after.scouts.scouts.iter().map(|scout| scout.actions - if waits { 0 } else { scout.waited });
            actions.max().unwrap_or_default()
        };
        let pose = Pose { cell: outcome.to, height_m };
        let is_of_hopper = brief.is_of_hopper();
        let execution = Execution {
            outcome,
            pose: if is_of_hopper && !self.scouts.is_hopper(robot) { before.pose } else { pose },
            collected: Collected(before.collected.0 | found.map_or(0, |number| 1 << number)),
            steps: match (is_of_hopper, brief.scout, brief.mixed) {
                (true, ..) => hopper_steps,
                // Only there to wait is a step.
                (false, Some(_), None) => actions(true),
                _ => actions(false),
            },
            visits: if is_of_hopper {
                before.visits + u64::from(lands && outcome.to == goal)
            } else {
                after.covered.as_ref().map_or(0, Covered::visits)
            },
            status: after.status(mission, hopper_steps),
        };
        Some((robot, execution))
    }

    fn outcome(
        &self,
        mission: &Mission,
        number: usize,
        decision: Decision,
        action: Action,
    ) -> Option<Outcome> {
        let scout = &self.scouts.scouts[number];
        let fails = scout.fails_at == Some(scout.actions + 1);
        match scout.robot.vehicle {
            Vehicle::Hopper | Vehicle::HopperTo { .. } => Some(self.hop(mission, number, decision, action)),
            Vehicle::Rover { .. } if action == Action::Wait && !fails => {
                let flight = Flight::default();
                Some(Outcome { branch: Branch::Held, from: scout.cell, to: scout.cell, flight })
            }
            Vehicle::Rover { .. } => rovers::outcome(mission, &scout.robot, scout.cell, action, fails),
            _ => Some(self.scouts.arrival(number, action).outcome),
        }
    }

    /// A hop, drawn for this robot and decision: it ends where it began if another robot is where it would end.
    fn hop(&self, mission: &Mission, number: usize, decision: Decision, action: Action) -> Outcome {
        let scout = &self.scouts.scouts[number];
        let from = scout.cell;
        let stays = |branch| Outcome { branch, from, to: from, flight: Flight::default() };
        if scout.fails_at == Some(scout.actions + 1) {
            return stays(Branch::Stranded);
        }
        let (Action::Hop(direction), Some(ground)) = (action, mission.terrain.ground(from)) else {
            return stays(Branch::Held);
        };
        let Mission { brief, terrain, seed, .. } = mission;
        let uniform = Draw::new(*seed, Domain::Motion, RobotId(number as u16), decision).uniform();
        let law = design(brief, RobotId(number as u16)).motion;
        let branch = motion::transition(&law, ground, direction).branch(uniform);
        let aim = terrain.ground(brief.grid.hop(from, direction));
        let rise_m = aim.map_or(0.0, |aim| aim.height_m - ground.height_m);
        let end = motion::landing(&brief.grid, from, direction, branch);
        let to = if self.is_occupied(mission, number, end) { from } else { end };
        Outcome { branch, from, to, flight: motion::flight(&law, &brief.grid, ground.soil, rise_m) }
    }

    /// A record was committed.
    pub fn committed(&mut self, mission: &Mission, record: &Record) {
        let number = usize::from(record.robot.0);
        if number >= self.headings.len() {
            return;
        }
        self.scouts.note(record);
        if !mission.brief.has_team() {
            // Those of earlier lives, which need not all be noted.
            self.scouts.scouts[0].actions = record.decision.0;
        }
        self.take(mission, number, (record.decision, record.action), &record.outcome, record.steps);
    }

    /// The action of a robot has come to `outcome`. `steps` are those of the hopper, where the mission counts them.
    fn take(
        &mut self,
        mission: &Mission,
        number: usize,
        (decision, action): (Decision, Action),
        outcome: &Outcome,
        steps: u64,
    ) {
        let rover = self.rovers.iter().position(|rover| *rover == number);
        if rover.is_some() || self.scouts.is_hopper(RobotId(number as u16)) {
            self.scouts.hop(number, action, outcome);
        } else {
            self.scouts.act(number, decision, action);
        }
        let is_stranded = outcome.branch == Branch::Stranded;
        if let (Some(rover), Action::Step(heading), false) = (rover, action, is_stranded) {
            self.headings[number] = heading;
            if let Some(covered) = &mut self.covered {
                covered.visit(mission, rover, outcome.to);
            }
        }
        if rover.is_some() && is_stranded {
            self.close(mission);
        }
        self.look_around(mission, number);
        self.retire(mission);
        self.end_if_over(mission, number, steps);
    }

    /// What a robot that goes from cell to cell sees where it is.
    fn look_around(&mut self, mission: &Mission, number: usize) {
        let Scouts { scouts, shown, .. } = &mut self.scouts;
        let (sensor, cell) = (scouts[number].robot.sensor, scouts[number].cell);
        match (sensor, mission.terrain.ground(cell)) {
            (Sensor::Disc, Some(ground)) => {
                let pose = Pose { cell, height_m: ground.height_m };
                disc(&mission.brief, RobotId(number as u16), pose)
                    .for_each(|index| shown[index] = Shown::Truth);
            }
            (Sensor::Square { range_cells }, _) => {
                square(&mission.brief, range_cells as i32, cell).for_each(|index| shown[index] = Shown::Truth)
            }
            _ => {}
        }
    }

    /// Rovers that have nothing left to cover are done.
    fn retire(&mut self, mission: &Mission) {
        let Some(covered) = &self.covered else { return };
        for (rover, number) in self.rovers.iter().enumerate() {
            let scout = &mut self.scouts.scouts[*number];
            if scout.standing == Standing::Active && covered.has_covered(mission, rover) {
                (scout.standing, scout.waits) = (Standing::Done, false);
            }
        }
    }

    /// What becomes of a robot where it is now, and of the ground that it closes if that is for good.
    fn end_if_over(&mut self, mission: &Mission, number: usize, steps: u64) {
        let scout = &self.scouts.scouts[number];
        let is_spent = scout.actions - scout.waited >= self.scouts.actions_max;
        let gives_up =
            is_spent && !self.required.has(RobotId(number as u16)) && !mission.brief.is_of_hopper();
        let end = match scout.robot.vehicle {
            Vehicle::Hopper | Vehicle::HopperTo { .. } => match mission.terrain.ground(scout.cell) {
                Some(ground) if ground.passable => {
                    self.is_hopper_there(mission, number, steps).then_some(Standing::Done)
                }
                _ => Some(Standing::Stranded),
            },
            _ => self.has_arrived(number).then_some(Standing::Done),
        };
        let end = end
            .or(gives_up.then(|| gave_up(&scout.robot.vehicle)))
            .filter(|_| scout.standing == Standing::Active);
        let standing = end.unwrap_or(scout.standing);
        let closes = !matches!(scout.robot.vehicle, Vehicle::Rover { .. } | Vehicle::Helicopter { .. });
        let scout = &mut self.scouts.scouts[number];
        // Who acts no more waits for nobody.
        (scout.standing, scout.waits) = (standing, scout.waits && standing == Standing::Active);
        if closes && standing != Standing::Active {
            self.close(mission);
            self.retire(mission);
        }
    }

    /// Whether a hopper is where it shall go, or has flown its patrol.
    fn is_hopper_there(&self, mission: &Mission, number: usize, steps: u64) -> bool {
        let (brief, scout) = (&mission.brief, &self.scouts.scouts[number]);
        match (scout.robot.vehicle, brief.patrol) {
            (Vehicle::HopperTo { goal }, _) => scout.cell == goal,
            (_, Some(patrol)) => scout.actions >= patrol.hops_max,
            (_, None) => scout.cell == brief.goal && steps <= brief.limits.steps_max,
        }
    }

    /// A robot on the ground stays where it is for good.
    fn close(&mut self, mission: &Mission) {
        let scouts = &self.scouts.scouts;
        let active = self.rovers.iter().map(|number| &scouts[*number]);
        let active: Vec<Cell> =
            active.filter(|scout| scout.standing == Standing::Active).map(|scout| scout.cell).collect();
        let closed = scouts.iter().filter(|scout| match scout.robot.vehicle {
            Vehicle::Helicopter { .. } => false,
            Vehicle::Rover { .. } => scout.standing == Standing::Stranded,
            _ => scout.standing != Standing::Active,
        });
        let closed: Vec<Cell> = closed.map(|scout| scout.cell).collect();
        if let Some(covered) = &mut self.covered {
            covered.close(mission, &active, &closed);
        }
    }

    /// Whether a rover is within reach of its goal and has no further point to go to.
    fn has_arrived(&self, number: usize) -> bool {
        let scout = &self.scouts.scouts[number];
        let Vehicle::Driver { goal, goal_radius_m, .. } = scout.robot.vehicle else { return false };
        let away_m = point(scout.at).distance_m(point(goal));
        away_m <= goal_radius_m + TOLERANCE_M && scout.next().is_none()
    }

    /// How the mission stands: by the tasks of the robots that it needs.
    pub fn status(&self, mission: &Mission, steps: u64) -> Status {
        let needed = (0..self.headings.len()).filter(|number| self.required.has(RobotId(*number as u16)));
        let tasks: Vec<Task> = needed.map(|number| self.task(mission, number)).collect();
        let failed = tasks.iter().find_map(|task| match task {
            Task::Failed(status) => Some(*status),
            _ => None,
        });
        let can_go_on = self.scouts.next().is_some_and(|due| {
            let scout = &self.scouts.scouts[due];
            let is_spent = scout.actions - scout.waited >= self.scouts.actions_max;
            let is_out_of_steps = if mission.brief.is_of_hopper() {
                mission.brief.patrol.is_none() && steps >= mission.brief.limits.steps_max
            } else {
                is_spent && self.required.has(RobotId(due as u16))
            };
            !is_out_of_steps
        });
        match failed {
            Some(status) => status,
            None if tasks.iter().all(|task| *task == Task::Done) => Status::Goal,
            None if can_go_on => Status::Underway,
            None => Status::Deadlock,
        }
    }

    fn task(&self, mission: &Mission, number: usize) -> Task {
        let scout = &self.scouts.scouts[number];
        match scout.robot.vehicle {
            Vehicle::Rover { .. } => match &self.covered {
                Some(covered) if covered.is_all_covered(mission) => Task::Done,
                _ if self.is_covering() => Task::Open,
                _ => Task::Failed(Status::Lost),
            },
            Vehicle::Hopper | Vehicle::HopperTo { .. } => match (scout.standing, scout.robot.vehicle) {
                _ if mission.terrain.ground(scout.cell).is_none() => Task::Failed(Status::LeftMap),
                (Standing::Stranded, _) => Task::Failed(Status::Lost),
                (Standing::Done, _) => Task::Done,
                (Standing::Active, Vehicle::HopperTo { goal }) if self.is_taken_for_good(number, goal) => {
                    Task::Failed(Status::Deadlock)
                }
                _ => Task::Open,
            },
            _ => match scout.standing {
                Standing::Stranded => Task::Failed(Status::Lost),
                Standing::GaveUp => Task::Failed(Status::Deadlock),
                Standing::Done => Task::Done,
                Standing::Active => Task::Open,
            },
        }
    }

    /// Who commands a robot.
    pub fn leader(&self, robot: RobotId) -> Leader {
        self.scouts.leader(robot)
    }

    /// The message about all robots as of the state of `decision` with `digest`.
    pub fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        let mut team = self.scouts.team(run, decision, digest);
        let members = Arc::make_mut(&mut team.members);
        for (member, heading) in members.iter_mut().zip(&self.headings) {
            member.at.heading = *heading;
        }
        team
    }
}

/// Where hoppers go, which rovers that cover ground keep off.
fn goals_of_hoppers(mission: &Mission) -> Vec<Cell> {
    let robots = mission.fleet.iter().flat_map(|fleet| &fleet.robots);
    let goal = |robot: &Robot| match robot.vehicle {
        Vehicle::HopperTo { goal } => Some(goal),
        _ => None,
    };
    robots.filter_map(goal).collect()
}

/// Whether rovers that cover ground are all robots of the mission, whose map tells the truth of what they see.
fn covers_only(brief: &Brief) -> bool {
    brief.cover.is_some() && brief.mixed.is_none()
}

/// How far such a rover sees from a cell, in columns and rows.
fn view(robot: &Robot, cell: Cell) -> (i32, Cell) {
    match robot.sensor {
        Sensor::Square { range_cells } => (range_cells as i32, cell),
        _ => (0, cell),
    }
}
