//! The robot of missions that test the protocol alone: it hops on flat ground, and every hop lands where it is meant to. So what is
//! wrong in such a mission is wrong in commands, turns, messages or the journal.

use std::sync::Arc;

use contract::{
    Action, Branch, Cell, Collected, Decision, Digest, Flight, Goal, Ground, Leader, Member, Origin, Outcome,
    Placement, Pose, Record, RobotId, RunId, Standing, State, Status, Team, Vetoed, Waypoint,
};
use hopper_sim::Mission;
use hopper_sim::dynamics::Execution;
use planner::Situation;

use crate::expected::{Expected, Shown, disc};
use crate::model::{Counter, Follows, Model, Way};
use crate::routes::Routes;
use crate::setup::Missions;

const HOPPER: RobotId = RobotId(0);

/// A hopper alone after some decisions, none of which has surprised it.
#[derive(Clone, Debug)]
pub(crate) struct TestingModel {
    mission: Arc<Mission>,
    cell: Cell,
    leader: Leader,
    last: Option<Decision>,
    shown: Vec<Shown>,
    /// What rogues have published: it follows none.
    routes: Routes,
}

impl TestingModel {
    /// Before the first decision.
    pub fn begin(mission: &Mission) -> Self {
        let mut begun = Self {
            cell: mission.brief.robots[0].start.cell,
            leader: Leader::default(),
            last: None,
            shown: vec![Shown::Nothing; mission.brief.grid.cells()],
            routes: Routes::none(mission.brief.run),
            mission: mission.clone().into(),
        };
        begun.look_around();
        begun
    }

    fn pose(&self) -> Pose {
        Pose { cell: self.cell, height_m: 0.0 }
    }

    fn look_around(&mut self) {
        let brief = &self.mission.brief;
        let (_, sensor) = brief.robots[0].as_hopper().expect("protocol missions have a hopper");
        disc(brief, sensor, self.pose()).for_each(|index| self.shown[index] = Shown::Truth);
    }

    /// The cell to which it is to go after so many visits.
    fn goal(&self, visits: u64) -> Cell {
        self.mission.brief.robots[0].goal.cell(&self.mission.brief.grid, visits).expect("it goes to cells")
    }

    /// How the mission stands after decision `decision`, which has brought it to `at`.
    fn status(&self, decision: Decision, at: Cell, steps: u64) -> Status {
        let brief = &self.mission.brief;
        match brief.robots[0].goal {
            _ if !brief.grid.contains(at) => Status::LeftMap,
            Goal::Visit(visit) if decision.0 + 1 >= visit.hops_max => Status::Goal,
            Goal::Visit(_) => Status::Underway,
            _ if at == self.goal(0) && steps <= brief.limits.steps_max => Status::Goal,
            _ if steps >= brief.limits.steps_max => Status::Deadlock,
            _ => Status::Underway,
        }
    }
}

impl Model for TestingModel {
    fn anew(&self, mission: &Mission) -> Self {
        Self { routes: self.routes.anew(mission.brief.run), ..Self::begin(mission) }
    }

    fn committed(&mut self, record: &Record) {
        (self.cell, self.leader, self.last) = (record.outcome.to, record.leader, Some(record.decision));
        self.look_around();
    }

    fn due(&self) -> RobotId {
        HOPPER
    }

    fn is_all_waiting(&self) -> bool {
        false
    }

    fn leader(&self, robot: RobotId) -> Leader {
        if robot == HOPPER { self.leader } else { Leader::default() }
    }

    /// Nobody publishes it of a hopper alone.
    fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        let at = Placement { cell: self.cell, ..self.mission.brief.robots[0].start };
        let member = Member {
            at,
            ready_at_ns: 0,
            standing: Standing::Active,
            waits: false,
            leader: self.leader,
            last: self.last,
            travel: None,
        };
        Team {
            run,
            decision,
            digest,
            due: HOPPER,
            actor: self.last.map(|_| HOPPER),
            members: [member].into(),
        }
    }

    fn lasts_ns(&self, outcome: &Outcome) -> u64 {
        (outcome.flight.flight_time_s * f64::from(outcome.flight.flights) * 1e9).round() as u64
    }

    fn execute(&self, before: &State, action: Action) -> Option<(RobotId, Execution)> {
        let (from, brief) = (self.cell, &self.mission.brief);
        let (outcome, took) = match action {
            Action::Hop(direction) => {
                let (motion, _) = brief.robots[0].as_hopper()?;
                let flight = motion::flight(motion, &brief.grid, contract::Soil::Hard, 0.0);
                (Outcome { branch: Branch::Intended, from, to: brief.grid.hop(from, direction), flight }, 2)
            }
            Action::Hold => (Outcome { branch: Branch::Held, from, to: from, flight: Flight::default() }, 1),
            _ => return None,
        };
        let (to, steps) = (outcome.to, before.steps + took);
        let execution = Execution {
            outcome,
            pose: Pose { cell: to, height_m: 0.0 },
            collected: Collected::default(),
            steps,
            visits: before.visits + u64::from(to == self.goal(before.visits)),
            status: self.status(before.decision, to, steps),
        };
        Some((HOPPER, execution))
    }

    fn blocked(&self) -> Vetoed {
        Vetoed::NONE
    }

    fn blocked_action(&self) -> Option<Action> {
        None
    }

    /// Off the map it is lost for certain.
    fn vetoed(&self, _known: &[Option<Ground>]) -> Vetoed {
        let grid = &self.mission.brief.grid;
        let is_lost = |action: &Action| match action {
            Action::Hop(direction) => !grid.contains(grid.hop(self.cell, *direction)),
            _ => false,
        };
        Action::ALL.into_iter().filter(is_lost).fold(Vetoed::NONE, Vetoed::with)
    }

    fn fallback(&self, _known: &[Option<Ground>], _vetoed: Vetoed) -> Option<(Action, Origin)> {
        None
    }

    fn follows(&self, _robot: RobotId) -> Follows {
        Follows::Policy
    }

    fn see(&self, _record: Option<&Record>, expected: &mut Expected) {
        let Mission { brief, terrain, .. } = &*self.mission;
        expected.reveal(brief, terrain, &self.shown);
        expected.land(brief, self.pose());
    }

    fn closed(&self, _situation: &Situation<'_>) -> Vec<usize> {
        Vec::new()
    }

    fn way(&self, visits: u64) -> Option<Way> {
        let (motion, sensor) = self.mission.brief.robots[0].as_hopper()?;
        let start = self.mission.brief.robots[0].start.cell;
        let start = visits.checked_sub(1).map_or(start, |before| self.goal(before));
        Some(Way { start, goal: self.goal(visits), motion: *motion, sensor: *sensor, pose: self.pose() })
    }

    fn is_on_route(&self, _robot: RobotId) -> bool {
        true
    }

    fn routes(&self) -> &Routes {
        &self.routes
    }

    fn routes_mut(&mut self) -> &mut Routes {
        &mut self.routes
    }

    fn along_route(&self) -> Option<Action> {
        None
    }

    fn at(&self) -> Waypoint {
        self.mission.brief.robots[0].start_at
    }

    fn others_at(&self) -> Vec<Cell> {
        Vec::new()
    }

    fn budget_left_m(&self) -> Option<f64> {
        None
    }

    fn foreign_action(&self) -> Action {
        Action::Fly
    }

    fn events(&self, _missions: Missions, _record: &Record, _before: &[Record]) -> Vec<Counter> {
        Vec::new()
    }
}
