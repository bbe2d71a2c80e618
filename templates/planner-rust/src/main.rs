//! Hops towards the goal, around what is known to be impassable.

use planner::contract::{Action, Direction, Name};
use planner::{Budget, Plan, PlanStatus, Planner, Situation};

#[derive(Default)]
struct MyPlanner;

impl Planner for MyPlanner {
    fn name(&self) -> Name {
        "my_planner".parse().expect("a short and printable name")
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let (leg, Situation { map, state, .. }) = (situation.leg(), *situation);
        let target = |direction| leg.grid.hop(state.pose.cell, direction);
        let distance = |direction| target(direction).distance_cells(leg.goal);
        let is_open = |&direction: &Direction| {
            leg.grid.contains(target(direction))
                && map.ground(target(direction)).is_none_or(|ground| ground.passable)
                && !state.vetoed.has(Action::Hop(direction))
        };
        let open = Direction::ALL.into_iter().filter(is_open);
        match open.min_by(|&a, &b| distance(a).total_cmp(&distance(b))) {
            Some(direction) => Plan::at_once(Action::Hop(direction), PlanStatus::Solved),
            None => Plan::at_once(Action::Hold, PlanStatus::Infeasible),
        }
    }
}

fn main() -> std::process::ExitCode {
    planner::main(MyPlanner::default)
}

#[test]
fn it_keeps_the_law() -> Result<(), planner::conformance::Violation> {
    planner::conformance::check(MyPlanner::default)
}
