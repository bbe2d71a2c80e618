//! What a mission cannot go on without.

use std::fmt;

use crate::{Heartbeat, RobotId, RobotSet, Role};

/// A process that has to be there, and is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissingPeer {
    /// Nobody senses.
    Perception,
    /// Nobody plans for these robots.
    Planner(RobotSet),
}

impl MissingPeer {
    /// What a mission lacks whose robots `acting` still act, if those live whose last heartbeats these are; perception
    /// first.
    #[must_use]
    pub fn among(acting: RobotSet, alive: impl Iterator<Item = Heartbeat>) -> Option<Self> {
        let (mut senses, mut unplanned) = (false, acting);
        for beat in alive {
            match beat.role {
                Role::Perception => senses = true,
                Role::Planner => unplanned = unplanned.without(beat.robots),
                Role::HopperSim | Role::Monitor => {}
            }
        }
        if acting.is_empty() {
            None
        } else if !senses {
            Some(MissingPeer::Perception)
        } else if !unplanned.is_empty() {
            Some(MissingPeer::Planner(unplanned))
        } else {
            None
        }
    }

    /// Part that it would play.
    #[must_use]
    pub fn role(&self) -> Role {
        match self {
            MissingPeer::Perception => Role::Perception,
            MissingPeer::Planner(_) => Role::Planner,
        }
    }

    /// The command that starts it, in a certain instance if one is named: for robots that differ no planner serves all, so it is that
    /// of the first.
    #[must_use]
    pub fn command(&self, instance: Option<&str>) -> String {
        let mut command = format!("hopper {}", self.role());
        if let Some(instance) = instance {
            command = format!("{command} --instance {instance}");
        }
        match self {
            MissingPeer::Perception => command,
            MissingPeer::Planner(robots) => {
                robots.iter().next().map_or(command.clone(), |robot| format!("{command} --robot {robot}"))
            }
        }
    }

    /// What to add to [`MissingPeer::command`] where it does not start all that is missing.
    #[must_use]
    pub fn and_others(&self) -> &'static str {
        match self {
            MissingPeer::Planner(robots) if robots.iter().count() > 1 => ", and one for each of the others",
            _ => "",
        }
    }
}

impl fmt::Display for MissingPeer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MissingPeer::Perception => f.write_str("perception"),
            MissingPeer::Planner(robots) => write!(f, "a planner of {}", Robots(*robots)),
        }
    }
}

/// Robots in words.
struct Robots(RobotSet);

impl fmt::Display for Robots {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers: Vec<RobotId> = self.0.iter().collect();
        match numbers.as_slice() {
            [] => f.write_str("no robot"),
            [one] => write!(f, "robot {one}"),
            [others @ .., last] => {
                let others: Vec<String> = others.iter().map(RobotId::to_string).collect();
                write!(f, "robots {} and {last}", others.join(", "))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Decision, Incarnation, Name, RunId, Status};

    fn robots(numbers: &[u16]) -> RobotSet {
        numbers.iter().map(|number| RobotId(*number)).fold(RobotSet::NONE, RobotSet::with)
    }

    fn beat(role: Role, of: &[u16]) -> Heartbeat {
        Heartbeat {
            role,
            incarnation: Incarnation(1),
            pid: 1,
            version: Name::NONE,
            planner: Name::NONE,
            counter: 1,
            run: RunId(0),
            decision: Decision(0),
            status: Status::Underway,
            robots: robots(of),
        }
    }

    /// What is missing for the robots `acting`, and the command that starts it.
    fn missing(acting: &[u16], alive: &[Heartbeat]) -> Option<(String, String)> {
        let missing = MissingPeer::among(robots(acting), alive.iter().copied())?;
        Some((missing.to_string(), missing.command(Some("home")) + missing.and_others()))
    }

    /// P-MANNED: A planner counts only for the robots that it plans for: hopper-sim, doctor, page
    /// and terminal name each acting robot without a planner, and the command that starts one.
    #[test]
    fn a_planner_is_missing_for_each_robot_that_acts_and_for_which_none_plans() {
        // What hopper-sim and perception say of robots is not who plans for them.
        let [sim, perception] = [beat(Role::HopperSim, &[0, 1, 2, 3]), beat(Role::Perception, &[3])];
        let planners = [beat(Role::Planner, &[0, 2]), beat(Role::Planner, &[]), beat(Role::Planner, &[2, 5])];
        let crew = [&[sim, perception][..], &planners].concat();
        let told = |what: &str, command: &str| Some((what.to_owned(), command.to_owned()));
        let cases = [
            (&[][..], &[][..], None),
            (&[0], &[sim, planners[0]], told("perception", "hopper perception --instance home")),
            (&[0], &[perception], told("a planner of robot 0", "hopper planner --instance home --robot 0")),
            (
                &[0, 1, 2, 3],
                &crew,
                told(
                    "a planner of robots 1 and 3",
                    "hopper planner --instance home --robot 1, and one for each of the others",
                ),
            ),
            (
                &[1, 3, 4, 5],
                &crew,
                told(
                    "a planner of robots 1, 3 and 4",
                    "hopper planner --instance home --robot 1, and one for each of the others",
                ),
            ),
            (&[0, 2, 5], &crew, None),
        ];
        for (acting, alive, need) in cases {
            assert_eq!(missing(acting, alive), need, "{acting:?}");
        }
    }
}
