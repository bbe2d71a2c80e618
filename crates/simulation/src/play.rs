//! Commands that nobody sends, given to a copy of the arbiter: what robots could be told to do is compared with what they may do,
//! and what would come of it with what should. So robots are led where no planner leads them, such as onto one that is at rest.

use contract::{
    Action, Announcement, Command, Decision, Incarnation, MonotonicNs, Record, RobotId, Route, RunId, State,
    Term, Waypoint,
};
use hopper_sim::{Arbiter, Effect, Event, Execution, Mission};

use crate::chance::Chance;
use crate::coverage::Coverage;
use crate::model::Model;
use crate::violation::Violation;

/// Decisions that are played at most.
const DECISIONS_MAX: usize = 12;

/// Times that the arbiter is woken at most until an action has landed.
const WAKES_MAX: usize = 64;

/// Who sends these commands.
const NOBODY: Incarnation = Incarnation(u64::MAX - 1);

/// A copy of the arbiter, and the robots as they should be.
pub(crate) struct Play<'a> {
    mission: &'a Mission,
    run: RunId,
    arbiter: Arbiter,
    model: Box<dyn Model>,
    chance: Chance,
    now: MonotonicNs,
}

/// What the arbiter makes of a command.
enum Answer {
    Executed(Box<Record>),
    Refused(&'static str),
}

impl<'a> Play<'a> {
    /// Begins where the mission stands.
    pub fn new(
        mission: &'a Mission,
        arbiter: &Arbiter,
        model: Box<dyn Model>,
        chance: Chance,
        now: MonotonicNs,
    ) -> Self {
        Self { mission, run: mission.brief.run, arbiter: arbiter.clone(), model, chance, now }
    }

    /// Plays some decisions; the first promise that would be broken, if one would.
    pub fn run(mut self, coverage: &mut Coverage) -> Option<Violation> {
        for _ in 0..DECISIONS_MAX {
            let state = *self.arbiter.state();
            if state.status.is_over() {
                return None;
            }
            match self.decide(&state, coverage) {
                Err(violation) => return Some(violation),
                Ok(false) => return None,
                Ok(true) => {}
            }
        }
        None
    }

    /// Has the robot that is due do something; whether the mission may go on.
    fn decide(&mut self, state: &State, coverage: &mut Coverage) -> Result<bool, Violation> {
        let robot = self.model.due();
        let (action, route) = self.action();
        if let Some(route) = route {
            let announcement = Announcement { run: self.run, robot, route };
            self.model.routes_mut().publish(&announcement);
            self.arbiter.on(Event::Announcement(Ok(announcement)), self.now);
        }
        let is_blocked = self.model.blocked().has(action);
        if is_blocked {
            coverage.count("play", if action == Action::Drive { "drive_blocked" } else { "blocked" });
        }
        let need = if is_blocked { None } else { self.model.execute(state, action) };
        let answer = self.command(robot, action, state);
        let violation = |rule, what: String| {
            let decision = state.decision;
            Err(Violation {
                rule,
                detail: format!("told to {action} at decision {decision}, robot {robot} {what}"),
            })
        };
        match (answer, need) {
            // Another planner's turn is kept, or nothing can be executed now.
            (Answer::Refused("yielding" | "busy"), _) => Ok(false),
            // How dangerous a hop is depends on what would have been seen.
            (Answer::Refused("vetoed"), Some(_)) if action.hop().is_some() => Ok(true),
            (Answer::Refused(_), None) => Ok(true),
            (Answer::Refused(reason), Some(_)) => violation(
                "every command that nothing speaks against is executed",
                format!("would be refused: {reason}"),
            ),
            (Answer::Executed(_), None) => {
                violation("what a robot may not do is refused", "would do so".into())
            }
            (Answer::Executed(record), Some(need)) => {
                coverage.count("play", "executed");
                let got = execution(&record);
                if need != got {
                    return violation(
                        "the outcome depends on seed, robot and decision alone",
                        format!("would end as {got:?}, needs {need:?}"),
                    );
                }
                self.model.committed(&record);
                if !self.land(record.decision.next()) {
                    return Ok(false);
                }
                let state = self.arbiter.state();
                let team = self.model.team(self.run, state.decision, state.digest);
                if self.arbiter.team().is_some_and(|told| *told != team) {
                    let got = self.arbiter.team();
                    return violation(
                        "the robots are where the journal leaves them",
                        format!("would leave {got:?}, needs {team:?}"),
                    );
                }
                Ok(true)
            }
        }
    }

    /// What the robot that is due is told to do, with the route that it announces.
    fn action(&mut self) -> (Action, Option<Route>) {
        let blocked = self.model.blocked_action();
        if let Some(action) = blocked
            && self.chance.one_in(2)
        {
            return (action, None);
        }
        let along = self.model.along_route();
        match along {
            // Now and then anything, as a planner for robots of another kind would send it.
            _ if self.chance.one_in(8) => (self.chance.pick(&Action::ALL), None),
            Some(_) if self.chance.one_in(2) => match self.route() {
                Some(route) => (Action::Announce(route.id()), Some(route)),
                None => (Action::Hold, None),
            },
            Some(along) => (along, None),
            None => {
                let some = [&Action::ALL[..9], &[Action::Wait]].concat();
                (self.chance.pick(&some), None)
            }
        }
    }

    /// A route of one leg, best of all onto another robot: no planner would announce it.
    fn route(&mut self) -> Option<Route> {
        let (at, grid) = (self.model.at(), &self.mission.brief.grid);
        let mut cells = self.model.others_at();
        cells.retain(|cell| grid.contains(*cell));
        let to = if !cells.is_empty() && !self.chance.one_in(4) {
            Waypoint::middle_of(grid, self.chance.pick(&cells))
        } else {
            let away = |chance: &mut Chance| 3.0 * chance.unit() - 1.5;
            Waypoint { x_m: at.x_m + away(&mut self.chance), y_m: at.y_m + away(&mut self.chance) }
        };
        Route::new(vec![at, to]).ok()
    }

    fn command(&mut self, robot: RobotId, action: Action, state: &State) -> Answer {
        let leader = self.model.leader(robot);
        let term = if leader.incarnation == NOBODY { leader.term } else { Term(leader.term.0 + 1) };
        let command = Command {
            run: self.run,
            robot,
            decision: state.decision,
            digest: state.digest,
            term,
            action,
            observation: 0,
            planner: "hold".parse().expect("a name"),
            incarnation: NOBODY,
            pid: 1,
            work: 0,
            cut: false,
            sensed: self.now,
            map_published: self.now,
            planning_started: self.now,
            planning_ended: self.now,
        };
        let effects = self.arbiter.on(Event::Command(Ok(command)), self.now);
        let answer = effects.into_iter().find_map(|effect| match effect {
            Effect::Append(record) => Some(Answer::Executed(Box::new(record))),
            Effect::Refused(refusal) => Some(Answer::Refused(refusal.reason())),
            _ => None,
        });
        answer.unwrap_or(Answer::Refused("unanswered"))
    }

    /// The journal takes the record, and time passes until its action has landed; whether it has.
    fn land(&mut self, due: Decision) -> bool {
        self.arbiter.on(Event::Appended, self.now);
        for _ in 0..WAKES_MAX {
            if self.arbiter.state().decision == due {
                return true;
            }
            let Some(wake) = self.arbiter.wake_at() else { return false };
            self.now = self.now.max(wake);
            self.arbiter.on(Event::Tick, self.now);
        }
        false
    }
}

fn execution(record: &Record) -> (RobotId, Execution) {
    let Record { robot, outcome, pose, detail, collected, steps, visits, status, .. } = *record;
    (robot, Execution { outcome, pose, detail, collected, steps, visits, status })
}
