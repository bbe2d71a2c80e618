//! Robots of any kind, each with a task of its own, through the turns of all processes.

use std::collections::BTreeSet;

use contract::{
    Action, Branch, Brief, Cell, Decision, Leader, MonotonicNs, Name, Record, RobotId, RunId, Standing,
    Status,
};
use hopper_sim::{Arbiter, Mission, Pace};
use lockstep::{Flown, PlannerSchedule};
use scenario::{Overrides, ResolvedScenario, Scenario};

const EXPEDITION: &str = include_str!("../../../scenarios/expedition.toml");

fn resolved(text: &str) -> ResolvedScenario {
    Scenario::parse(text, "test").unwrap().with(&Overrides::default()).resolve().unwrap()
}

fn mission(world: &ResolvedScenario, seed: u64) -> Mission {
    let brief = Brief { run: RunId(1), ..world.brief.clone() };
    Mission { brief, ..Mission::of(world, seed) }
}

fn fly(world: &ResolvedScenario, seed: u64, schedule: &PlannerSchedule) -> (Flown, Vec<Record>) {
    let mut records = Vec::new();
    // No time passes: nothing is asked for twice.
    let mut clock = || MonotonicNs(1);
    let observe = &mut |record: &Record| records.push(*record);
    let flown = lockstep::fly(mission(world, seed), schedule, &mut clock, observe).unwrap();
    (flown, records)
}

fn own_planners(world: &ResolvedScenario) -> PlannerSchedule {
    let names = planner::assigned(&world.brief, None, &world.planners).unwrap();
    PlannerSchedule::of_robots(&names)
}

fn robots_of(records: &[Record]) -> BTreeSet<u16> {
    records.iter().map(|record| record.robot.0).collect()
}

/// P-GOLDEN.
#[test]
fn the_built_in_scenario_keeps_its_digest() {
    let world = resolved(EXPEDITION);
    let (flown, records) = fly(&world, 1, &own_planners(&world));
    assert_eq!((flown.state.status, records.len()), (Status::Goal, 594));
    assert_eq!(robots_of(&records).len(), 6, "every robot acts");
    assert_eq!(
        flown.state.digest.to_string(),
        "09eef4d0adce11006b0e3ba7f69dd1ae19dc6ab59c534fc4c276cc140f250746"
    );
}

/// P-MIXED-LAW: Planners of robots of all kinds fly the same mission if they are replaced by fresh
/// ones at every decision.
#[test]
fn fresh_planners_at_every_decision_fly_the_same_mission() {
    let world = resolved(EXPEDITION);
    let (flown, records) = fly(&world, 3, &own_planners(&world));
    let (again, _) = fly(&world, 3, &PlannerSchedule::relieved(&records));
    assert_eq!(again.state.digest, flown.state.digest);
    assert_eq!(again.map.observation(), flown.map.observation());
}

/// P-MIXED-RECALL: An arbiter that resumes the journal of a mixed mission at any record has all
/// robots where they were.
#[test]
fn an_arbiter_that_recalls_the_records_has_the_robots_where_they_were() {
    let world = resolved(EXPEDITION);
    let (flown, records) = fly(&world, 2, &own_planners(&world));
    let starts: Vec<Cell> = world.brief.robots.iter().map(|robot| robot.start.cell).collect();
    for count in [1, 2, 5, 40, 200, records.len() - 1] {
        let last = &records[count - 1];
        let mut arbiter = Arbiter::new(mission(&world, 2), Some(last), Pace::Max, 0, MonotonicNs(0));
        arbiter.recall_routes(flown.routes.iter().cloned());
        arbiter.recall(&records[..count]);
        let team = arbiter.team().unwrap();
        assert_eq!(team.due, records[count].robot, "after {count} decisions");
        for (robot, member) in (0..).map(RobotId).zip(team.members.iter()) {
            let own = records[..count].iter().rfind(|record| record.robot == robot);
            let expected = own.map_or(starts[usize::from(robot.0)], |record| record.outcome.to);
            assert_eq!(member.at.cell, expected, "robot {robot} after {count} decisions");
            assert_eq!(member.last, own.map(|record| record.decision));
        }
    }
}

/// P-MIXED-SWAP: In a mixed mission each robot's planner can be swapped alone.
#[test]
fn a_hoppers_planner_is_swapped_alone() {
    let world = resolved(EXPEDITION);
    let (_, own) = fly(&world, 1, &own_planners(&world));
    let greedy: Name = "greedy".parse().unwrap();
    let swapped = own.iter().map(|record| {
        let late = record.robot == RobotId(2) && record.decision >= Decision(100);
        let planner = if late { greedy } else { record.leader.planner };
        Ok::<_, std::convert::Infallible>(Record { leader: Leader { planner, ..record.leader }, ..*record })
    });
    let (flown, records) = fly(&world, 1, &PlannerSchedule::from_records(swapped).unwrap());
    assert!(flown.state.status.is_over());
    let led = |robot: u16| {
        let led =
            records.iter().filter(move |record| record.robot.0 == robot).map(|record| record.leader.planner);
        led.collect::<BTreeSet<Name>>().len()
    };
    assert_eq!((0..6).map(led).collect::<Vec<_>>(), [1, 1, 2, 1, 1, 1]);
}

/// P-MIXED-COLLIDE: Robots of all kinds on small ground never share a cell.
#[test]
fn robots_of_all_kinds_on_a_small_ground_never_share_a_cell() {
    let ground = "[truth.terrain.random_hills]\nwidth_cells = 12\nheight_cells = 10\ncell_size_m = 1.0\nseed = 4\nhills = 8\n\
        sigma_m = [2.0, 3.0]\namplitude_m = [0.05, 0.2]\n[brief]\nprofile = \"hopper\"\n\
        [limits]\nsteps_max = 400\n";
    let robots = [
        "\"hopper\"\nstart = [1, 1]\ngoal = [10, 8]",
        "\"hopper\"\nstart = [10, 1]\ngoal = [1, 8]\nplanner = \"astar\"",
        "\"hopper\"\nstart = [1, 7]\ngoal = [10, 2]\nplanner = \"greedy\"",
        "\"rover\"\nstart = [5, 5]",
        "\"rover\"\nstart = [6, 2]\nplanner = \"spiral\"",
        "\"helicopter\"\nstart = [0, 0]\nspeed_mps = 5.0\nbudget_m = 30.0\nview_radius_m = 3.0",
    ];
    let world = resolved(&(ground.to_owned() + &robots.map(robot).concat()));
    let (mut met, mut goals) = (0, 0);
    for seed in 0..40 {
        let (flown, records) = fly(&world, seed, &own_planners(&world));
        goals += usize::from(flown.state.status == Status::Goal);
        let robots = world.brief.robots.iter();
        let mut cells: Vec<Option<Cell>> =
            robots.map(|robot| robot.body.is_on_ground().then_some(robot.start.cell)).collect();
        for record in &records {
            let own = usize::from(record.robot.0);
            let outcome = record.outcome;
            let strays = matches!(outcome.branch, Branch::Left | Branch::Right);
            met += usize::from(strays && outcome.to == outcome.from);
            if cells[own].is_some() {
                cells[own] = Some(outcome.to);
                let sharing = cells.iter().filter(|cell| **cell == Some(outcome.to)).count();
                assert_eq!(sharing, 1, "seed {seed}, decision {}", record.decision);
            }
        }
    }
    assert!(goals > 20, "{goals} of 40 missions reach all goals");
    assert!(met > 0, "a hop strayed onto another robot");
}

/// P-MIXED-SIXTEEN: Sixteen robots of all kinds fly in one mission, and a fault of a robot that is
/// not required ends only its own part.
#[test]
fn sixteen_robots_fly_and_a_fault_of_one_that_is_not_needed_ends_its_part_only() {
    let mut text = EXPEDITION.replace("[guard]", "[[faults]]\nrobot = 6\naction = 3\n\n[guard]");
    for robot in 0..10 {
        let (x, y) = (40 + 2 * robot, 20 + 16 * robot);
        let goal = format!("goal = [{}, {}]", x + 3, y + 2);
        text += &format!(
            "\n[[robots]]\nbody = \"hopper\"\nstart = [{x}, {y}]\n{goal}\nrequired = {}\n",
            robot > 0
        );
    }
    let world = resolved(&text);
    let (flown, records) = fly(&world, 1, &own_planners(&world));
    assert_eq!((flown.state.status, robots_of(&records).len()), (Status::Goal, 16));
    let failed: Vec<&Record> = records.iter().filter(|record| record.robot == RobotId(6)).collect();
    assert_eq!((failed.len(), failed[2].outcome.branch), (3, Branch::Stranded));
    assert!(!records.iter().any(|record| record.action == Action::Hold), "nobody needed to stand still");
    let mut arbiter = Arbiter::new(mission(&world, 1), records.last(), Pace::Max, 0, MonotonicNs(0));
    arbiter.recall_routes(flown.routes.iter().cloned());
    arbiter.recall(&records);
    let standing = |robot: usize| arbiter.team().unwrap().members[robot].standing;
    assert_eq!((standing(6), standing(15)), (Standing::Stranded, Standing::Done));
}

/// P-MIXED-DESIGN. A hopper sees as far as its own sensor reaches, and its planner uses its own
/// law.
#[test]
fn a_hopper_sees_as_far_as_its_own_sensor_and_plans_by_its_own_law() {
    let ground = "[truth.terrain.obstacles]\nwidth_cells = 20\nheight_cells = 20\ncell_size_m = 1.0\npercent = 0.0\nseed = 0\n\
        [[truth.sand.rectangles]]\nx = [5, 6]\ny = [14, 16]\n[brief]\nprofile = \"hopper\"\n";
    let hopper = |y: i32, more: &str| {
        format!(
            "[[robots]]\nbody = \"hopper\"\nstart = [4, {y}]\ngoal = [7, {y}]\nplanner = \"astar\"\n{more}\n"
        )
    };
    let further = "sensor = { gain = 4.0 }";
    let world = resolved(&format!("{ground}{}{}", hopper(4, ""), hopper(15, further)));
    let (flown, _) = fly(&world, 1, &own_planners(&world));
    let is_seen = |x: i32, y: i32| flown.map.ground(Cell::new(x, y)).is_some();
    assert!(is_seen(4, 2) && !is_seen(1, 4), "2 m, as [robot.sensor] says");
    assert!(is_seen(0, 15) && is_seen(4, 19), "4 m, by its own sensor");
    // Sand in the way: by the law of [robot] it is worth going around; to whom sand is as good as rock it is not.
    let crosses = |more: &str| {
        let world = resolved(&format!("{ground}{}", hopper(15, &format!("{further}\n{more}"))));
        let (_, records) = fly(&world, 1, &own_planners(&world));
        records[0].action == Action::Hop(contract::Direction::East)
            && records.iter().any(|record| record.outcome.to.x == 5 && record.outcome.to.y == 15)
    };
    let firm = "{ intended = 1.0, stuck = 0.0, sideways = 0.0, flights = 1 }";
    let bottomless = "{ intended = 0.01, stuck = 0.99, sideways = 0.0, flights = 2 }";
    assert!(crosses(&format!("hard = {firm}\nsand = {firm}")));
    assert!(!crosses(&format!("hard = {firm}\nsand = {bottomless}")));
}

const FLAT: &str = "[truth.terrain.obstacles]\nwidth_cells = 10\nheight_cells = 10\ncell_size_m = 1.0\npercent = 0.0\nseed = 1\n\
    [brief]\nprofile = \"hopper\"\n[limits]\nsteps_max = 300\n";

/// Ground of uncertain speed, 200 m on a side.
const WIDE: &str = "[truth.terrain.passages]\nseed = 1\n[brief]\nprofile = \"hopper\"\n\
    [limits]\nsteps_max = 300\n[guard]\nhazard_max = 0.25\n";

fn robot(text: &str) -> String {
    format!("[[robots]]\nbody = {text}\n")
}

/// Level ground on which a hop goes where it was meant to with that probability, and else to one side.
fn law(intended: f64) -> String {
    let sideways = (1.0 - intended) / 2.0;
    format!(
        "[robot.hard]\nintended = {intended:?}\nstuck = 0.0\nsideways = {sideways:?}\nflights = 1\n[brief]"
    )
}

fn fails(robot: usize) -> String {
    format!("[[faults]]\nrobot = {robot}\naction = 1\n")
}

/// P-MIXED-ROUND: A robot that stands in the way for good is passed by `mdp`, `astar`, `dstar_lite`
/// and every planner of rovers; nobody waits for a robot that will not move again.
#[test]
fn whoever_stands_in_the_way_is_passed_by() {
    let stopped =
        |x: i32, y: i32| robot(&format!("\"hopper\"\nstart = [{x}, {y}]\ngoal = [{y}, 9]\nrequired = false"));
    let hopper = |planner: &str| {
        let way = "\"hopper\"\nstart = [0, 5]\ngoal = [9, 5]\nplanner = ";
        let straight = FLAT.replace("[brief]", &law(1.0));
        [
            straight.as_str(),
            &robot(&format!("{way}{planner:?}")),
            &stopped(4, 5),
            &stopped(4, 6),
            &stopped(4, 4),
        ]
        .concat()
            + &[1, 2, 3].map(fails).concat()
    };
    let driver = |y: i32, planner: &str| {
        robot(&format!("\"driver\"\nstart = [8, {y}]\ngoal = [20, {y}]\nplanner = {planner:?}"))
    };
    let beside = |planner: &str| [WIDE, &driver(60, planner), &driver(61, planner)].concat();
    let stranded = |planner: &str| {
        let hopper = "\"hopper\"\nstart = [17, 60]\ngoal = [17, 70]\nrequired = false";
        [WIDE, &driver(60, planner), &robot(hopper), &fails(1)].concat()
    };
    let covering =
        robot("\"rover\"\nstart = [9, 1]\nheading = \"south\"\nplanner = \"spiral\"\ngoal = { cover = 2 }");
    let far = "\"driver\"\nstart = [8, 60]\ngoal = [192, 150]\nplanner = \"rrt_star_ett\"";
    let slow = "\"helicopter\"\nstart = [8, 60]\nspeed_mps = 0.1\nplanner = \"rrt_star_it\"";
    let around = "\"rover\"\nstart = [10, 100]\nrequired = false";
    let idle = "\"hopper\"\nstart = [60, 62]\ngoal = [60, 63]\nplanner = \"hold\"\nrequired = false";
    let ahead = "\"helicopter\"\nstart = [60, 70]\nspeed_mps = 5.0\nplanner = \"scout_ahead\"";
    let missions = [
        ("a wall of hoppers, mdp", hopper("mdp")),
        ("a wall of hoppers, astar", hopper("astar")),
        ("a wall of hoppers, dstar_lite", hopper("dstar_lite")),
        ("neighbouring goals, rrt_star_ett", beside("rrt_star_ett")),
        ("neighbouring goals, ett_exact", beside("ett_exact")),
        ("neighbouring goals, rrt_star", beside("rrt_star")),
        ("a hopper on the way, rrt_star_ett", stranded("rrt_star_ett")),
        ("a hopper on the way, ett_exact", stranded("ett_exact")),
        (
            "a rover that would be done on the goal of a hopper",
            [FLAT, &covering, &robot("\"hopper\"\nstart = [0, 9]\ngoal = [8, 1]")].concat(),
        ),
        (
            "a helicopter that looks ahead for a hopper",
            [WIDE, &robot(far), &robot(idle), &robot(ahead)].concat(),
        ),
        (
            "a rover that waits while another covers ground",
            [WIDE, &robot(slow), &robot(far), &robot(around)].concat(),
        ),
    ];
    for (what, text) in missions {
        let world = resolved(&text);
        let (flown, records) = fly(&world, 1, &own_planners(&world));
        assert_eq!(flown.state.status, Status::Goal, "{what}: {} decisions", records.len());
    }
}

/// Level ground in two parts, 40 x 15 cells, that a corridor one cell wide joins from (15, 7) to (25, 7).
fn corridor() -> String {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    let raster = |name: &str, open: &str, wall: &str| {
        let cell = |x: i32, y: i32| if (15..=25).contains(&x) && y != 7 { wall } else { open };
        let rows = (0..15).rev().map(|y| (0..40).map(|x| cell(x, y)).collect::<Vec<_>>().join(" "));
        let head = "ncols 40\nnrows 15\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
        let file = folder.join(name);
        std::fs::write(&file, head.to_owned() + &rows.collect::<Vec<_>>().join("\n") + "\n").unwrap();
        file.to_str().unwrap().to_owned()
    };
    let (level, closed, open) =
        (raster("level.asc", "0", "0"), raster("closed.asc", "0", "1"), raster("open.asc", "1", "0"));
    format!(
        "[truth.terrain.elevation_file]\nfile = {level:?}\n[truth.mobility]\nspeeds = [{closed:?}, 0.0, 0.0, {open:?}]\n\
         [brief]\nprofile = \"hopper\"\n[limits]\nsteps_max = 600\n"
    )
}

/// P-MIXED-BUSY: A robot that is in the way while it acts is passed or waited for, and waiting uses
/// up no action.
#[test]
fn whoever_is_busy_in_the_way_is_passed_by_or_waited_for() {
    let ground = corridor();
    let driver = |from: [i32; 2], to: [i32; 2], planner: &str| {
        robot(&format!("\"driver\"\nstart = {from:?}\ngoal = {to:?}\nplanner = {planner:?}"))
    };
    let hopper = |from: [i32; 2], to: [i32; 2], planner: &str| {
        robot(&format!("\"hopper\"\nstart = {from:?}\ngoal = {to:?}\nplanner = {planner:?}"))
    };
    let covering = robot("\"rover\"\nstart = [10, 7]\nplanner = \"cover_frontier\"\ngoal = { cover = 60 }");
    let mut missions = Vec::new();
    for planner in ["mdp", "astar", "dstar_lite"] {
        let slow =
            robot("\"rover\"\nstart = [5, 5]\nspeed_mps = 0.001\nplanner = \"spiral\"\nrequired = false");
        let text = FLAT.replace("[brief]", &law(1.0)) + &slow + &hopper([1, 5], [9, 5], planner);
        missions.push((format!("a rover that stands for a quarter of an hour, {planner}"), text, 40));
    }
    for planner in ["rrt_star", "rrt_star_ett", "ett_exact"] {
        let there = driver([5, 7], [35, 7], planner);
        let text = [&ground, &hopper([20, 12], [20, 7], "mdp"), &there].map(String::as_str).concat();
        missions.push((format!("the goal of a hopper in the corridor, {planner}"), text, 60));
        let stopped = hopper([20, 7], [20, 12], "mdp") + "required = false\n";
        let text = [&ground, &there, &stopped, &fails(1)].map(String::as_str).concat();
        missions.push((format!("a hopper that has failed in the corridor, {planner}"), text, 60));
        let behind = driver([12, 7], [38, 5], planner);
        let text = [&ground, &driver([14, 7], [35, 7], planner), &behind].map(String::as_str).concat();
        missions.push((format!("a rover behind another in the corridor, {planner}"), text, 60));
    }
    let ahead = driver([14, 7], [38, 7], "rrt_star") + "required = false\n";
    let text = [&ground, &ahead, &covering].map(String::as_str).concat();
    missions.push(("a covering rover behind another in the corridor".to_owned(), text, 600));
    for (what, text, steps_max) in missions {
        let world = resolved(&text);
        let (flown, records) = fly(&world, 1, &own_planners(&world));
        assert_eq!(flown.state.status, Status::Goal, "{what}: {} decisions", records.len());
        assert!(flown.state.steps < steps_max, "{what}: {} steps", flown.state.steps);
    }
}

/// P-MIXED-TAKEN: A mission fails once another robot occupies the goal of a required hopper for
/// good.
#[test]
fn a_goal_that_is_taken_for_good_ends_a_mission_that_needs_it() {
    let hopper = |way: &str| robot(&format!("\"hopper\"\n{way}\nplanner = \"mdp\""));
    let first = hopper("start = [5, 9]\ngoal = [5, 1]");
    let second = hopper("start = [3, 1]\ngoal = [7, 1]\nrequired = false");
    let fault = "[[faults]]\nrobot = 1\naction = 3\n";
    let text = [FLAT, &first, &second, fault].concat().replace("[brief]", &law(1.0));
    let world = resolved(&text);
    let (flown, records) = fly(&world, 1, &own_planners(&world));
    let last = records.last().unwrap();
    assert_eq!(
        (flown.state.status, last.robot, last.outcome.to),
        (Status::Deadlock, RobotId(1), Cell::new(5, 1))
    );
}

/// P-MIXED-LATTICE: A hopper that was stopped by another robot is still whole hops away from its
/// goal.
#[test]
fn a_hopper_that_was_stopped_is_still_whole_hops_away_from_its_goal() {
    let ground = FLAT.replace("[brief]", "[robot]\nhop_distance_m = 2.0\n[brief]");
    let hopper = |start: [i32; 2], goal: [i32; 2]| {
        robot(&format!("\"hopper\"\nstart = {start:?}\ngoal = {goal:?}\nplanner = \"astar\""))
    };
    let text = [&ground, &hopper([0, 0], [8, 8]), &hopper([2, 0], [6, 8]), &hopper([0, 2], [8, 6])];
    let world = resolved(&text.map(String::as_str).concat());
    let mut stopped = 0;
    for seed in 0..60 {
        let (_, records) = fly(&world, seed, &own_planners(&world));
        let stays_on_map = |record: &&Record| world.brief.grid.contains(record.outcome.to);
        for record in records.iter().filter(stays_on_map) {
            let (from, to) = (record.outcome.from, record.outcome.to);
            assert_eq!(((to.x - from.x) % 2, (to.y - from.y) % 2), (0, 0), "seed {seed}: {from} to {to}");
            let strays = matches!(record.outcome.branch, Branch::Left | Branch::Right);
            stopped += usize::from(strays && from == to);
        }
    }
    assert!(stopped > 0, "a hop strayed onto another robot");
}

/// P-MIXED-OFF-MAP: A hopper that has left the map occupies no cell.
#[test]
fn who_has_left_the_map_takes_up_no_cell() {
    let hopper = |x: i32| {
        robot(&format!(
            "\"hopper\"\nstart = [{x}, 0]\ngoal = [{}, 0]\nplanner = \"greedy\"\nrequired = false",
            x + 7
        ))
    };
    let waiting = robot("\"hopper\"\nstart = [9, 9]\ngoal = [9, 8]\nplanner = \"hold\"");
    let text = [FLAT, "[guard]\nhazard_max = 1.0\n", &hopper(1), &hopper(0), &waiting].concat();
    let world = resolved(&text.replace("[brief]", &law(0.2)));
    let mut left = BTreeSet::new();
    for seed in 0..40 {
        let (_, records) = fly(&world, seed, &own_planners(&world));
        let grid = world.brief.grid;
        let gone: Vec<Cell> =
            records.iter().map(|record| record.outcome.to).filter(|cell| !grid.contains(*cell)).collect();
        left.insert(gone.len());
        if let [first, second] = gone[..] {
            left.insert(if first == second { 99 } else { 2 });
        }
    }
    assert!(left.contains(&99), "two hoppers left the map at one place: {left:?}");
}
