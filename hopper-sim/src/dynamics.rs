//! Executes one action on the true terrain with keyed draws (the motion law of P23 section IV).

use contract::{Action, Branch, Cell, Collected, Decision, Flight, Outcome, Pose, Robot, RobotId, Status};
use motion::{Domain, Draw};

use crate::Mission;

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

/// What becomes of `action` of the hopper `robot` on `from`, drawn for `decision`.
///
/// The draw is keyed by (seed, domain, robot, decision) alone, so the same action at the same decision has the same outcome
/// however often and in whichever process it is executed.
///
/// # Panics
/// If `from` lies outside the terrain, as only in a mission that is over, or the robot is no hopper.
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
            let hopper = brief.robots.at(robot).and_then(Robot::as_hopper);
            let (law, _) = hopper.expect("hops are those of a hopper");
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
