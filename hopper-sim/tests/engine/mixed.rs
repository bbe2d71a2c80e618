//! Robots of any kind with tasks of their own: where they may go, when they are done, and how the mission stands.

use std::collections::BTreeSet;
use std::sync::Arc;

use contract::{
    Action, Announcement, Branch, Brief, Cell, Command, Direction, DriveSpeed, Heartbeat, Incarnation,
    MonotonicNs, Origin, Pace, PeerTable, Record, Refusal, RobotId, RobotSet, Role, Route, RunId, Standing,
    State, Status, Team, Term, Waypoint,
};
use hopper_sim::{Arbiter, Effect, Event, Mission};
use scenario::{ResolvedScenario, Scenario};

use crate::fixture::{beat, command};

const GROUND: &str = "[truth.terrain.obstacles]\nwidth_cells = 8\nheight_cells = 6\ncell_size_m = 1.0\npercent = 0.0\nseed = 0\n\
    [truth.mobility]\nspeeds = [0.0, 0.0, 0.0, 1.0]\n[brief]\nprofile = \"hopper\"\n\
    [limits]\nsteps_max = 12\n[guard]\nhazard_max = 1.0\n";

const HOPPER: &str = "[[robots]]\nbody = \"hopper\"\nstart = [2, 2]\ngoal = [4, 2]\n";

/// A rover that covers ground.
fn rover(x: i32, y: i32, more: &str) -> String {
    format!("[[robots]]\nbody = \"rover\"\nstart = [{x}, {y}]\n{more}\n")
}

fn world(robots: &[&str]) -> ResolvedScenario {
    Scenario::parse(&format!("{GROUND}{}", robots.concat()), "test").unwrap().resolve().unwrap()
}

/// An arbiter whose appends always succeed.
struct Host {
    arbiter: Arbiter,
    records: Vec<Record>,
    refused: Vec<Refusal>,
}

impl Host {
    fn new(world: &ResolvedScenario, seed: u64) -> Self {
        let brief = Brief { run: RunId(1), ..world.brief.clone() };
        let mission = Mission { brief, ..Mission::of(world, seed) };
        let arbiter = Arbiter::new(mission, None, Pace::Max, 0, MonotonicNs(1)).without_deadlines();
        let mut host = Self { arbiter, records: Vec::new(), refused: Vec::new() };
        host.on(Event::Tick);
        host
    }

    fn on(&mut self, event: Event) {
        for effect in self.arbiter.on(event, MonotonicNs(2)) {
            match effect {
                Effect::Append(record) => {
                    self.records.push(record);
                    self.on(Event::Appended);
                }
                Effect::Refused(refusal) => self.refused.push(refusal),
                _ => {}
            }
        }
    }

    fn state(&self) -> State {
        *self.arbiter.state()
    }

    fn team(&self) -> Team {
        self.arbiter.team().unwrap().clone()
    }

    fn standing(&self, robot: u16) -> Standing {
        self.team().members[usize::from(robot)].standing
    }

    /// Commands the robot that is due, which is `robot`; why that was refused, if it was.
    fn send(&mut self, robot: u16, action: Action) -> Option<Refusal> {
        let due = self.team().due;
        assert_eq!(due, RobotId(robot), "whose turn it is");
        let life = Incarnation(1 + u64::from(due.0));
        let command =
            Command { robot: due, incarnation: life, term: Term(1), ..command(&self.state(), action) };
        let before = self.refused.len();
        self.on(Event::Command(Ok(command)));
        self.refused.get(before).cloned()
    }

    fn announce(&mut self, robot: u16, points: &[[f64; 2]]) -> Option<Refusal> {
        let route = Route::new(points.iter().map(|&[x_m, y_m]| Waypoint { x_m, y_m }).collect()).unwrap();
        let id = route.id();
        self.on(Event::Announcement(Ok(Announcement { run: RunId(1), robot: RobotId(robot), route })));
        self.send(robot, Action::Announce(id))
    }

    fn last(&self) -> &Record {
        self.records.last().unwrap()
    }
}

const EAST: Action = Action::Hop(Direction::East);

/// P-MIXED-OCCUPIED: No hop, step or drive may aim at a cell that another robot on the ground
/// occupies: the command is refused by name.
#[test]
fn who_aims_at_an_occupied_cell_is_refused_by_name() {
    let helicopter = "[[robots]]\nbody = \"helicopter\"\nstart = [2, 3]\nspeed_mps = 5.0\n";
    let driver = "[[robots]]\nbody = \"driver\"\nstart = [2, 0]\ngoal = [7, 5]\n";
    let world = world(&[HOPPER, &rover(3, 2, ""), driver, helicopter]);
    let mut host = Host::new(&world, 1);
    let occupied = |refusal: Option<Refusal>, by: u16| match refusal {
        Some(Refusal::Occupied { robot, .. }) => assert_eq!(robot, RobotId(by)),
        other => panic!("{other:?}"),
    };
    occupied(host.send(0, EAST), 1);
    assert!(host.state().vetoed.has(EAST), "so its planner chooses another");
    assert_eq!(host.send(0, Action::Hop(Direction::North)), None, "a helicopter flies above");
    let at = host.last().outcome.to;
    let west = Action::Step(Direction::West);
    if at == Cell::new(2, 2) {
        occupied(host.send(1, west), 0);
    }
    assert_eq!(host.send(1, Action::Hold), None);
    assert_eq!(host.announce(2, &[[2.5, 0.5], [3.5, 2.5]]), None);
    assert_eq!(host.send(3, Action::Done), None);
    while host.team().due != RobotId(2) {
        let robot = host.team().due.0;
        assert_eq!(host.send(robot, Action::Hold), None);
    }
    occupied(host.send(2, Action::Drive), 1);
}

/// P-MANNED. A planner of another robot does not count for the robot that is due; only acting
/// robots need one.
#[test]
fn a_team_is_manned_by_the_planner_of_the_robot_that_is_due() {
    let now = MonotonicNs(2);
    let driver = "[[robots]]\nbody = \"driver\"\nstart = [2, 0]\ngoal = [7, 5]\nrequired = false\n";
    let mut host = Host::new(&world(&[HOPPER, driver, &rover(0, 5, "")]), 1);
    let perception = Heartbeat { run: RunId(1), ..beat(Role::Perception, 90, 1, Status::Underway) };
    let is_manned = |host: &Host, robots: &[u16]| {
        let robots = robots.iter().map(|robot| RobotId(*robot)).fold(RobotSet::NONE, RobotSet::with);
        let mut peers = PeerTable::default();
        peers.observe(perception, now);
        peers.observe(Heartbeat { robots, ..beat(Role::Planner, 91, 1, Status::Underway) }, now);
        host.arbiter.is_manned(&peers, now)
    };
    assert_eq!(host.team().due, RobotId(0));
    assert!(is_manned(&host, &[0]) && is_manned(&host, &[0, 1, 2]));
    assert!(!is_manned(&host, &[1, 2]) && !is_manned(&host, &[]));
    assert_eq!(host.arbiter.acting(), RobotSet::first(3));
    assert_eq!(host.send(0, Action::Hop(Direction::East)), None);
    assert_eq!(host.team().due, RobotId(1));
    assert!(!is_manned(&host, &[0, 2]) && is_manned(&host, &[1]));
    assert_eq!(host.send(1, Action::Done), None);
    assert_eq!(
        host.arbiter.acting(),
        [RobotId(0), RobotId(2)].into_iter().fold(RobotSet::NONE, RobotSet::with)
    );
}

/// P-MIXED-GOAL: A rover that covers ground never steps onto the goal of a hopper, whoever commands
/// it.
#[test]
fn a_rover_that_covers_ground_keeps_off_the_goals_of_hoppers() {
    let mut host = Host::new(&world(&[&rover(3, 2, ""), HOPPER]), 1);
    let onto_the_goal = Action::Step(Direction::East);
    assert!(
        matches!(host.send(0, onto_the_goal), Some(Refusal::Vetoed { action, .. }) if action == onto_the_goal)
    );
    assert!(host.state().vetoed.has(onto_the_goal), "so its planner chooses another");
    assert_eq!(host.send(0, Action::Step(Direction::North)), None, "beside it is free");
}

/// P-MIXED-STRAY: A hop that would stray onto another robot ends where it began; its draw is that
/// of a hopper alone.
#[test]
fn a_hop_that_strays_onto_a_robot_ends_where_it_began() {
    let beside = [rover(1, 2, ""), rover(3, 2, "")];
    // A hopper with nobody else is another mission, and none on ground with speeds.
    let far = rover(7, 5, "");
    let (crowded, alone) = (world(&[HOPPER, &beside[0], &beside[1]]), world(&[HOPPER, &far]));
    let north = Action::Hop(Direction::North);
    let mut stopped = [0; 2];
    for seed in 0..200 {
        let hop = |world| {
            let mut host = Host::new(world, seed);
            assert_eq!(host.send(0, north), None);
            host.last().outcome
        };
        let (among, free) = (hop(&crowded), hop(&alone));
        assert_eq!(among.branch, free.branch, "seed {seed}: the draw is the same");
        match free.branch {
            Branch::Left | Branch::Right => {
                assert_eq!((free.to.y, among.to), (2, among.from), "seed {seed}");
                stopped[usize::from(free.branch == Branch::Right)] += 1;
            }
            _ => assert_eq!(among.to, free.to, "seed {seed}"),
        }
    }
    assert!(stopped.iter().all(|&count| count > 2), "{stopped:?}");
}

/// Hops `robot` to the east until it is there, and lets all others hold.
fn hop_east(host: &mut Host, robot: u16, until: impl Fn(&Host) -> bool) {
    while !until(host) && !host.state().status.is_over() {
        let due = host.team().due.0;
        let action = if due == robot { EAST } else { Action::Hold };
        assert_eq!(host.send(due, action), None);
    }
}

/// P-MIXED-END: A mixed mission reaches its goal when all robots that it requires are done, and no
/// sooner.
#[test]
fn a_mission_is_over_once_the_robots_are_done_that_it_needs() {
    let other = "[[robots]]\nbody = \"hopper\"\nstart = [2, 4]\ngoal = [3, 4]\n";
    let optional = format!("{other}required = false\n");
    let mut ends = Vec::new();
    for second in [other, &optional] {
        // A seed with which all hops go where they were meant to.
        let world = world(&[HOPPER, second]);
        let straight = (0..500).find_map(|seed| {
            let mut host = Host::new(&world, seed);
            hop_east(&mut host, 0, |host| host.standing(0) == Standing::Done);
            let is_straight = host
                .records
                .iter()
                .all(|record| record.robot != RobotId(0) || record.outcome.branch == Branch::Intended);
            is_straight.then_some(host)
        });
        let mut host = straight.unwrap();
        assert_eq!(host.standing(0), Standing::Done, "it stands on its goal");
        ends.push(host.state().status);
        if host.state().status == Status::Underway {
            assert_eq!(host.team().due, RobotId(1), "who is done has no turn");
            let goal = (0..12).any(|_| {
                let _ = host.send(1, EAST);
                host.state().status.is_over()
            });
            assert!(goal, "at the goal or out of actions");
        }
    }
    assert_eq!(ends, [Status::Underway, Status::Goal]);
}

/// P-MIXED-LOST: A lost robot ends a mixed mission only if the mission requires it. A team of
/// rovers of which none is left is lost.
#[test]
fn a_robot_that_is_lost_ends_the_mission_only_if_it_is_needed() {
    let far = |required: bool| {
        format!("[[robots]]\nbody = \"hopper\"\nstart = [7, 5]\ngoal = [0, 5]\nrequired = {required}\n")
    };
    for required in [true, false] {
        let mut host = Host::new(&world(&[&far(required), HOPPER]), 3);
        hop_east(&mut host, 0, |host| host.standing(0) != Standing::Active);
        let last = host.records.iter().rfind(|record| record.robot == RobotId(0)).unwrap();
        assert_eq!(last.outcome.to, Cell::new(8, 5), "off the map");
        assert_eq!(host.standing(0), Standing::Stranded);
        let expected = if required { Status::LeftMap } else { Status::Underway };
        assert_eq!(host.state().status, expected);
    }
}

/// P-MIXED-GIVES-UP: A robot that gives up or has used up its actions ends a mixed mission only if
/// the mission requires it.
#[test]
fn who_gives_up_or_runs_out_of_actions_ends_the_mission_only_if_it_is_needed() {
    let driver = |required: bool| {
        format!("[[robots]]\nbody = \"driver\"\nstart = [2, 0]\ngoal = [7, 5]\nrequired = {required}\n")
    };
    for required in [true, false] {
        let mut host = Host::new(&world(&[&driver(required), HOPPER]), 3);
        assert_eq!(host.send(0, Action::Done), None);
        let expected = if required { Status::Deadlock } else { Status::Underway };
        assert_eq!(
            (host.standing(0), host.state().status),
            (Standing::GaveUp, expected),
            "elsewhere than at its goal"
        );
        let mut host = Host::new(&world(&[&driver(required), HOPPER]), 3);
        for _ in 0..12 {
            assert_eq!(host.state().status, Status::Underway);
            let due = host.team().due.0;
            assert_eq!((due, host.send(due, Action::Hold)), (0, None));
            if host.team().due == RobotId(1) {
                assert_eq!(host.send(1, Action::Hold), None);
            }
        }
        let standing = host.standing(0);
        if required {
            assert_eq!((host.state().status, standing), (Status::Deadlock, Standing::Active));
        } else {
            assert_eq!(standing, Standing::GaveUp, "it has no action left");
        }
    }
}

/// P-MIXED-DRIVE: A rover with a goal is done once it is within reach of the goal.
#[test]
fn a_rover_is_done_within_reach_of_its_goal() {
    let driver = "[[robots]]\nbody = \"driver\"\nstart = [0, 0]\ngoal = [7, 0]\n";
    let mut host = Host::new(&world(&[driver]), 1);
    assert_eq!(host.announce(0, &[[0.5, 0.5], [3.0, 0.5], [5.0, 0.5]]), None);
    assert_eq!(host.send(0, Action::Drive), None);
    assert_eq!((host.standing(0), host.state().status), (Standing::Active, Status::Underway));
    assert_eq!(host.send(0, Action::Drive), None);
    assert_eq!(
        (host.standing(0), host.state().status),
        (Standing::Done, Status::Goal),
        "2.5 m are within 3 m"
    );
}

/// P-MIXED-CLOSED: Ground that a robot closes off by stopping for good no longer counts for rovers
/// that cover ground.
#[test]
fn a_robot_that_has_stopped_for_good_closes_the_way_of_rovers() {
    // A corridor: the hopper's goal lies between the rover and the ground beyond.
    let text = GROUND.replace("height_cells = 6", "height_cells = 1");
    let robots = "[[robots]]\nbody = \"hopper\"\nstart = [4, 0]\ngoal = [3, 0]\n";
    let text = format!("{text}{robots}{}", rover(0, 0, ""));
    let world = Scenario::parse(&text, "test").unwrap().resolve().unwrap();
    let arrived = (0..200).find_map(|seed| {
        let mut host = Host::new(&world, seed);
        assert_eq!(host.send(0, Action::Hop(Direction::West)), None);
        (host.standing(0) == Standing::Done).then_some(host)
    });
    let mut host = arrived.unwrap();
    for _ in 0..2 {
        assert_eq!(host.state().status, Status::Underway);
        assert_eq!(host.send(1, Action::Step(Direction::East)), None);
    }
    assert_eq!(
        (host.state().status, host.state().visits),
        (Status::Goal, 3),
        "cells 0 to 2 are all there is"
    );
}

/// P-MIXED-LOST. Once no rover is left, uncovered ground stays uncovered.
#[test]
fn rovers_of_which_none_is_left_are_lost() {
    let fault = |robot: u16| format!("[[faults]]\nrobot = {robot}\naction = 1\n");
    let world = world(&[&rover(0, 0, ""), &rover(7, 5, ""), &fault(0), &fault(1)]);
    let mut host = Host::new(&world, 1);
    assert_eq!(host.send(0, Action::Hold), None);
    assert_eq!((host.standing(0), host.state().status), (Standing::Stranded, Status::Underway));
    assert_eq!(host.send(1, Action::Hold), None);
    assert_eq!((host.standing(1), host.state().status), (Standing::Stranded, Status::Lost));
}

/// P-MIXED-FALLBACK: At a deadline no hopper hops onto a cell where another robot is.
#[test]
fn at_a_deadline_a_hopper_passes_by_who_stands_in_its_way() {
    let text = GROUND.replace("hazard_max = 1.0", "hazard_max = 1.0\ndeadline_s = 0.1");
    let text = format!("{text}{HOPPER}{}", rover(3, 2, ""));
    let world = Scenario::parse(&text, "test").unwrap().resolve().unwrap();
    let brief = Brief { run: RunId(1), ..world.brief.clone() };
    let mission = Mission { brief, ..Mission::of(&world, 1) };
    let mut arbiter = Arbiter::new(mission, None, Pace::Max, 0, MonotonicNs(1));
    arbiter.on(Event::Tick, MonotonicNs(1));
    let effects = arbiter.on(Event::Tick, MonotonicNs(200_000_000));
    let record = effects.iter().find_map(|effect| match effect {
        Effect::Append(record) => Some(record),
        _ => None,
    });
    // East is nearest to the goal, and taken; north and south are as near as each other.
    let (record, north) = (record.unwrap(), Action::Hop(Direction::North));
    assert_eq!((record.robot, record.origin, record.action), (RobotId(0), Origin::Greedy, north));
}

/// P-MIXED-SEEN: The guard of a drive knows what any robot has seen.
#[test]
fn the_guard_of_a_drive_knows_what_hoppers_have_seen() {
    let text = GROUND.replace("speeds = [0.0, 0.0, 0.0, 1.0]", "seed = 0\nspeeds = [0.5, 0.0, 0.0, 0.5]");
    let text = text.replace("hazard_max = 1.0", "hazard_max = 0.01");
    let driver = "[[robots]]\nbody = \"driver\"\nstart = [2, 0]\ngoal = [7, 5]\n";
    // All ground has one speed, and a rover cannot start on a trap.
    let worlds = (0..40).map(|seed| text.replace("seed = 0\nspeeds", &format!("seed = {seed}\nspeeds")));
    let mut worlds =
        worlds.map(|text| Scenario::parse(&format!("{text}{driver}{HOPPER}"), "test").unwrap().resolve());
    let world = worlds.find_map(Result::ok).unwrap();
    for speed in [DriveSpeed::Fast, DriveSpeed::Zero] {
        let mut world = world.clone();
        let cell = world.brief.grid.index(Cell::new(2, 1)).unwrap();
        Arc::make_mut(&mut world.terrain).cells[cell].speed = Some(speed);
        let mut host = Host::new(&world, 1);
        assert_eq!(host.announce(0, &[[2.5, 0.5], [2.5, 1.5]]), None);
        assert_eq!(host.send(1, Action::Hold), None);
        let refusal = host.send(0, Action::Drive);
        let is_vetoed = matches!(refusal, Some(Refusal::Vetoed { .. }));
        assert_eq!(is_vetoed, speed == DriveSpeed::Zero, "{speed:?}: {refusal:?}");
    }
}

/// P-MIXED-DESIGN. A hopper hops by its own law, which its guard uses too.
#[test]
fn each_hopper_hops_by_its_own_law_and_is_guarded_by_it() {
    let hopper = |y: i32, more: &str| {
        format!("[[robots]]\nbody = \"hopper\"\nstart = [0, {y}]\ngoal = [7, {y}]\n{more}\n")
    };
    let hard = |intended: f64, stuck: f64, sideways: f64| {
        format!(
            "hard = {{ intended = {intended:?}, stuck = {stuck:?}, sideways = {sideways:?}, flights = 1 }}"
        )
    };
    let robots = [hopper(1, ""), hopper(3, &hard(0.0, 1.0, 0.0)), hopper(5, &hard(1.0, 0.0, 0.0))];
    let laws = world(&robots.each_ref().map(String::as_str));
    let mut branches = [BTreeSet::new(), BTreeSet::new(), BTreeSet::new()];
    for seed in 0..100 {
        let mut host = Host::new(&laws, seed);
        for (robot, seen) in (0..).zip(&mut branches) {
            assert_eq!(host.send(robot, EAST), None);
            seen.insert(host.last().outcome.branch);
        }
    }
    let only = |branch| BTreeSet::from([branch]);
    assert_eq!(branches[0], BTreeSet::from([Branch::Intended, Branch::Left, Branch::Right]));
    assert_eq!([&branches[1], &branches[2]], [&only(Branch::Stayed), &only(Branch::Intended)]);
    // On the western rim a slip of a hop to the north leaves the map, with a probability of 0.05 by the law of [robot].
    let text = GROUND.replace("hazard_max = 1.0", "hazard_max = 0.04");
    let north = Action::Hop(Direction::North);
    for (robots, is_vetoed) in [(hopper(1, ""), true), (hopper(1, &hard(0.98, 0.0, 0.01)), false)] {
        let text = format!("{text}{robots}{}", rover(7, 5, ""));
        let world = Scenario::parse(&text, "test").unwrap().resolve().unwrap();
        let refusal = Host::new(&world, 1).send(0, north);
        assert_eq!(matches!(refusal, Some(Refusal::Vetoed { .. })), is_vetoed, "{refusal:?}");
    }
}
