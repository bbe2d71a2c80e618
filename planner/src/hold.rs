//! The planner that never moves.

use contract::{Action, Name};

use crate::{Budget, Plan, PlanStatus, Planner, Situation, algorithm};

/// Stands still, whatever the situation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hold;

impl Planner for Hold {
    fn name(&self) -> Name {
        algorithm::name("hold")
    }

    fn plan(&mut self, _: &Situation<'_>, _: &Budget) -> Plan {
        Plan::at_once(Action::Hold, PlanStatus::Solved)
    }
}
