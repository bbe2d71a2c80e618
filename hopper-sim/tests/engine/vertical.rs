//! Vertical hops: what the guard lets pass, what becomes of them, and what a life that is resumed repeats.

use contract::{Action, Branch, Cell, Direction, Pose, Vetoed};
use hopper_sim::{Guard, Mission, Pace, ROBOT};

use crate::fixture::{EAST, Host, command, mission};

const NORTH: Action = Action::Hop(Direction::North);
const UP_EAST: Action = Action::Up(Direction::East);

/// The rocks, with the hopper on `start`: a rock of 1 m on (3, 3) to (6, 6), one of 0.25 m on (10, 10) to (12, 12).
fn rocks(start: Cell, seed: u64) -> Mission {
    let world = scenario::load("rocks").unwrap().resolve().unwrap();
    let mut mission = Mission::of(&world, seed);
    mission.brief.robots[0].start.cell = start;
    mission
}

/// Why these actions are refused at `start`.
fn refused(start: Cell, actions: &[Action]) -> Vec<String> {
    let mission = rocks(start, 1);
    let height_m = mission.terrain.ground(start).unwrap().height_m;
    let guard = Guard::new(&mission.brief, &mission.terrain, ROBOT, Pose { cell: start, height_m });
    let why = |action: &Action| guard.refusal(*action).unwrap().to_string();
    let why = actions.iter().map(why).collect();
    let mut host = Host::new(mission.clone(), Vec::new(), Pace::Max);
    for action in actions {
        host.send(command(&host.state(), *action));
    }
    assert!(host.records.is_empty(), "{:?}", host.records);
    assert_eq!(host.refused, vec!["vetoed"; actions.len()]);
    why
}

/// P-UP-GUARD: The guard vetoes a hop that collides on what the sensor sees, a vertical hop where nothing is in the way, and one that
/// would have to rise too far; a hopper without the vertical hop is told that it has none.
#[test]
fn what_is_not_offered_is_refused() {
    assert_eq!(
        refused(Cell::new(9, 11), &[EAST, Action::Up(Direction::North)]),
        [
            "east needs an arc that clears the ground: vetoed",
            "up_north needs something in the way of a hop at the launch angle: vetoed"
        ]
    );
    assert_eq!(
        refused(Cell::new(2, 4), &[EAST, UP_EAST]),
        [
            "east needs an arc that clears the ground: vetoed",
            "up_east needs a rise below its apex of 0.485 m: vetoed"
        ]
    );
    let mut plain = Host::new(mission(), Vec::new(), Pace::Max);
    plain.send(command(&plain.state(), UP_EAST));
    assert_eq!(plain.refused, ["malformed"]);
}

/// P-UP-DRAWN: A vertical hop of 0.25 m lands as aimed in p (1 − f), to either side in s (1 − f), and stays otherwise.
#[test]
fn a_vertical_hop_ends_as_often_as_the_paper_says() {
    let mut ends = [0_u32; 4];
    const MISSIONS: u32 = 4_000;
    for seed in 0..MISSIONS {
        let mut host = Host::new(rocks(Cell::new(9, 11), seed.into()), Vec::new(), Pace::Max);
        host.send(command(&host.state(), UP_EAST));
        let outcome = host.records[0].outcome;
        let branches = [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right];
        let branch = branches.iter().position(|branch| *branch == outcome.branch).unwrap();
        ends[branch] += 1;
        let to = [Cell::new(10, 11), Cell::new(9, 11), Cell::new(9, 12), Cell::new(9, 10)][branch];
        assert_eq!(outcome.to, to);
    }
    let apex_m = 80_f64.to_radians().sin().powi(2) / 2.0;
    let works = 1.0 - 0.25 / apex_m;
    for (count, need) in ends.into_iter().zip([0.7 * works, 1.0 - works, 0.15 * works, 0.15 * works]) {
        let share = f64::from(count) / f64::from(MISSIONS);
        let error = (need * (1.0 - need) / f64::from(MISSIONS)).sqrt();
        assert!((share - need).abs() < 4.0 * error, "{share}, needs {need}");
    }
}

/// P-UP-GUARD.
#[test]
fn a_life_that_is_resumed_vetoes_and_executes_the_same() {
    let start = Cell::new(9, 11);
    let mut first = Host::new(rocks(start, 3), Vec::new(), Pace::Max);
    first.send(command(&first.state(), EAST));
    first.send(command(&first.state(), UP_EAST));
    first.send(command(&first.state(), NORTH));
    assert_eq!(first.records[0].vetoed, Vetoed::NONE.with(EAST));
    let mut second = Host::new(rocks(start, 3), first.records[..1].to_vec(), Pace::Max);
    second.send(command(&second.state(), NORTH));
    assert_eq!(
        second.records.last().map(|record| record.digest),
        first.records.last().map(|record| record.digest)
    );
}
