//! The robots of a mission as they should be, by code that shares nothing with the product's: whose turn it is, what an action
//! comes to, what becomes of each robot, how the mission stands. How robots go from point to point is asked of
//! [`crate::scouts`], what covering comes to of [`crate::covered`], and what a rover's step comes to of [`crate::rovers`];
//! where a hop leads is drawn here.

use contract::{
    Account, Action, Announcement, Body, Branch, Brief, Cell, Collected, Decision, Digest, Flight, Goal,
    Hopper, Leader, Origin, Outcome, Pose, Record, RobotId, RunId, Sensor, Standing, State, Status, Team,
    Vetoed,
};
use hopper_sim::Mission;
use hopper_sim::dynamics::Execution;
use motion::{Domain, Draw};
use terrain::Terrain;

use crate::covered::{Covered, is_free};
use crate::expected::{Expected, Shown, disc, goal_cell, square};
use crate::rovers::{self, beside};
use crate::scouts::{Scout, Scouts, TOLERANCE_M, gave_up, point};

/// The robots of a mission after some decisions.
#[derive(Clone, Debug)]
pub(crate) struct Robots {
    /// All robots; of those that go from cell to cell only what all have.
    scouts: Scouts,
    /// The robots that cover ground.
    rovers: Vec<usize>,
    covered: Option<Covered>,
}

/// How the goal of a robot stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Open,
    Done,
    Failed(Status),
}

impl Robots {
    /// Before the first decision.
    pub fn begin(mission: &Mission) -> Self {
        let scouts = Scouts::begin(mission);
        let covers = |number: &usize| matches!(scouts.scouts[*number].robot.goal, Goal::Cover(_));
        let count = scouts.scouts.len();
        let rovers: Vec<usize> = (0..count).filter(covers).collect();
        let starts = rovers.iter().map(|number| scouts.scouts[*number].cell).collect();
        let covered = Covered::begin(mission, starts, goals_of_hoppers(mission));
        let mut begun = Self { covered, rovers, scouts };
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
        self.rover_starts().for_each(|cell| expected.visit(brief, cell));
        expected.reveal(brief, terrain, self.scouts.shown());
        let cell = brief.robots[0].start.cell;
        if let (Account::Hopper, Some(ground)) = (brief.account, terrain.ground(cell)) {
            expected.land(brief, Pose { cell, height_m: ground.height_m });
        }
    }

    /// What is seen after `record`, which was committed.
    pub fn see(&self, brief: &Brief, terrain: &Terrain, record: &Record, expected: &mut Expected) {
        self.entered(record).into_iter().for_each(|cell| expected.visit(brief, cell));
        expected.reveal(brief, terrain, self.scouts.shown());
        if !self.scouts.is_hopper(record.robot) {
            return;
        }
        match brief.account {
            Account::Hopper => expected.land(brief, record.pose),
            Account::Actions | Account::ActionsWithoutWaits => expected.collect(record.pose.cell),
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

    /// The hopper that is due, if it is the turn of one.
    pub fn due_hopper(&self) -> Option<&Scout> {
        self.scouts.next().map(|number| &self.scouts.scouts[number]).filter(|scout| scout.robot.body.hops())
    }

    /// How a robot stands.
    pub fn standing(&self, robot: RobotId) -> Option<Standing> {
        self.scouts.scouts.get(usize::from(robot.0)).map(|scout| scout.standing)
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
        scouts.any(|(other, scout)| other != number && scout.robot.body.is_on_ground() && scout.cell == cell)
            && mission.terrain.ground(cell).is_some()
    }

    /// Whether a robot on the ground other than `number` has stopped on a cell for good.
    fn is_taken_for_good(&self, number: usize, cell: Cell) -> bool {
        let mut scouts = self.scouts.scouts.iter().enumerate();
        scouts.any(|(other, scout)| {
            let stops = scout.robot.body.is_on_ground() && scout.standing != Standing::Active;
            other != number && stops && scout.cell == cell
        })
    }

    /// What the robot that is due must not do: whatever ends where another is, a step to no ground to stand on, and a drive that
    /// may be a trap. What is dangerous to a hopper is not among it.
    pub fn blocked(&self, mission: &Mission) -> Vetoed {
        let Some(due) = self.scouts.next() else { return Vetoed::NONE };
        let scout = &self.scouts.scouts[due];
        let is_blocked = |action: &Action| match (scout.robot.body, action) {
            (Body::Hopper(_), Action::Hop(direction)) => {
                self.is_occupied(mission, due, mission.brief.grid.hop(scout.cell, *direction))
            }
            (Body::Rover(_), Action::Step(_)) => {
                let to = beside(scout.cell, *action);
                let is_kept = goals_of_hoppers(mission).contains(&to);
                !is_free(mission, to) || is_kept || self.is_occupied(mission, due, to)
            }
            (Body::Driver(_), Action::Drive) => {
                let is_taken = |to| self.is_occupied(mission, due, self.scouts.cell(to));
                self.scouts.blocked() != Vetoed::NONE || scout.next().is_some_and(is_taken)
            }
            (Body::Hopper(_) | Body::Rover(_) | Body::Driver(_) | Body::Helicopter(_), _) => false,
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
        let along =
            self.scouts.next().and_then(|due| Some((due, self.scouts.scouts[due].robot.body.along_route()?)));
        let along = along.filter(|(due, action)| self.may(mission, *due, *action));
        along.map_or((Action::Hold, Origin::Hold), |(_, action)| (action, Origin::Policy))
    }

    /// Whether the robot that is due may do that.
    fn may(&self, mission: &Mission, due: usize, action: Action) -> bool {
        // A hopper whose steps alone are counted has nobody to wait for.
        let may_wait = mission.brief.account != Account::Hopper;
        let suits_body = match self.scouts.scouts[due].robot.body {
            Body::Hopper(_) if action == Action::Wait => may_wait,
            Body::Hopper(_) => matches!(action, Action::Hold | Action::Hop(_)),
            Body::Rover(_) => matches!(action, Action::Hold | Action::Wait | Action::Step(_)),
            Body::Driver(_) | Body::Helicopter(_) => self.scouts.may(due, action),
        };
        suits_body && !self.blocked(mission).has(action)
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
        let goal = goal_cell(&brief.grid, &brief.robots[0], before.visits);
        let actions = |waits: bool| {
            let actions =
                after.scouts.scouts.iter().map(|scout| scout.actions - if waits { 0 } else { scout.waited });
            actions.max().unwrap_or_default()
        };
        let pose = Pose { cell: outcome.to, height_m };
        let covered = after.covered.as_ref().map_or(0, Covered::visits);
        let is_visit = lands && goal == Some(outcome.to);
        let (pose, steps, visits) = match brief.account {
            Account::Hopper if self.scouts.is_hopper(robot) => {
                (pose, hopper_steps, before.visits + u64::from(is_visit))
            }
            Account::Hopper => (before.pose, hopper_steps, before.visits),
            // Only there to wait is a step.
            Account::Actions => (pose, actions(true), covered),
            Account::ActionsWithoutWaits => (pose, actions(false), covered),
        };
        let execution = Execution {
            outcome,
            pose,
            collected: Collected(before.collected.0 | found.map_or(0, |number| 1 << number)),
            steps,
            visits,
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
        match scout.robot.body {
            Body::Hopper(hopper) => Some(self.hop(mission, number, hopper, decision, action)),
            Body::Rover(_) if action == Action::Wait && !fails => {
                let flight = Flight::default();
                Some(Outcome { branch: Branch::Held, from: scout.cell, to: scout.cell, flight })
            }
            Body::Rover(_) => rovers::outcome(mission, &scout.robot, scout.cell, action, fails),
            Body::Driver(_) | Body::Helicopter(_) => Some(self.scouts.arrival(number, action).outcome),
        }
    }

    /// A hop, drawn for this robot and decision: it ends where it began if another robot is where it would end.
    fn hop(
        &self,
        mission: &Mission,
        number: usize,
        Hopper { motion: law }: Hopper,
        decision: Decision,
        action: Action,
    ) -> Outcome {
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
        if number >= self.scouts.scouts.len() {
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
        match self.scouts.scouts[number].robot.body {
            Body::Hopper(_) | Body::Rover(_) => self.scouts.in_cells(number, action, outcome),
            Body::Driver(_) | Body::Helicopter(_) => self.scouts.act(number, decision, action),
        }
        let rover = self.rovers.iter().position(|rover| *rover == number);
        let is_stranded = outcome.branch == Branch::Stranded;
        if let (Some(rover), Some(covered), false) = (rover, &mut self.covered, is_stranded) {
            covered.visit(mission, rover, outcome.to);
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
            (Sensor::Disc(sensor), Some(ground)) => {
                let pose = Pose { cell, height_m: ground.height_m };
                disc(&mission.brief, &sensor, pose).for_each(|index| shown[index] = Shown::Truth);
            }
            (Sensor::Square(sensor), _) => square(&mission.brief, sensor.range_cells as i32, cell)
                .for_each(|index| shown[index] = Shown::Truth),
            (Sensor::Disc(_), None) | (Sensor::Track(_) | Sensor::Camera(_) | Sensor::ErringCamera(_), _) => {
            }
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
        let is_limited = mission.brief.account != Account::Hopper && !scout.robot.required;
        let stands = mission.terrain.ground(scout.cell).is_some_and(|ground| ground.passable);
        let end = if scout.robot.body.hops() && !stands {
            Some(Standing::Stranded)
        } else {
            self.is_at_goal(mission, number, steps).then_some(Standing::Done)
        };
        let gives_up = || (is_limited && is_spent).then(|| gave_up(&scout.robot));
        let end = end.or_else(gives_up).filter(|_| scout.standing == Standing::Active);
        let standing = end.unwrap_or(scout.standing);
        // Rovers that cover ground close their cell where they fail.
        let closes = scout.robot.body.is_on_ground() && !matches!(scout.robot.goal, Goal::Cover(_));
        let scout = &mut self.scouts.scouts[number];
        // Who acts no more waits for nobody.
        (scout.standing, scout.waits) = (standing, scout.waits && standing == Standing::Active);
        if closes && standing != Standing::Active {
            self.close(mission);
            self.retire(mission);
        }
    }

    /// Whether a robot is where it shall go and has no further point to go to, or has flown its hops. Who covers ground is done
    /// elsewhere.
    fn is_at_goal(&self, mission: &Mission, number: usize, steps: u64) -> bool {
        let (brief, scout) = (&mission.brief, &self.scouts.scouts[number]);
        match (scout.robot.goal, scout.robot.body) {
            (Goal::Reach(reach), Body::Driver(_) | Body::Helicopter(_)) => {
                let away_m = point(scout.at).distance_m(point(reach.at));
                away_m <= reach.radius_m + TOLERANCE_M && scout.next().is_none()
            }
            (Goal::Reach(_), Body::Hopper(_) | Body::Rover(_)) => {
                let in_time = brief.account != Account::Hopper || steps <= brief.limits.steps_max;
                goal_cell(&brief.grid, &scout.robot, 0) == Some(scout.cell) && in_time
            }
            (Goal::Visit(visit), _) => scout.actions >= visit.hops_max,
            (Goal::Cover(_) | Goal::LookAhead(_), _) => false,
        }
    }

    /// A robot on the ground stays where it is for good.
    fn close(&mut self, mission: &Mission) {
        let scouts = &self.scouts.scouts;
        let active = self.rovers.iter().map(|number| &scouts[*number]);
        let active: Vec<Cell> =
            active.filter(|scout| scout.standing == Standing::Active).map(|scout| scout.cell).collect();
        let on_ground = scouts.iter().filter(|scout| scout.robot.body.is_on_ground());
        let closed = on_ground.filter(|scout| match scout.robot.goal {
            Goal::Cover(_) => scout.standing == Standing::Stranded,
            Goal::Reach(_) | Goal::Visit(_) | Goal::LookAhead(_) => scout.standing != Standing::Active,
        });
        let closed: Vec<Cell> = closed.map(|scout| scout.cell).collect();
        if let Some(covered) = &mut self.covered {
            covered.close(mission, &active, &closed);
        }
    }

    /// How the mission stands: by the goals of the robots that it requires.
    pub fn status(&self, mission: &Mission, steps: u64) -> Status {
        let brief = &mission.brief;
        let scouts = &self.scouts.scouts;
        let required = (0..scouts.len()).filter(|number| scouts[*number].robot.required);
        let parts: Vec<Part> = required.map(|number| self.part(mission, number)).collect();
        let failed = parts.iter().find_map(|part| match part {
            Part::Failed(status) => Some(*status),
            Part::Open | Part::Done => None,
        });
        let can_go_on = self.scouts.next().is_some_and(|due| {
            let scout = &self.scouts.scouts[due];
            let is_spent = scout.actions - scout.waited >= self.scouts.actions_max;
            let is_out_of_steps = match brief.account {
                Account::Hopper => {
                    let visits_goals = matches!(brief.robots[0].goal, Goal::Visit(_));
                    !visits_goals && steps >= brief.limits.steps_max
                }
                Account::Actions | Account::ActionsWithoutWaits => is_spent && scout.robot.required,
            };
            !is_out_of_steps
        });
        match failed {
            Some(status) => status,
            None if parts.iter().all(|part| *part == Part::Done) => Status::Goal,
            None if can_go_on => Status::Underway,
            None => Status::Deadlock,
        }
    }

    /// How the goal of a robot stands.
    fn part(&self, mission: &Mission, number: usize) -> Part {
        let scout = &self.scouts.scouts[number];
        let hops = scout.robot.body.hops();
        if let (Goal::Cover(_), Some(covered)) = (scout.robot.goal, &self.covered) {
            return if covered.is_all_covered(mission) {
                Part::Done
            } else if self.is_covering() {
                Part::Open
            } else {
                Part::Failed(Status::Lost)
            };
        }
        if hops && mission.terrain.ground(scout.cell).is_none() {
            return Part::Failed(Status::LeftMap);
        }
        let goal = goal_cell(&mission.brief.grid, &scout.robot, 0);
        let is_taken = hops && goal.is_some_and(|goal| self.is_taken_for_good(number, goal));
        match scout.standing {
            Standing::Stranded => Part::Failed(Status::Lost),
            Standing::GaveUp => Part::Failed(Status::Deadlock),
            Standing::Done => Part::Done,
            Standing::Active if is_taken => Part::Failed(Status::Deadlock),
            Standing::Active => Part::Open,
        }
    }

    /// Who commands a robot.
    pub fn leader(&self, robot: RobotId) -> Leader {
        self.scouts.leader(robot)
    }

    /// The message about all robots as of the state of `decision` with `digest`.
    pub fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        self.scouts.team(run, decision, digest)
    }
}

/// Where hoppers go, which rovers that cover ground keep off.
fn goals_of_hoppers(mission: &Mission) -> Vec<Cell> {
    let Brief { robots, grid, .. } = &mission.brief;
    let hoppers = robots.iter().filter(|robot| robot.body.hops());
    hoppers.filter_map(|robot| goal_cell(grid, robot, 0)).collect()
}
