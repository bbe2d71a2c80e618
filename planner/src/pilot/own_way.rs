//! The mission as a hopper has it that is not the only robot.

use contract::{Brief, ObservedMap, Pose, State, Team};

/// From its start to its goal, and where it stands: so to whoever plans for it, it is a mission like any other.
#[derive(Clone, Copy, Debug)]
pub(super) struct OwnWay {
    pub brief: Brief,
    pub state: State,
}

impl OwnWay {
    /// That of the robot that is due; `None` unless it has a goal of its own, and state, robots and map agree.
    pub fn of(brief: &Brief, state: &State, team: &Team, map: &ObservedMap) -> Option<Self> {
        if !team.is_of(state) || !map.is_of(state) {
            return None;
        }
        let member = team.member(team.due)?;
        let goal = member.robot.vehicle.hop_goal()?;
        let cell = member.at.cell;
        let pose = Pose { cell, height_m: map.ground(cell)?.height_m };
        let start = member.robot.start.cell;
        Some(Self {
            brief: Brief { start, goal, ..brief.for_hopper(team.due) },
            state: State { pose, ..*state },
        })
    }
}
