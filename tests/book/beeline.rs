//! The planner that hops along the longer axis towards the goal.

use contract::{Action, Direction, Name};

use planner::{Budget, Plan, PlanStatus, Planner, Situation};

/// Ignores slopes and soil; avoids what the guard has vetoed and what is known to be impassable.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beeline;

impl Planner for Beeline {
    fn name(&self) -> Name {
        "beeline".parse().expect("a name is short and printable")
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let Situation { brief, map, state } = *situation;
        let here = state.pose.cell;
        if here == brief.goal {
            return Plan::at_once(Action::Hold, PlanStatus::Solved);
        }
        let allowed = |direction: &Direction| {
            let cell = brief.grid.hop(here, *direction);
            let passable = map.ground(cell).is_none_or(|ground| ground.passable);
            brief.grid.contains(cell) && passable && !state.vetoed.has(Action::Hop(*direction))
        };
        let distance = |direction: &Direction| brief.grid.hop(here, *direction).distance_cells(brief.goal);
        // `min_by` takes the first of equals: north, east, south, west.
        let best =
            Direction::ALL.into_iter().filter(allowed).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        match best {
            Some(direction) => Plan::at_once(Action::Hop(direction), PlanStatus::Solved),
            None => Plan::at_once(Action::Hold, PlanStatus::Infeasible),
        }
    }
}
