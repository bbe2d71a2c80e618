//! The check that anyone can call on a planner passes ours, and finds those that break a rule.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::cell::Cell as Counter;

use planner::conformance::{Rule, check};
use planner::contract::{Action, Decision, Direction, Name, Vetoed};
use planner::{ALGORITHMS, Budget, COVER_ALGORITHMS, Plan, PlanStatus, Planner, Situation, algorithm};

/// P-CONFORMANCE: The conformance check for planners passes the built-in ones, and names each rule
/// that a planner breaks: cache, restart, vetoes, ties, bounds on the work.
#[test]
fn every_built_in_planner_conforms() {
    for name in ALGORITHMS {
        if let Err(violation) = check(|| algorithm(name).unwrap()) {
            panic!("{violation}");
        }
    }
}

/// What a planner does wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    /// Counts its own plans.
    Counts,
    /// Of two lives, the second prefers east.
    SecondLife,
    /// Changes its mind at its fourth plan, unless it was there from the start.
    LateComer,
    Insists,
    EastFirst,
    Overworks,
    /// A plan under a bound depends on what was planned before.
    CutByMood,
    /// Says that a plan is solved which was cut.
    Boasts,
    Drives,
}

/// Hops towards the goal along the first direction that leads there.
struct Faulty {
    fault: Fault,
    life: u64,
    plans: u64,
    began: Option<Decision>,
}

impl Planner for Faulty {
    fn name(&self) -> Name {
        "faulty".parse().unwrap()
    }

    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        let Situation { map, state, .. } = *situation;
        let leg = situation.leg();
        self.plans += 1;
        let late = *self.began.get_or_insert(state.decision) > Decision(0) && self.plans > 3;
        let east_first = match self.fault {
            Fault::EastFirst => true,
            Fault::SecondLife => self.life > 0,
            Fault::Counts => self.plans.is_multiple_of(5),
            Fault::LateComer => late,
            _ => false,
        };
        let mut directions = Direction::ALL;
        if east_first {
            directions.swap(0, 1);
        }
        let here = state.pose.cell;
        let vetoed = if self.fault == Fault::Insists { Vetoed::NONE } else { state.vetoed };
        let distance = |direction| leg.grid.hop(here, direction).distance_cells(leg.goal);
        let best = directions
            .into_iter()
            .filter(|&direction| {
                let cell = leg.grid.hop(here, direction);
                leg.grid.contains(cell)
                    && map.ground(cell).is_none_or(|ground| ground.passable)
                    && !vetoed.has(Action::Hop(direction))
            })
            .min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        let holds = match self.fault {
            Fault::CutByMood => budget.work_max == Some(7) && self.plans > 1,
            Fault::Boasts => budget.work_max == Some(7),
            _ => false,
        };
        let action = match best {
            _ if holds => Action::Hold,
            Some(direction) if self.fault == Fault::Drives => Action::Step(direction),
            Some(direction) => Action::Hop(direction),
            None => Action::Hold,
        };
        let is_cut = self.fault == Fault::CutByMood && budget.work_max.is_some();
        let status = if is_cut { PlanStatus::Cut } else { PlanStatus::Solved };
        let work = if self.fault == Fault::Overworks { 5 } else { 0 };
        Plan { work, ..Plan::at_once(action, status) }
    }
}

fn check_faulty(fault: Fault) -> Result<(), Rule> {
    let lives = Counter::new(0);
    let checked = check(|| {
        lives.set(lives.get() + 1);
        Faulty { fault, life: lives.get() - 1, plans: 0, began: None }
    });
    checked.map_err(|violation| {
        let text = violation.to_string();
        assert!(text.contains("planner faulty breaks the law (") && text.contains("need "), "{text}");
        violation.rule
    })
}

/// P-CONFORMANCE. For each rule there is a planner that breaks it, and the check names the rule.
#[test]
fn a_planner_that_breaks_a_rule_is_found_and_the_rule_is_named() {
    assert_eq!(check_faulty(Fault::None), Ok(()));
    for (fault, rule) in [
        (Fault::Counts, Rule::EmptyCache),
        (Fault::SecondLife, Rule::Ties),
        (Fault::LateComer, Rule::Restart),
        (Fault::Insists, Rule::Veto),
        (Fault::EastFirst, Rule::Ties),
        (Fault::Overworks, Rule::Budget),
        (Fault::CutByMood, Rule::Budget),
        (Fault::Boasts, Rule::Budget),
        (Fault::Drives, Rule::Action),
    ] {
        assert_eq!(check_faulty(fault), Err(rule), "{fault:?}");
    }
}

#[test]
fn a_planner_for_rovers_is_not_taken_for_one_that_conforms() {
    let violation = check(|| algorithm(COVER_ALGORITHMS[0]).unwrap()).unwrap_err();
    assert_eq!(violation.rule, Rule::Task);
}
