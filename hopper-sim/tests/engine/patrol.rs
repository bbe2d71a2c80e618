//! A patrol visits its goals in turn, and ends by its hops.

use contract::{Cell, Decision, Goal, Status, Visit};
use hopper_sim::{Mission, Pace};

use crate::fixture::{EAST, Host, WEST, command, steer, sure_mission};

/// There and back between two cells, hops landing where they are meant to.
fn patrol(hops_max: u64) -> Mission {
    let mut mission = sure_mission(Cell::new(1, 2));
    let goals = [Cell::new(3, 2), Cell::new(1, 2)];
    mission.brief.robots[0].goal = Goal::Visit(Visit::new(&goals, hops_max).unwrap());
    mission.brief.limits.steps_max = 10;
    mission
}

/// P-PATROL: A patrol visits its goals in turn, and ends when its hops are flown.
#[test]
fn goals_are_visited_in_turn_and_the_hops_end_the_patrol() {
    let mut host = Host::new(patrol(11), Vec::new(), Pace::Max);
    let mut visited = Vec::new();
    while !host.state().status.is_over() {
        let (state, brief) = (host.state(), host.arbiter.mission().brief.clone());
        let leg = brief.leg(state.visits);
        assert_ne!(leg.start, leg.goal);
        let action = if leg.goal.x > state.pose.cell.x { EAST } else { WEST };
        host.send(command(&state, action));
        if host.state().visits > state.visits {
            visited.push((host.state().decision.0, host.state().pose.cell.x));
        }
    }
    // Two hops a leg; the limit of steps does not apply; the last leg is cut short.
    assert_eq!(visited, [(2, 3), (4, 1), (6, 3), (8, 1), (10, 3)]);
    let state = host.state();
    assert_eq!((state.decision, state.status, state.visits), (Decision(11), Status::Goal, 5));
    assert!(state.steps > 10, "the step limit is that of other missions");
    assert_eq!(host.finished, []);
}

#[test]
fn a_goal_out_of_turn_is_not_visited_and_a_resumed_patrol_knows_its_goal() {
    let mut host = Host::new(patrol(100), Vec::new(), Pace::Max);
    // Back to the second goal before the first has been visited.
    for action in [EAST, WEST, EAST, EAST] {
        host.send(command(&host.state(), action));
    }
    assert_eq!(host.records.iter().map(|record| record.visits).collect::<Vec<_>>(), [0, 0, 0, 1]);
    let again = Host::new(patrol(100), host.records.clone(), Pace::Max);
    assert_eq!(again.state().visits, 1);
    assert_eq!(again.arbiter.mission().brief.leg(1).goal, Cell::new(1, 2));
}

#[test]
fn a_patrol_that_starts_where_it_goes_first_is_not_over() {
    let mut mission = patrol(5);
    mission.brief.robots[0].start.cell = mission.brief.goal_after(0).unwrap();
    let mut host = Host::new(mission, Vec::new(), Pace::Max);
    assert_eq!(host.state().status, Status::Underway);
    host.send(command(&host.state(), contract::Action::Hold));
    assert_eq!(host.state().visits, 1, "to stand on it is to visit it");
}

#[test]
fn a_mission_to_one_goal_visits_it_once() {
    let mut host = Host::new(sure_mission(Cell::new(5, 6)), Vec::new(), Pace::Max);
    while !host.state().status.is_over() {
        let state = host.state();
        host.send(command(&state, steer(&host.arbiter.mission().brief, &state)));
    }
    assert_eq!((host.state().status, host.state().visits), (Status::Goal, 1));
}
