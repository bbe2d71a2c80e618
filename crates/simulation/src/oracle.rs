//! The robots of a mission as they should be, by code that shares nothing with the product's: whose turn it is, what an action
//! comes to, what is seen, what becomes of each robot, how the mission stands.
//!
//! Each body is one file in `oracle/body/`, behind [`body::Body`], each goal one in `oracle/goal/`, behind [`goal::Goal`]. Beside them
//! are turns, what all that go along routes have in common, covering, uncertain ground, and the parts of the mission with their ends.

use std::sync::Arc;

use contract::{
    Account, Action, Branch, Cell, Collected, Decision, DetailId, Digest, Ground, Leader, Origin, Outcome,
    Pose, Record, RobotId, RunId, State, Team, Vetoed, Waypoint,
};
use hopper_sim::{Execution, Mission};
use planner::Situation;

use crate::expected::{Expected, Shown, detail_id};
use crate::model::{Counter, Follows, Model, Way, duration_ns};
use crate::routes::Routes;
use crate::sensor;
use crate::setup::Missions;

use self::actor::Arrival;
use self::covering::Covering;
use self::turns::Turns;
use self::uncertain::Uncertain;

mod actor;
mod along;
mod body;
mod collision;
mod contact;
mod covering;
mod events;
mod goal;
mod parts;
mod turns;
mod uncertain;

/// The robots of a mission after some decisions.
#[derive(Clone, Debug)]
pub(crate) struct Oracle {
    mission: Arc<Mission>,
    turns: Turns,
    uncertain: Arc<Uncertain>,
    routes: Routes,
    /// What some robot has shown of each cell, in index order.
    shown: Vec<Shown>,
    /// The robots that cover ground.
    coverers: Vec<usize>,
    covering: Option<Covering>,
}

impl Oracle {
    /// Before the first decision.
    pub fn begin(mission: &Mission) -> Self {
        Self::with_routes(mission, Routes::none(mission.brief.run))
    }

    fn with_routes(mission: &Mission, routes: Routes) -> Self {
        let turns = Turns::begin_with(mission);
        let count = turns.actors.len();
        let coverers: Vec<usize> = (0..count).filter(|number| turns.actors[*number].covers()).collect();
        let starts = coverers.iter().map(|number| turns.actors[*number].cell).collect();
        let mut begun = Self {
            covering: Covering::begin(mission, starts, goals_of_hoppers(mission)),
            coverers,
            shown: vec![Shown::Nothing; mission.brief.grid.cells()],
            uncertain: Uncertain::of(mission).into(),
            turns,
            routes,
            mission: mission.clone().into(),
        };
        (0..count).for_each(|number| begun.look_around(number));
        begun.retire();
        (0..count).for_each(|number| begun.end_if_over(number, mission.brief.reading.opening_steps));
        begun
    }

    /// Whether the landings of a robot count, since it hops.
    fn hops(&self, robot: RobotId) -> bool {
        self.turns.actors.get(usize::from(robot.0)).is_some_and(|actor| actor.body().hops())
    }

    /// Whether a robot on the ground other than `number` is on a cell.
    fn is_occupied(&self, number: usize, cell: Cell) -> bool {
        let mut actors = self.turns.actors.iter().enumerate();
        actors.any(|(other, actor)| other != number && actor.body().is_on_ground() && actor.cell == cell)
            && self.mission.terrain.ground(cell).is_some()
    }

    /// Whether the robot of this number may do that.
    fn may(&self, number: usize, action: Action) -> bool {
        let body = self.turns.actors[number].body();
        body.may(self, number, action) && !self.blocked().has(action)
    }

    /// The cell that a robot which covers ground has entered by `record`.
    fn entered(&self, record: &Record) -> Option<Cell> {
        let covers = self.coverers.contains(&usize::from(record.robot.0));
        let has_moved = record.outcome.branch == Branch::Intended && matches!(record.action, Action::Step(_));
        (covers && has_moved).then_some(record.outcome.to)
    }

    /// The action of a robot has come to `outcome`. `steps` are those of the hopper, where the mission counts them.
    fn take(&mut self, number: usize, (decision, action): (Decision, Action), outcome: &Outcome, steps: u64) {
        if self.turns.actors[number].body().along_route().is_some() {
            along::take(self, number, decision, action);
        } else {
            if !self.mission.dynamics.is_law() {
                let detail = self.turns.actors[number].body().act(self, number, decision, action).detail;
                self.turns.actors[number].told = detail;
            }
            self.turns.take_in_cells(number, action, outcome);
        }
        let coverer = self.coverers.iter().position(|coverer| *coverer == number);
        let is_stranded = outcome.branch == Branch::Stranded;
        if let (Some(coverer), Some(covering), false) = (coverer, &mut self.covering, is_stranded) {
            covering.visit(&self.mission, coverer, outcome.to);
        }
        if coverer.is_some() && is_stranded {
            self.close();
        }
        self.look_around(number);
        self.retire();
        self.end_if_over(number, steps);
    }

    /// What a robot sees around it where it is; cameras and wheels show the way there alone.
    fn look_around(&mut self, number: usize) {
        let (brief, actor) = (&self.mission.brief, &self.turns.actors[number]);
        let cell = actor.cell;
        let Some(ground) = self.mission.terrain.ground(cell) else { return };
        let pose = Pose { cell, height_m: ground.height_m };
        let (sensor, errs) = (sensor::of(&actor.robot.sensor), actor.robot.sensor.accuracy().is_some());
        self.show(sensor.around(brief, pose), errs);
    }

    /// Some robot has shown these cells, by a camera that `errs` or by another sensor.
    fn show(&mut self, cells: Vec<usize>, errs: bool) {
        for cell in cells {
            self.shown[cell] = match (errs, self.shown[cell]) {
                (true, Shown::Nothing | Shown::Reading) => Shown::Reading,
                (true, Shown::Truth) | (false, _) => Shown::Truth,
            };
        }
    }

    /// What a robot reports of the cells around it where it is.
    fn report(&self, actor: &actor::Actor, expected: &mut Expected) {
        if let Some(ground) = self.mission.terrain.ground(actor.cell) {
            let pose = Pose { cell: actor.cell, height_m: ground.height_m };
            expected.report(&self.mission.brief, &actor.robot, pose);
        }
    }

    /// Pose, steps and visits that the state tells after `outcome` of `robot`. `steps` are those of the hopper that the mission is
    /// about, and `lands` is whether it or another has landed.
    fn account(
        &self,
        before: &State,
        robot: RobotId,
        outcome: &Outcome,
        lands: bool,
        steps: u64,
    ) -> (Pose, u64, u64) {
        let Mission { brief, terrain, .. } = &*self.mission;
        let ground = terrain.ground(outcome.to).or(terrain.ground(outcome.from));
        let pose = Pose { cell: outcome.to, height_m: ground.map_or(0.0, |ground| ground.height_m) };
        let goal = goal::of(&brief.robots[0].goal).cell(&brief.grid, before.visits);
        let is_visit = lands && goal == Some(outcome.to);
        let covered = self.covering.as_ref().map_or(0, Covering::visits);
        let actors = self.turns.actors.iter();
        match brief.account {
            Account::Hopper if self.hops(robot) => (pose, steps, before.visits + u64::from(is_visit)),
            Account::Hopper => (before.pose, steps, before.visits),
            // Only there to wait is a step.
            Account::Actions => (pose, actors.map(|actor| actor.actions).max().unwrap_or_default(), covered),
            Account::ActionsWithoutWaits => {
                (pose, actors.map(actor::Actor::spent).max().unwrap_or_default(), covered)
            }
        }
    }
}

impl Model for Oracle {
    fn copy(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }

    fn anew(&self, mission: &Mission) -> Box<dyn Model> {
        Box::new(Self::with_routes(mission, self.routes.anew(mission.brief.run)))
    }

    fn committed(&mut self, record: &Record) {
        let number = usize::from(record.robot.0);
        let Some(actor) = self.turns.actors.get_mut(number) else { return };
        (actor.leader, actor.last) = (record.leader, Some(record.decision));
        if !self.mission.brief.has_team() {
            // Those of earlier lives, which need not all be noted.
            actor.actions = record.decision.0;
        }
        self.routes.committed(record);
        self.take(number, (record.decision, record.action), &record.outcome, record.steps);
    }

    fn due(&self) -> RobotId {
        self.turns.due()
    }

    fn is_all_waiting(&self) -> bool {
        self.turns.is_all_waiting()
    }

    fn leader(&self, robot: RobotId) -> Leader {
        self.turns.actors.get(usize::from(robot.0)).map_or(Leader::default(), |actor| actor.leader)
    }

    fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        self.turns.team(run, decision, digest)
    }

    /// The whole action of a hopper alone.
    fn lasts_ns(&self, outcome: &Outcome) -> u64 {
        if self.mission.brief.has_team() { self.turns.lasts_ns() } else { duration_ns(outcome) }
    }

    fn execute(&self, before: &State, action: Action) -> Option<(RobotId, Execution)> {
        let due = self.turns.next()?;
        if !self.may(due, action) {
            return None;
        }
        let actor = &self.turns.actors[due];
        let Arrival { outcome, detail, .. } = actor.body().act(self, due, before.decision, action);
        let robot = RobotId(due as u16);
        // Who waits, fails or does not come to rest lands nowhere.
        let hops = actor.body().hops() && action != Action::Wait && outcome.branch != Branch::Stranded;
        let lands = hops && outcome.branch != Branch::RolledAway;
        let soil = self.mission.terrain.ground(outcome.from).map(|ground| ground.soil);
        let hopped = soil.map_or(0, |soil| motion::steps(soil, action, outcome.branch));
        let hopper_steps = before.steps + if hops { hopped } else { 0 };
        let mut after = self.clone();
        after.take(due, (before.decision, action), &outcome, hopper_steps);
        let found = self.mission.terrain.treasures.iter().position(|cell| lands && *cell == outcome.to);
        let (pose, steps, visits) = after.account(before, robot, &outcome, lands, hopper_steps);
        let execution = Execution {
            outcome,
            pose,
            detail: detail.map_or(DetailId::NONE, |detail| detail_id(&detail)),
            collected: Collected(before.collected.0 | found.map_or(0, |number| 1 << number)),
            steps,
            visits,
            status: after.status(hopper_steps),
        };
        Some((robot, execution))
    }

    /// Whatever ends where another robot is, a step to no ground to stand on, and a drive that may be a trap. What is dangerous to a
    /// hopper is not among it.
    fn blocked(&self) -> Vetoed {
        let Some(due) = self.turns.next() else { return Vetoed::NONE };
        let body = self.turns.actors[due].body();
        let blocked = Action::ALL.into_iter().filter(|action| body.is_blocked(self, due, *action));
        blocked.fold(Vetoed::NONE, Vetoed::with)
    }

    /// That onto the goal of a hopper if there is one, else that to another robot.
    fn blocked_action(&self) -> Option<Action> {
        let due = self.turns.next()?;
        let (blocked, actor) = (self.blocked(), &self.turns.actors[due]);
        let rank = |action: &Action| {
            let Some(to) = actor.body().step_to(actor.cell, *action) else { return 1 };
            let is_kept = goals_of_hoppers(&self.mission).contains(&to);
            if is_kept { 2 } else { usize::from(self.is_occupied(due, to)) }
        };
        Action::ALL.into_iter().filter(|action| blocked.has(*action)).max_by_key(rank)
    }

    fn vetoed(&self, known: &[Option<Ground>]) -> Vetoed {
        let Some(due) = self.turns.next() else { return Vetoed::NONE };
        self.blocked().union(self.turns.actors[due].body().dangerous(self, due, known))
    }

    fn fallback(&self, known: &[Option<Ground>], vetoed: Vetoed) -> Option<(Action, Origin)> {
        let due = self.turns.next()?;
        self.turns.actors[due].body().fallback(self, due, known, vetoed)
    }

    fn follows(&self, robot: RobotId) -> Follows {
        match self.mission.brief.account {
            Account::Hopper if robot == RobotId(0) => Follows::Policy,
            Account::Actions | Account::ActionsWithoutWaits if self.hops(robot) => Follows::Nothing,
            Account::Hopper | Account::Actions | Account::ActionsWithoutWaits => Follows::Route,
        }
    }

    /// Each start of a robot that covers ground is a visit.
    fn see(&self, record: Option<&Record>, expected: &mut Expected) {
        let Mission { brief, terrain, .. } = &*self.mission;
        let Some(record) = record else {
            let starts = self.coverers.iter().map(|number| self.turns.actors[*number].robot.start.cell);
            starts.for_each(|cell| expected.visit(brief, cell));
            self.turns.actors.iter().for_each(|actor| self.report(actor, expected));
            expected.reveal(brief, terrain, &self.shown);
            let cell = brief.robots[0].start.cell;
            if let (Account::Hopper, Some(ground)) = (brief.account, terrain.ground(cell)) {
                expected.land(brief, Pose { cell, height_m: ground.height_m });
            }
            return;
        };
        self.entered(record).into_iter().for_each(|cell| expected.visit(brief, cell));
        if let Some(actor) = self.turns.actors.get(usize::from(record.robot.0)) {
            self.report(actor, expected);
        }
        expected.reveal(brief, terrain, &self.shown);
        if !self.hops(record.robot) {
            return;
        }
        match brief.account {
            Account::Hopper => expected.land(brief, record.pose),
            Account::Actions | Account::ActionsWithoutWaits => expected.collect(record.pose.cell),
        }
    }

    /// Planners of hoppers alone take such cells for impassable. The hopper may share its own with a rover that is stuck there.
    fn closed(&self, situation: &Situation<'_>) -> Vec<usize> {
        let Some(team) = situation.team else { return Vec::new() };
        let robots = &situation.brief.robots;
        let (Some(due), Some(robot)) = (team.member(team.due), robots.at(team.due)) else {
            return Vec::new();
        };
        if !body::of(&robot.body).hops() {
            return Vec::new();
        }
        let others = robots.numbered().filter(|(robot, _)| *robot != team.due);
        let on_ground = others.filter(|(_, other)| body::of(&other.body).is_on_ground());
        let cells = on_ground.filter_map(|(robot, _)| Some(team.member(robot)?.at.cell));
        let cells = cells.filter(|cell| *cell != due.at.cell);
        cells.filter_map(|cell| situation.brief.grid.index(cell)).collect()
    }

    /// That of a hopper, whose visits are those of the state where the mission is about it alone.
    fn way(&self, visits: u64) -> Option<Way> {
        let Mission { brief, terrain, .. } = &*self.mission;
        let number = self.turns.next()?;
        let actor = &self.turns.actors[number];
        if !actor.body().hops() {
            return None;
        }
        let visits = if brief.account == Account::Hopper { visits } else { 0 };
        let (motion, sensor) = actor.robot.as_hopper().expect("a hopper has a disc in view");
        let ground = terrain.ground(actor.cell).expect("a hopper that can act stands on the map");
        Some(Way {
            start: actor.goal().last(visits).unwrap_or(actor.robot.start.cell),
            goal: actor.goal().cell_by(self, number, visits).expect("a hopper goes to cells"),
            motion: *motion,
            sensor: *sensor,
            pose: Pose { cell: actor.cell, height_m: ground.height_m },
        })
    }

    /// Beside a hopper the decisions of its helicopters are no part of its route.
    fn is_on_route(&self, robot: RobotId) -> bool {
        self.mission.brief.account != Account::Hopper || robot == RobotId(0)
    }

    fn routes(&self) -> &Routes {
        &self.routes
    }

    fn routes_mut(&mut self) -> &mut Routes {
        &mut self.routes
    }

    fn along_route(&self) -> Option<Action> {
        self.turns.actors[usize::from(self.due().0)].body().along_route()
    }

    fn at(&self) -> Waypoint {
        self.turns.actors[usize::from(self.due().0)].at
    }

    fn others_at(&self) -> Vec<Cell> {
        let due = usize::from(self.due().0);
        let others = self.turns.actors.iter().enumerate().filter(|(other, _)| *other != due);
        let on_ground = others.filter(|(_, actor)| actor.body().is_on_ground());
        on_ground.map(|(_, actor)| actor.cell).collect()
    }

    fn budget_left_m(&self) -> Option<f64> {
        let actor = &self.turns.actors[usize::from(self.due().0)];
        actor.body().budget_left_m(actor)
    }

    fn foreign_action(&self) -> Action {
        self.turns.actors[usize::from(self.due().0)].body().foreign_action()
    }

    fn events(&self, missions: Missions, record: &Record, before: &[Record]) -> Vec<Counter> {
        self.events_of(missions, record, before)
    }
}

/// Where hoppers go, which rovers that cover ground keep off.
fn goals_of_hoppers(mission: &Mission) -> Vec<Cell> {
    let contract::Brief { robots, grid, .. } = &mission.brief;
    let hoppers = robots.iter().filter(|robot| body::of(&robot.body).hops());
    hoppers.filter_map(|robot| goal::of(&robot.goal).cell(grid, 0)).collect()
}
