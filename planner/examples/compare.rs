//! Holds a planner of one's own to the law, and asks it what it would do where the built-in ones decide too:
//! `cargo run --release --example compare`.

#![allow(clippy::print_stdout, reason = "an example shows its result")]

use planner::contract::{Action, Direction, Name};
use planner::{Budget, Plan, PlanStatus, Planner, Situation, conformance};

/// Hops along the longer way to the goal, whatever the ground.
#[derive(Default)]
struct Beeline;

impl Planner for Beeline {
    fn name(&self) -> Name {
        "beeline".parse().expect("a short and printable name")
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let (leg, state) = (situation.leg(), situation.state);
        let target = |direction| leg.grid.hop(state.pose.cell, direction);
        let open = |direction: &Direction| {
            leg.grid.contains(target(*direction)) && !state.vetoed.has(Action::Hop(*direction))
        };
        let distance = |direction| target(direction).distance_cells(leg.goal);
        let best =
            Direction::ALL.into_iter().filter(open).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        match best {
            Some(direction) => Plan::at_once(Action::Hop(direction), PlanStatus::Solved),
            None => Plan::at_once(Action::Hold, PlanStatus::Infeasible),
        }
    }
}

fn main() -> Result<(), conformance::Violation> {
    conformance::check(Beeline::default)?;
    println!("beeline keeps the law");
    for name in planner::ALGORITHMS {
        println!("built in: {name}");
    }
    Ok(())
}
