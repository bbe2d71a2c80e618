//! Executes one action on the true terrain with keyed draws (the motion law of P23 section IV).

use contract::{
    Action, Branch, Brief, Cell, Collected, Decision, Flight, Outcome, Pose, RobotId, State, Status,
};
use motion::{Domain, Draw};
use terrain::Terrain;

use crate::{Mission, ROBOT};

/// Where an executed action left the mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Execution {
    /// What became of the action.
    pub outcome: Outcome,
    /// Pose afterwards; outside the map it keeps the height of the departure.
    pub pose: Pose,
    /// Treasures collected so far, this landing's among them.
    pub collected: Collected,
    /// Steps afterwards, in the paper's count.
    pub steps: u64,
    /// Goals visited so far, this landing's among them.
    pub visits: u64,
    /// Status afterwards.
    pub status: Status,
}

/// Executes `action` from `state`.
///
/// The draw is keyed by (seed, domain, robot, decision) alone, so the same action at the same
/// decision has the same outcome however often and in whichever process it is executed.
///
/// # Panics
/// If `state` stands outside the terrain, as only a mission that is over can.
#[must_use]
pub fn execute(mission: &Mission, state: &State, action: Action) -> Execution {
    execute_beside(mission, state, state.decision.0, action)
}

/// Executes an action of a hopper that is not alone: it has acted `flown` times, and all other
/// decisions were those of others.
///
/// # Panics
/// As [`execute`].
#[must_use]
pub fn execute_beside(mission: &Mission, state: &State, flown: u64, action: Action) -> Execution {
    let Mission { brief, terrain, .. } = mission;
    let ground = terrain.ground(state.pose.cell).expect("a mission underway stands on its terrain");
    let outcome = outcome_of_hop(mission, ROBOT, state.decision, state.pose.cell, action);
    let height_m = terrain.ground(outcome.to).map_or(state.pose.height_m, |ground| ground.height_m);
    let steps = state.steps + motion::steps(ground.soil, action, outcome.branch);
    let visited = mission.brief.is_visit(state.visits, outcome.to);
    Execution {
        outcome,
        pose: Pose { cell: outcome.to, height_m },
        collected: state.collected.landing(&terrain.treasures, outcome.to),
        steps,
        visits: state.visits + u64::from(visited),
        status: status(brief, terrain, flown, outcome.to, steps),
    }
}

/// What becomes of `action` of the hopper `robot` on `from`, drawn for `decision`.
///
/// # Panics
/// As [`execute`].
#[must_use]
pub fn outcome_of_hop(
    mission: &Mission,
    robot: RobotId,
    decision: Decision,
    from: Cell,
    action: Action,
) -> Outcome {
    let Mission { brief, terrain, seed, .. } = mission;
    let ground = terrain.ground(from).expect("a mission underway stands on its terrain");
    match action {
        Action::Hop(direction) => {
            let uniform = Draw::new(*seed, Domain::Motion, robot, decision).uniform();
            let law = brief.motion_of(robot);
            let branch = motion::transition(law, ground, direction).branch(uniform);
            let target = terrain.ground(brief.grid.hop(from, direction));
            let rise_m = target.map_or(0.0, |target| target.height_m - ground.height_m);
            Outcome {
                branch,
                from,
                to: motion::landing(&brief.grid, from, direction, branch),
                flight: motion::flight(law, &brief.grid, ground.soil, rise_m),
            }
        }
        // The arbiter refuses all others: a hopper cannot drive.
        _ => Outcome { branch: Branch::Held, from, to: from, flight: Flight::default() },
    }
}

/// How the mission stands with the hopper on `cell` after `steps`. A patrol is flown once its hops are.
fn status(brief: &Brief, terrain: &Terrain, flown: u64, cell: Cell, steps: u64) -> Status {
    let ground = terrain.ground(cell);
    if let Some(patrol) = &brief.patrol {
        return match ground {
            None => Status::LeftMap,
            Some(ground) if !ground.passable => Status::Lost,
            Some(_) if flown + 1 >= patrol.hops_max => Status::Goal,
            Some(_) => Status::Underway,
        };
    }
    match ground {
        _ if cell == brief.goal && steps <= brief.limits.steps_max => Status::Goal,
        None => Status::LeftMap,
        Some(ground) if !ground.passable => Status::Lost,
        Some(_) if steps >= brief.limits.steps_max => Status::Deadlock,
        Some(_) => Status::Underway,
    }
}
