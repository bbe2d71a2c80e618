//! A planner that is watched: the checker sees every situation it is given.

use std::sync::{Arc, Mutex};

use contract::{Brief, Name, ObservedMap, PolicyCell, Route, State, Task};
use planner::{Budget, Plan, Planner, Situation};

/// What the planner was last given, until the checker has looked at it.
pub(crate) type Seen = Arc<Mutex<Option<(Brief, ObservedMap, State)>>>;

/// Passes everything on to the real planner.
pub(crate) struct Observed {
    pub planner: Box<dyn Planner>,
    pub seen: Seen,
}

impl Planner for Observed {
    fn name(&self) -> Name {
        self.planner.name()
    }

    fn suits(&self, task: Task) -> bool {
        self.planner.suits(task)
    }

    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        let seen = (*situation.brief, situation.map.clone(), *situation.state);
        *self.seen.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(seen);
        // What takes long calls the pulse; the quick planners of small worlds do so here.
        budget.pulse.beat();
        self.planner.plan(situation, budget)
    }

    fn announced(&self) -> Option<&Route> {
        self.planner.announced()
    }

    fn policy(&mut self) -> Option<Vec<PolicyCell>> {
        self.planner.policy()
    }
}
