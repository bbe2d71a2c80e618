//! Which planner commands which robot of a mission.

use contract::{Brief, Name, Vehicle};

use crate::algorithm;
use crate::error::PlannerError;
use crate::names::{CLAIRVOYANT, name, suited, usual};

/// The planner of each robot of a mission, in the order of their numbers, if `given` is meant for all whom it suits: the
/// others keep their `own`, or have the usual one.
///
/// # Errors
/// If a name is unknown, or given and suits no robot, or a robot's own does not suit it. The clairvoyant suits a hopper that
/// is alone.
pub fn assigned(
    brief: &Brief,
    vehicles: &[Option<Vehicle>],
    given: Option<Name>,
    own: &[Option<Name>],
) -> Result<Vec<Name>, PlannerError> {
    let suits = |vehicle: &Option<Vehicle>, name: &Name| suited(brief, *vehicle).contains(&name.as_str());
    let is_for_some = |name: &Name| vehicles.iter().any(|vehicle| suits(vehicle, name));
    let of_robot = |(robot, vehicle): (usize, &Option<Vehicle>)| {
        let given = given.filter(|given| !is_for_some(given) || suits(vehicle, given));
        let own = || own.get(robot).copied().flatten();
        let got = given.or_else(own).unwrap_or_else(|| name(usual(brief, *vehicle)));
        if suits(vehicle, &got) || got.as_str() == CLAIRVOYANT && vehicle.is_none() {
            return Ok(got);
        }
        // A name that nobody knows is refused as such.
        algorithm(got.as_str())?;
        let need = suited(brief, *vehicle).join(", ");
        let whose = if vehicles.len() > 1 { format!(" for robot {robot}") } else { String::new() };
        Err(PlannerError::Unsuited { reason: format!("needs one of the planners {need}, got {got}{whose}") })
    };
    vehicles.iter().enumerate().map(of_robot).collect()
}
