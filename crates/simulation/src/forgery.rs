//! Commands that no planner of the mission would send.

use crate::fault::Forgery;
use crate::model::Model;
use crate::setup;
use crate::world::World;
use contract::{
    Action, Announcement, Command, Decision, Digest, Heartbeat, Incarnation, Refusal, RobotId, RobotSet,
    Role, Route, RouteId, RunId, Status, Term, Waypoint,
};

/// Sends hopper-sim a command of a rogue that is wrong in that way, if there can be one now.
// Long: a message for each forgery.
pub(crate) fn forge(world: &mut World, forgery: Forgery) {
    let Some(command) = world.commanded else { return };
    let robot = world.checker.due();
    let listening = world.listening::<Command>(robot);
    let Some((sim, wakes, queue)) = listening.into_iter().find(|(life, ..)| life.role == Role::HopperSim)
    else {
        return;
    };
    let rogue = Incarnation(u64::MAX);
    let checker = &world.checker;
    let (run, due, held) =
        (checker.mission().brief.run, checker.records().len() as u64, checker.leader().term);
    let digest = checker.digest();
    let count = checker.mission().brief.robots.count();
    let other = RobotId((robot.0 + 1) % count);
    let forged = Command {
        run,
        robot,
        decision: Decision(due),
        digest,
        term: held.next(),
        incarnation: rogue,
        ..command
    };
    let mut route = None;
    let message = match forgery {
        Forgery::Run => Ok(Command { run: RunId(run.0 ^ 1), ..forged }),
        Forgery::Robot => Ok(Command { robot: RobotId(7), ..forged }),
        // A robot alone is always due.
        Forgery::NotDue if other == robot => return,
        Forgery::NotDue => Ok(Command { robot: other, term: checker.leader_of(other).term.next(), ..forged }),
        Forgery::Blocked => match checker.blocked_action() {
            Some(action) => Ok(Command { action, ..forged }),
            None => return,
        },
        Forgery::TermOfAnother if checker.leader_of(other).term == held => return,
        Forgery::TermOfAnother => Ok(Command { term: checker.leader_of(other).term.next(), ..forged }),
        Forgery::Repeated if due == 0 => return,
        Forgery::Repeated => Ok(Command { decision: Decision(due - 1), ..forged }),
        Forgery::Future => Ok(Command { decision: Decision(due + 1_000), ..forged }),
        Forgery::Past => Ok(Command { digest: Digest([9; 32]), ..forged }),
        Forgery::Leap => Ok(Command { term: Term(held.0 + 1_000), ..forged }),
        Forgery::Stale | Forgery::Usurped if held == Term(0) => return,
        Forgery::Stale => Ok(Command { term: Term(held.0 - 1), ..forged }),
        Forgery::Usurped => Ok(Command { term: held, ..forged }),
        Forgery::Malformed => Err(Refusal::malformed("action", "0 to 4", 9)),
        Forgery::Kind | Forgery::UnknownRoute | Forgery::RouteElsewhere | Forgery::BeyondBudget => {
            match forged_route(checker.model(), forgery) {
                Some((action, points)) => {
                    route = points;
                    Ok(Command { action, ..forged })
                }
                None => return,
            }
        }
    };
    world.coverage.count("forged", forgery.as_str());
    // It beats, or nobody would obey it.
    let beat = Heartbeat {
        role: Role::Planner,
        incarnation: rogue,
        pid: 1,
        version: setup::version(),
        planner: command.planner,
        counter: 1,
        run,
        decision: Decision(due),
        status: Status::Underway,
        robots: RobotSet::NONE,
    };
    let hears = world.listening::<Heartbeat>(RobotId(0));
    if let Some((sim, wakes, queue)) = hears.into_iter().find(|(life, ..)| life.role == Role::HopperSim) {
        world.send(rogue, &sim, wakes, &queue, Ok(beat));
    }
    let listening = world.listening::<Announcement>(robot);
    let reader = listening.into_iter().find(|(life, ..)| life.role == Role::HopperSim);
    if let (Some(route), Some((sim, wakes, queue))) = (route, reader) {
        world.send(rogue, &sim, wakes, &queue, Ok(Announcement { run, robot, route }));
    }
    world.send(rogue, &sim, wakes, &queue, message);
}

/// An action that the robot that is due must not take, and the points of the route that it names.
fn forged_route(model: &dyn Model, forgery: Forgery) -> Option<(Action, Option<Route>)> {
    let at = model.at();
    let route = |points: Vec<Waypoint>| {
        let route = Route::new(points).ok()?;
        Some((Action::Announce(route.id()), Some(route)))
    };
    match forgery {
        Forgery::Kind => Some((model.foreign_action(), None)),
        Forgery::UnknownRoute => Some((Action::Announce(RouteId(9)), None)),
        Forgery::RouteElsewhere => {
            let x_m = if at.x_m > 2.0 { at.x_m - 1.0 } else { at.x_m + 1.0 };
            route(vec![Waypoint { x_m, ..at }, at])
        }
        Forgery::BeyondBudget => {
            let there = Waypoint { x_m: if at.x_m > 5.0 { at.x_m - 4.0 } else { at.x_m + 4.0 }, ..at };
            let legs = (model.budget_left_m()? / 4.0) as usize + 1;
            route((0..=legs).map(|leg| if leg % 2 == 0 { at } else { there }).collect())
        }
        _ => None,
    }
}
