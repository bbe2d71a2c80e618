//! The model of a simulation: the one place that knows which there are.

use contract::{
    Action, Cell, Decision, Digest, Ground, Leader, Origin, Outcome, Record, RobotId, RunId, State, Team,
    Vetoed, Waypoint,
};
use hopper_sim::Mission;
use hopper_sim::dynamics::Execution;
use planner::Situation;

use crate::expected::Expected;
use crate::model::{Counter, Follows, Model, Way};
use crate::oracle::Oracle;
use crate::routes::Routes;
use crate::setup::{Missions, Setup};
use crate::testing_model::TestingModel;

/// The model of a simulation. One type holds either, so that work loops and ports are compiled once.
#[derive(Clone, Debug)]
pub(crate) enum Chosen {
    /// Robots of every body.
    Oracle(Oracle),
    /// The robot of the missions that test the protocol alone.
    Testing(TestingModel),
}

impl Chosen {
    /// The model of the missions of `setup`, before its first decision.
    pub fn of(setup: &Setup) -> Self {
        match setup.missions {
            Missions::Protocol => Chosen::Testing(TestingModel::begin(&setup.mission)),
            Missions::Hopper
            | Missions::Rovers
            | Missions::Scouts
            | Missions::Accompanied
            | Missions::Mixed => Chosen::Oracle(Oracle::begin(&setup.mission)),
        }
    }
}

/// Asks whichever model was chosen.
macro_rules! ask {
    ($chosen:expr, $model:ident => $asked:expr) => {
        match $chosen {
            Chosen::Oracle($model) => $asked,
            Chosen::Testing($model) => $asked,
        }
    };
}

impl Model for Chosen {
    fn anew(&self, mission: &Mission) -> Self {
        match self {
            Chosen::Oracle(model) => Chosen::Oracle(model.anew(mission)),
            Chosen::Testing(model) => Chosen::Testing(model.anew(mission)),
        }
    }

    fn committed(&mut self, record: &Record) {
        ask!(self, model => model.committed(record));
    }

    fn due(&self) -> RobotId {
        ask!(self, model => model.due())
    }

    fn is_all_waiting(&self) -> bool {
        ask!(self, model => model.is_all_waiting())
    }

    fn leader(&self, robot: RobotId) -> Leader {
        ask!(self, model => model.leader(robot))
    }

    fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        ask!(self, model => model.team(run, decision, digest))
    }

    fn lasts_ns(&self, outcome: &Outcome) -> u64 {
        ask!(self, model => model.lasts_ns(outcome))
    }

    fn execute(&self, before: &State, action: Action) -> Option<(RobotId, Execution)> {
        ask!(self, model => model.execute(before, action))
    }

    fn blocked(&self) -> Vetoed {
        ask!(self, model => model.blocked())
    }

    fn blocked_action(&self) -> Option<Action> {
        ask!(self, model => model.blocked_action())
    }

    fn vetoed(&self, known: &[Option<Ground>]) -> Vetoed {
        ask!(self, model => model.vetoed(known))
    }

    fn fallback(&self, known: &[Option<Ground>], vetoed: Vetoed) -> Option<(Action, Origin)> {
        ask!(self, model => model.fallback(known, vetoed))
    }

    fn follows(&self, robot: RobotId) -> Follows {
        ask!(self, model => model.follows(robot))
    }

    fn see(&self, record: Option<&Record>, expected: &mut Expected) {
        ask!(self, model => model.see(record, expected));
    }

    fn closed(&self, situation: &Situation<'_>) -> Vec<usize> {
        ask!(self, model => model.closed(situation))
    }

    fn way(&self, visits: u64) -> Option<Way> {
        ask!(self, model => model.way(visits))
    }

    fn is_on_route(&self, robot: RobotId) -> bool {
        ask!(self, model => model.is_on_route(robot))
    }

    fn routes(&self) -> &Routes {
        ask!(self, model => model.routes())
    }

    fn routes_mut(&mut self) -> &mut Routes {
        ask!(self, model => model.routes_mut())
    }

    fn along_route(&self) -> Option<Action> {
        ask!(self, model => model.along_route())
    }

    fn at(&self) -> Waypoint {
        ask!(self, model => model.at())
    }

    fn others_at(&self) -> Vec<Cell> {
        ask!(self, model => model.others_at())
    }

    fn budget_left_m(&self) -> Option<f64> {
        ask!(self, model => model.budget_left_m())
    }

    fn foreign_action(&self) -> Action {
        ask!(self, model => model.foreign_action())
    }

    fn events(&self, missions: Missions, record: &Record, before: &[Record]) -> Vec<Counter> {
        ask!(self, model => model.events(missions, record, before))
    }
}
