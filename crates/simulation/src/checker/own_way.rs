//! The way that a planner is given, where it is given one.

use planner::Situation;

use super::Checker;
use crate::model::Way;

impl Checker {
    /// A planner is about to plan for the robot that is due.
    pub(super) fn plans_own_way(&mut self, situation: &Situation<'_>) {
        let state = situation.state;
        let Some(need) = self.model.way(state.visits) else { return };
        let given = situation.leg.map(|leg| Way {
            start: leg.start,
            goal: leg.goal,
            motion: leg.motion,
            sensor: leg.sensor,
            pose: state.pose,
        });
        self.require(given == Some(need), "a planner is given the way of its own robot", || {
            format!("at decision {} it is given {given:?}, needs {need:?}", state.decision)
        });
    }
}
