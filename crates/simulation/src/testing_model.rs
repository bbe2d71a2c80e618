//! The robot of missions that test the protocol alone: it hops on flat ground, and every hop lands where it is meant to. So what is
//! wrong in such a mission is wrong in commands, turns, messages or the journal.

use std::sync::Arc;

use contract::{
    Action, Branch, Cell, Collected, Decision, DetailId, Flight, Goal, Ground, Leader, Origin, Outcome, Pose,
    Record, RobotId, State, Status, Vetoed, Waypoint,
};
use hopper_sim::{Execution, Mission};

use crate::expected::{Expected, Shown};
use crate::model::{Follows, Model, Way};
use crate::routes::Routes;
use crate::sensor;

const HOPPER: RobotId = RobotId(0);

/// A hopper alone after some decisions, each of which came out as it was meant to.
#[derive(Clone, Debug)]
pub(crate) struct TestingModel {
    mission: Arc<Mission>,
    cell: Cell,
    leader: Leader,
    shown: Vec<Shown>,
    /// Published by planners that are not those of the mission; the hopper follows none.
    routes: Routes,
}

impl TestingModel {
    /// Before the first decision.
    pub fn begin(mission: &Mission) -> Self {
        let mut begun = Self {
            cell: mission.brief.robots[0].start.cell,
            leader: Leader::default(),
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
        let seen = sensor::of(&brief.robots[0].sensor).around(brief, self.pose());
        seen.into_iter().for_each(|index| self.shown[index] = Shown::Truth);
    }

    /// The cell to which it is to go after so many visits; cells are a metre wide.
    fn goal(&self, visits: u64) -> Cell {
        match self.mission.brief.robots[0].goal {
            Goal::Reach(reach) => Cell::new(reach.at.x_m as i32, reach.at.y_m as i32),
            Goal::Visit(visit) => visit.goals()[visits as usize % visit.goals().len()],
            _ => unreachable!("a hopper goes to cells"),
        }
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
    fn copy(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }

    fn anew(&self, mission: &Mission) -> Box<dyn Model> {
        Box::new(Self { routes: self.routes.anew(mission.brief.run), ..Self::begin(mission) })
    }

    fn committed(&mut self, record: &Record) {
        (self.cell, self.leader) = (record.outcome.to, record.leader);
        self.look_around();
    }

    fn leader(&self, robot: RobotId) -> Leader {
        if robot == HOPPER { self.leader } else { Leader::default() }
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
            detail: DetailId::NONE,
            collected: Collected::default(),
            steps,
            visits: before.visits + u64::from(to == self.goal(before.visits)),
            status: self.status(before.decision, to, steps),
        };
        Some((HOPPER, execution))
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

    fn way(&self, visits: u64) -> Option<Way> {
        let (motion, sensor) = self.mission.brief.robots[0].as_hopper()?;
        let start = self.mission.brief.robots[0].start.cell;
        let start = visits.checked_sub(1).map_or(start, |before| self.goal(before));
        Some(Way { start, goal: self.goal(visits), motion: *motion, sensor: *sensor, pose: self.pose() })
    }

    fn routes(&self) -> &Routes {
        &self.routes
    }

    fn routes_mut(&mut self) -> &mut Routes {
        &mut self.routes
    }

    fn at(&self) -> Waypoint {
        self.mission.brief.robots[0].start_at
    }
}
