//! Which planner commands which robot of a mission.

use contract::{Brief, Name, Robot};

use crate::built_in::{algorithm, suited, usual};
use crate::error::PlannerError;
use crate::names::{CLAIRVOYANT, name};

/// The planner of each robot of a mission, in the order of their numbers, if `given` is meant for all whom it suits: the
/// others keep their `own`, or have the usual one.
///
/// # Errors
/// If a name is unknown, or given and suits no robot, or a robot's own does not suit it, or no planner does. The clairvoyant
/// suits a hopper that is alone.
pub fn assigned(brief: &Brief, given: Option<Name>, own: &[Option<Name>]) -> Result<Vec<Name>, PlannerError> {
    let suits = |robot: &Robot, name: &Name| suited(brief, robot).contains(&name.as_str());
    let is_for_some = |name: &Name| brief.robots.iter().any(|robot| suits(robot, name));
    let of_robot = |(number, robot): (usize, &Robot)| {
        let given = given.filter(|given| !is_for_some(given) || suits(robot, given));
        let own = || own.get(number).copied().flatten();
        let usual = || usual(brief, robot).map(name);
        let whose = if brief.robots.count() > 1 { format!(" for robot {number}") } else { String::new() };
        let Some(got) = given.or_else(own).or_else(usual) else {
            let (body, goal) = (robot.body.name(), robot.goal.name());
            let reason = format!("needs a planner{whose}, but none is for a {body} with the goal {goal}");
            return Err(PlannerError::Unsuited { reason });
        };
        if suits(robot, &got) || got.as_str() == CLAIRVOYANT && !brief.has_team() {
            return Ok(got);
        }
        // A name that nobody knows is refused as such.
        algorithm(got.as_str())?;
        let need = suited(brief, robot).join(", ");
        Err(PlannerError::Unsuited { reason: format!("needs one of the planners {need}, got {got}{whose}") })
    };
    brief.robots.iter().enumerate().map(of_robot).collect()
}
