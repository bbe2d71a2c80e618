//! Robots of any kind, each with a task of its own, through the turns of all processes.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

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
    let brief = Brief { run: RunId(1), ..world.brief };
    Mission { brief, terrain: world.terrain.clone(), seed, fleet: world.fleet.clone() }
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
    let names = planner::assigned(&world.brief, &world.vehicles(), None, &world.planners).unwrap();
    PlannerSchedule::of_robots(&names)
}

fn robots_of(records: &[Record]) -> BTreeSet<u16> {
    records.iter().map(|record| record.robot.0).collect()
}

/// P-GOLDEN: the built-in scenario ends with the digest that it had when it was made.
#[test]
fn the_built_in_scenario_keeps_its_digest() {
    let world = resolved(EXPEDITION);
    let (flown, records) = fly(&world, 1, &own_planners(&world));
    assert_eq!((flown.state.status, records.len()), (Status::Goal, 578));
    assert_eq!(robots_of(&records).len(), 6, "every robot acts");
    assert_eq!(
        flown.state.digest.to_string(),
        "12ef672e13d941e6b6cfc4643720bb169a517ee0b8b0ee7226a842b9a0c0a0c3"
    );
}

/// P-MIXED-LAW: planners that are replaced by fresh ones of the same algorithm at every decision fly the same mission.
#[test]
fn fresh_planners_at_every_decision_fly_the_same_mission() {
    let world = resolved(EXPEDITION);
    let (flown, records) = fly(&world, 3, &own_planners(&world));
    let (again, _) = fly(&world, 3, &PlannerSchedule::relieved(&records));
    assert_eq!(again.state.digest, flown.state.digest);
    assert_eq!(again.map.observation(), flown.map.observation());
}

/// P-MIXED-RECALL: whoever takes up the journal anywhere has the robots where they were.
#[test]
fn an_arbiter_that_recalls_the_records_has_the_robots_where_they_were() {
    let world = resolved(EXPEDITION);
    let (flown, records) = fly(&world, 2, &own_planners(&world));
    let starts: Vec<Cell> =
        world.fleet.as_ref().unwrap().robots.iter().map(|robot| robot.start.cell).collect();
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

/// P-MIXED-SWAP: each robot's planner can be swapped alone.
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

/// P-MIXED-COLLIDE: robots on the ground never share a cell, whatever kinds they are of, and hops that stray stop before others.
#[test]
fn robots_of_all_kinds_on_a_small_ground_never_share_a_cell() {
    let robot = |text: &str| format!("[[robots]]\nvehicle = {text}\n");
    let ground = "[truth.terrain.random_hills]\nwidth_cells = 12\nheight_cells = 10\ncell_size_m = 1.0\nseed = 4\nhills = 8\n\
        sigma_m = [2.0, 3.0]\namplitude_m = [0.05, 0.2]\n[mission]\nkind = \"mixed\"\n[brief]\nprofile = \"hopper\"\n\
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
        let fleet = &world.fleet.as_ref().unwrap().robots;
        let mut cells: Vec<Option<Cell>> =
            fleet.iter().map(|robot| robot.vehicle.is_on_ground().then_some(robot.start.cell)).collect();
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

/// P-MIXED-SIXTEEN: sixteen robots of all kinds fly, and the one that fails ends its own part only.
#[test]
fn sixteen_robots_fly_and_a_fault_of_one_that_is_not_needed_ends_its_part_only() {
    let mut text = EXPEDITION.replace("[guard]", "[[faults]]\nrobot = 6\naction = 3\n\n[guard]");
    for robot in 0..10 {
        let (x, y) = (40 + 2 * robot, 20 + 16 * robot);
        let goal = format!("goal = [{}, {}]", x + 3, y + 2);
        text += &format!(
            "\n[[robots]]\nvehicle = \"hopper\"\nstart = [{x}, {y}]\n{goal}\nrequired = {}\n",
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

/// P-MIXED-DESIGN: a hopper sees as far as its own sensor reaches, and its planner reckons with its own law.
#[test]
fn a_hopper_sees_as_far_as_its_own_sensor_and_plans_by_its_own_law() {
    let ground = "[truth.terrain.obstacles]\nwidth_cells = 20\nheight_cells = 20\ncell_size_m = 1.0\npercent = 0.0\nseed = 0\n\
        [[truth.sand.rectangles]]\nx = [5, 6]\ny = [14, 16]\n[mission]\nkind = \"mixed\"\n[brief]\nprofile = \"hopper\"\n";
    let hopper = |y: i32, more: &str| {
        format!(
            "[[robots]]\nvehicle = \"hopper\"\nstart = [4, {y}]\ngoal = [7, {y}]\nplanner = \"astar\"\n{more}\n"
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
