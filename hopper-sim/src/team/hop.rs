//! A hopper, robot 0, with helicopters that look ahead for it.
//!
//! The hopper's actions are those of a hopper that is alone: the same guard, the same motion, draws
//! of the same law. Pose, steps,
//! visits and treasures of a state are the hopper's whoever acted, so its planner need not know of the helicopters. A hop
//! lasts as long as its flights, at least a second; helicopters announce routes and fly them as they do for a rover. The
//! mission ends with the hopper's, whose steps alone are limited.

use contract::{
    Action, Branch, Brief, Decision, Flight, Grid, Leader, Outcome, Placement, Record, Refusal, RobotId,
    Standing, State, Status, Waypoint,
};

use super::roster::{Roster, Turn};
use super::travels::Travels;
use super::turn_order::duration_ns;
use crate::dynamics::{Execution, execute_beside};
use crate::{Mission, ROBOT};

/// A hopper's helicopters: where each is on its route.
#[derive(Clone, Debug)]
pub struct HopTeam {
    travels: Travels,
    grid: Grid,
}

impl HopTeam {
    /// Before the first action.
    #[must_use]
    pub fn new(roster: &Roster, brief: &Brief) -> Self {
        let starts = roster.entries().map(|(_, entry)| entry.robot.vehicle.start());
        Self { travels: Travels::new(starts), grid: brief.grid }
    }

    /// How far the helicopters are on their routes.
    #[must_use]
    pub fn travels(&self) -> &Travels {
        &self.travels
    }

    /// The same, to add routes.
    pub fn travels_mut(&mut self) -> &mut Travels {
        &mut self.travels
    }

    /// Why the helicopter `robot`, which is due, shall not execute `action`, if there is a reason.
    #[must_use]
    pub fn refusal(&self, roster: &Roster, robot: RobotId, action: Action) -> Option<Refusal> {
        let vehicle = roster.entry(robot).robot.vehicle;
        let is_on_map = |at: Waypoint| self.grid.contains(at.cell_of(&self.grid));
        match action {
            Action::Announce(id) => self.travels.refusal_of_route(vehicle, robot, id, is_on_map),
            _ => self.travels.refusal_of_flight(vehicle, robot, action),
        }
    }

    /// Executes `action` of the helicopter `robot`, which was not refused, and takes note of it.
    pub fn execute_flight(
        &mut self,
        roster: &mut Roster,
        turn: (RobotId, Decision, Leader),
        action: Action,
    ) -> Outcome {
        let (robot, ..) = turn;
        self.travels.keep_announced(robot, action);
        self.fly(roster, turn, action)
    }

    /// Takes note of a decision of a helicopter in an earlier life, whose route, if it announced one, is recalled already.
    pub fn recall_flight(&mut self, roster: &mut Roster, record: &Record) {
        let Record { robot, decision, leader, action, .. } = record;
        self.fly(roster, (*robot, *decision, *leader), *action);
    }

    /// Executes `action`, which was not refused, of `robot`, which is due, and takes note of it.
    pub fn execute(
        &mut self,
        roster: &mut Roster,
        mission: &Mission,
        state: &State,
        robot: RobotId,
        leader: Leader,
        action: Action,
    ) -> Execution {
        let (decision, &State { pose, collected, steps, visits, status, .. }) = (state.decision, state);
        if robot != ROBOT {
            let outcome = self.execute_flight(roster, (robot, decision, leader), action);
            return Execution { outcome, pose, collected, steps, visits, status };
        }
        let execution = if roster.fails_now(ROBOT) {
            let from = pose.cell;
            let outcome = Outcome { branch: Branch::Stranded, from, to: from, flight: Flight::default() };
            Execution { outcome, pose, collected, steps, visits, status: Status::Lost }
        } else {
            execute_beside(mission, state, roster.actions(ROBOT), action)
        };
        take_hop(roster, (ROBOT, decision, leader), &execution.outcome);
        execution
    }

    /// Takes note of a decision of an earlier life, whose route, if it announced one, is recalled already.
    ///
    /// # Panics
    /// If another robot was due.
    pub fn recall(&mut self, roster: &mut Roster, record: &Record) {
        let Record { robot, decision, leader, outcome, .. } = record;
        if *robot == ROBOT {
            take_hop(roster, (ROBOT, *decision, *leader), outcome);
        } else {
            self.recall_flight(roster, record);
        }
    }

    fn fly(&mut self, roster: &mut Roster, turn: (RobotId, Decision, Leader), action: Action) -> Outcome {
        let (robot, ..) = turn;
        let arrival = self.travels.flight(roster, robot, action, |at| at.cell_of(&self.grid));
        let arrival = arrival.expect("all robots but the hopper go from point to point");
        self.travels.settle(roster, turn, action, &arrival);
        arrival.outcome
    }
}

/// Takes note of what a hop of the robot that is due has come to.
///
/// # Panics
/// If another robot is due.
pub fn take_hop(
    roster: &mut Roster,
    (robot, decision, leader): (RobotId, Decision, Leader),
    outcome: &Outcome,
) {
    let Flight { flight_time_s, flights, .. } = outcome.flight;
    roster.act(robot, decision, leader, Turn::Lasts(duration_ns(flight_time_s * f64::from(flights))));
    if outcome.branch == Branch::Stranded {
        roster.end(robot, Standing::Stranded);
    }
    let placement = Placement { cell: outcome.to, ..roster.entry(robot).at };
    roster.place(robot, placement);
}
