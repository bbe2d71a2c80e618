//! The algorithm that never moves.

use contract::{Action, Name};

use crate::names;
use crate::plan::{Budget, Plan, PlanStatus, Planner, Situation};

/// Holds in every situation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hold;

impl Planner for Hold {
    fn name(&self) -> Name {
        names::name(names::HOLD)
    }

    fn plan(&mut self, _: &Situation<'_>, _: &Budget) -> Plan {
        Plan::at_once(Action::Hold, PlanStatus::Solved)
    }
}
