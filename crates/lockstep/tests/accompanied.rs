//! A hopper with a helicopter that looks ahead for it, through the turns of all processes.

use contract::{Action, Branch, Brief, Decision, MonotonicNs, Record, RobotId, RunId, Status};
use hopper_sim::{Arbiter, Mission, Pace};
use lockstep::{Flown, PlannerSchedule};
use scenario::{Overrides, ResolvedScenario, Scenario};

const HELICOPTER: RobotId = RobotId(1);

fn world(changes: &[(&str, &str)]) -> ResolvedScenario {
    let mut text = include_str!("../../../scenarios/hopper-scout.toml").to_owned();
    for (old, new) in changes {
        assert!(text.contains(old), "{old}");
        text = text.replace(old, new);
    }
    Scenario::parse(&text, "test").unwrap().with(&Overrides::default()).resolve().unwrap()
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
    let names: Vec<_> = world.planners.iter().flatten().copied().collect();
    PlannerSchedule::of_robots(&names)
}

/// P-GOLDEN.
#[test]
fn the_built_in_scenario_keeps_its_digest() {
    let world = world(&[]);
    let (flown, records) = fly(&world, 1, &own_planners(&world));
    assert_eq!((flown.state.status, records.len()), (Status::Goal, 158));
    assert_eq!(
        flown.state.digest.to_string(),
        "33ef51a6026898dcba64bf7026c021ac17820ea56b86e5179d2fc3ffed45b8d5"
    );
}

/// P-ACCOMPANIED: What a helicopter sees ahead saves a hopper steps. Pose, steps and status in the
/// state are the hopper's, whichever robot acted.
#[test]
fn who_sees_ahead_needs_fewer_steps_and_state_and_pose_are_the_hoppers() {
    let (with, alone) = (world(&[]), scenario::load("large").unwrap().resolve().unwrap());
    let (mut saved, mut flights) = (0, 0);
    for seed in 1..=20 {
        let (flown, records) = fly(&with, seed, &own_planners(&with));
        let (unaided, _) = fly(&alone, seed, &PlannerSchedule::single("mdp".parse().unwrap()));
        assert_eq!((flown.state.status, unaided.state.status), (Status::Goal, Status::Goal), "seed {seed}");
        assert_eq!(flown.state.pose.cell, with.brief.leg(0).goal);
        saved += unaided.state.steps as i64 - flown.state.steps as i64;
        let mut pose = with.brief.leg(0).start;
        for record in &records {
            if record.robot == HELICOPTER {
                assert_eq!(record.pose.cell, pose, "decision {}", record.decision);
                flights += usize::from(record.action == Action::Fly);
            } else {
                assert_eq!(record.outcome.from, pose, "decision {}", record.decision);
                pose = record.pose.cell;
            }
        }
    }
    assert!(saved > 20 * 15, "{saved} steps in 20 missions");
    assert!(flights > 20 * 10, "{flights} flights");
}

/// P-ACCOMPANIED-LAW: Planners of hopper and helicopter fly the same mission if they are replaced
/// by fresh ones at every decision.
#[test]
fn fresh_planners_at_every_decision_fly_the_same_mission() {
    for profile in ["paper-2023", "hopper"] {
        let world = world(&[("paper-2023", profile)]);
        let (flown, records) = fly(&world, 3, &own_planners(&world));
        let (again, _) = fly(&world, 3, &PlannerSchedule::relieved(&records));
        assert_eq!(again.state.steps, flown.state.steps, "{profile}");
        assert_eq!(again.map.observation(), flown.map.observation(), "{profile}");
    }
}

/// P-ACCOMPANIED-RECALL: An arbiter that resumes a journal of hopper and helicopter at any record
/// has both robots where they were, with the helicopter's spent budget.
#[test]
fn an_arbiter_that_recalls_the_records_has_the_robots_where_they_were() {
    let world = world(&[]);
    let (flown, records) = fly(&world, 2, &own_planners(&world));
    for count in [1, 2, 7, 40, records.len() - 1] {
        let mut arbiter =
            Arbiter::new(mission(&world, 2), Some(&records[count - 1]), Pace::Max, 0, MonotonicNs(0));
        arbiter.recall_routes(flown.routes.iter().cloned());
        arbiter.recall(&records[..count]);
        let team = arbiter.team().unwrap();
        assert_eq!(team.due, records[count].robot, "after {count} decisions");
        let at = |robot: RobotId| team.member(robot).unwrap().at.cell;
        let own = |robot| records[..count].iter().rev().find(|record: &&Record| record.robot == robot);
        let start = world.brief.leg(0).start;
        assert_eq!(at(RobotId(0)), own(RobotId(0)).map_or(start, |record| record.outcome.to));
        assert_eq!(at(HELICOPTER), own(HELICOPTER).map_or(start, |record| record.outcome.to));
        let flown_m = team.member(HELICOPTER).unwrap().travel.unwrap().flown_m;
        let legs = records[..count].iter().filter(|record| record.robot == HELICOPTER);
        let expected: f64 = legs.map(|record| record.outcome.flight.range_m).sum();
        assert!((flown_m - expected).abs() < 1e-9, "{flown_m} m, {expected} m");
    }
}

/// P-ACCOMPANIED-FAULT: If the helicopter fails, the hopper continues alone; a hopper that fails
/// ends the mission as lost.
#[test]
fn a_helicopter_that_fails_leaves_the_hopper_to_go_on() {
    let failing = |robot: u16| {
        let start = "[[robots]]\nbody = \"hopper\"";
        let fault = format!("[[faults]]\nrobot = {robot}\naction = 3\n\n{start}");
        let world = world(&[(start, &fault)]);
        fly(&world, 1, &own_planners(&world))
    };
    let (flown, records) = failing(1);
    assert_eq!(flown.state.status, Status::Goal);
    let of_helicopter: Vec<_> = records.iter().filter(|record| record.robot == HELICOPTER).collect();
    assert_eq!(of_helicopter.len(), 3);
    assert_eq!(of_helicopter[2].outcome.branch, Branch::Stranded);
    let (flown, records) = failing(0);
    assert_eq!(flown.state.status, Status::Lost);
    let last = records.last().unwrap();
    assert_eq!((last.robot, last.outcome.branch), (RobotId(0), Branch::Stranded));
}

/// P-ACCOMPANIED-PATROL: A patrol with a helicopter has as many hops as a patrol without one.
#[test]
fn a_patrol_with_a_helicopter_has_as_many_hops_as_one_alone() {
    let patrol = "goals = [[48, 48], [1, 2], [48, 2]]\nhops_max = 120";
    let world = world(&[("goal = [48, 48]", patrol)]);
    let (flown, records) = fly(&world, 1, &own_planners(&world));
    assert_eq!(flown.state.status, Status::Goal);
    let hops = records.iter().filter(|record| record.robot != HELICOPTER).count();
    assert_eq!(hops, 120);
    assert!(records.len() > 130, "{} decisions", records.len());
}

/// P-ACCOMPANIED-PATROL.
#[test]
fn the_limit_of_steps_ends_neither_a_patrol_nor_its_helicopter() {
    let patrol = "goals = [[48, 48], [1, 2], [48, 2]]\nhops_max = 120";
    let world = world(&[("goal = [48, 48]", patrol), ("steps_max = 800", "steps_max = 8")]);
    let (flown, records) = fly(&world, 1, &own_planners(&world));
    assert_eq!(flown.state.status, Status::Goal);
    let flights = records.iter().filter(|record| record.robot == HELICOPTER).count();
    assert!(flights > 8, "{flights} actions of the helicopter");
}

/// P-ACCOMPANIED-BUDGET: A hopper's helicopter flies no farther than its budget.
#[test]
fn a_helicopter_flies_no_farther_than_its_budget() {
    for budget_m in [0.0, 0.5, 12.0, 33.3] {
        let world = world(&[("budget_m = 150.0", &format!("budget_m = {budget_m:?}"))]);
        let (flown, records) = fly(&world, 1, &own_planners(&world));
        assert_eq!(flown.state.status, Status::Goal, "{budget_m} m");
        let legs = records.iter().filter(|record| record.robot == HELICOPTER);
        let flown_m: f64 = legs.map(|record| record.outcome.flight.range_m).sum();
        assert!(flown_m <= budget_m + 1e-6 && flown_m + 1.0 >= budget_m, "{flown_m} of {budget_m} m");
        let last = records.iter().rev().find(|record| record.robot == HELICOPTER).unwrap();
        assert_eq!(last.action, Action::Done);
        assert_eq!(flown.refusals.0.values().sum::<u64>(), 0);
        assert!(records[0].decision == Decision(0));
    }
}
