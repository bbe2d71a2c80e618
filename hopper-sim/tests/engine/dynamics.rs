//! What an action does on the true terrain.

use std::sync::Arc;

use contract::{
    Action, Branch, Cell, Collected, Decision, Direction, Flight, Leader, Pose, Soil, SoilMotion, State,
    Status,
};
use hopper_sim::Execution;
use hopper_sim::{Mission, RobotTeam};

use crate::fixture::{EAST, Host, WEST, law, mission, sure_mission};

/// The opening state of `mission`, moved to `cell`.
fn at(mission: &Mission, cell: Cell) -> State {
    let opening = *Host::new(mission.clone(), Vec::new(), hopper_sim::Pace::Max).arbiter.state();
    let height_m = mission.terrain.ground(cell).unwrap().height_m;
    State { pose: Pose { cell, height_m }, ..opening }
}

/// What `action` of the hopper comes to that stands where `state` has it.
fn execute(mission: &Mission, state: &State, action: Action) -> Execution {
    let mut there = mission.clone();
    there.brief.robots[0].start.cell = state.pose.cell;
    let mut team = RobotTeam::new(&there);
    team.execute(mission, state, Leader::default(), action).1
}

fn from(cell: Cell, action: Action) -> Execution {
    let mission = sure_mission(cell);
    execute(&mission, &at(&mission, cell), action)
}

#[test]
fn a_sure_hop_lands_on_its_target_and_flies_the_rise_between() {
    let Execution { outcome, pose, steps, status, .. } = from(Cell::new(1, 2), EAST);
    assert_eq!(
        (outcome.branch, outcome.to, steps, status),
        (Branch::Intended, Cell::new(2, 2), 2, Status::Underway)
    );
    assert_eq!(pose, Pose { cell: outcome.to, height_m: 0.01 * 2.0 + 0.02 * 2.0 });
    assert!((outcome.flight.rise_m - 0.01).abs() < 1e-12);
    assert_eq!(outcome.flight.flights, 1);
}

#[test]
fn a_hop_from_sand_is_two_half_hops_and_three_steps() {
    let Execution { outcome, steps, .. } = from(Cell::new(3, 2), EAST);
    assert_eq!((outcome.flight.flights, outcome.flight.range_m, steps), (2, 0.5, 3));
}

#[test]
fn holding_flies_nothing_and_costs_a_step() {
    let Execution { outcome, pose, steps, status, .. } = from(Cell::new(3, 2), Action::Hold);
    assert_eq!((outcome.branch, outcome.flight), (Branch::Held, Flight::default()));
    assert_eq!((outcome.from, outcome.to, pose.cell), (Cell::new(3, 2), Cell::new(3, 2), Cell::new(3, 2)));
    assert_eq!((steps, status), (1, Status::Underway));
}

#[test]
fn landing_outside_leaves_the_map_at_the_height_of_departure() {
    let Execution { outcome, pose, status, .. } = from(Cell::new(0, 4), WEST);
    assert_eq!((pose.cell, status), (Cell::new(-1, 4), Status::LeftMap));
    assert_eq!((pose.height_m, outcome.flight.rise_m), (0.02 * 4.0, 0.0));
}

#[test]
fn landing_on_impassable_ground_is_lost() {
    assert_eq!(from(Cell::new(7, 0), EAST).status, Status::Lost);
}

#[test]
fn the_goal_counts_up_to_the_last_step_and_a_deadlock_begins_there() {
    let start = Cell::new(6, 6);
    let mission = sure_mission(start);
    let after = |steps, action| execute(&mission, &State { steps, ..at(&mission, start) }, action).status;
    let steps_max = mission.brief.limits.steps_max;
    assert_eq!(after(steps_max - 2, EAST), Status::Goal, "at the limit exactly");
    assert_eq!(after(steps_max - 1, EAST), Status::Deadlock, "at the goal, one step late");
    assert_eq!(after(steps_max - 2, WEST), Status::Deadlock, "elsewhere at the limit");
    assert_eq!(after(steps_max - 3, WEST), Status::Underway, "one step before the limit");
}

#[test]
fn the_outcome_depends_on_seed_and_decision_and_action_alone() {
    let mission = mission();
    let state = at(&mission, Cell::new(4, 4));
    let branches = |seed| -> Vec<Branch> {
        let mission = Mission { seed, ..mission.clone() };
        let branch = |decision| {
            let state = State { decision: Decision(decision), ..state };
            execute(&mission, &state, EAST).outcome.branch
        };
        (0..200).map(branch).collect()
    };
    assert_eq!(branches(1), branches(1));
    assert_ne!(branches(1), branches(2));
    for branch in [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right] {
        assert!(branches(1).contains(&branch), "{branch:?} comes up within 200 hops from sand");
    }
}

/// P-PHYSICS.
#[test]
fn landings_scatter_as_the_law_says() {
    // 20,000 keyed draws against the transition row; the tolerance is five standard deviations.
    const HOPS: u32 = 20_000;
    let mission = mission();
    let state = at(&mission, Cell::new(4, 4));
    let ground = mission.terrain.ground(state.pose.cell).unwrap();
    assert_eq!(ground.soil, Soil::Sand);
    let row = motion::transition(&mission.brief.leg(0).motion, ground, Direction::East);
    let mut counts = [0_u32; 5];
    for decision in 0..HOPS {
        let state = State { decision: Decision(decision.into()), ..state };
        counts[execute(&mission, &state, EAST).outcome.branch.code() as usize - 1] += 1;
    }
    for branch in [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right] {
        let (share, law) =
            (f64::from(counts[branch.code() as usize - 1]) / f64::from(HOPS), row.probability(branch));
        let deviation = (law * (1.0 - law) / f64::from(HOPS)).sqrt();
        assert!((share - law).abs() < 5.0 * deviation, "{branch:?}: {share} against {law}");
    }
}

#[test]
fn a_treasure_is_collected_by_whatever_hop_lands_on_it_and_once() {
    let mut mission = sure_mission(Cell::new(1, 2));
    Arc::make_mut(&mut mission.terrain).treasures = vec![Cell::new(2, 2), Cell::new(1, 3)];
    let first = execute(&mission, &at(&mission, Cell::new(1, 2)), EAST);
    assert_eq!(first.collected, Collected(0b01));
    let state = State { collected: first.collected, ..at(&mission, Cell::new(1, 2)) };
    assert_eq!(execute(&mission, &state, EAST).collected, first.collected, "it is gone");
    assert_eq!(execute(&mission, &state, WEST).collected, first.collected, "nothing lies there");

    // A hop east that always slips to the left lands north.
    law(&mut mission.brief).hard = SoilMotion { intended: 0.0, stuck: 0.0, sideways: 0.5, flights: 1 };
    let slips = |decision| execute(&mission, &State { decision: Decision(decision), ..state }, EAST);
    let left = (0..64).map(slips).find(|slip| slip.outcome.branch == Branch::Left).expect("one of 64");
    assert_eq!((left.pose.cell, left.collected), (Cell::new(1, 3), Collected(0b11)));
}
