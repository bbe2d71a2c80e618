//! Robots of any kind, each with a task of its own, through the turns of all processes.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use contract::{Brief, MonotonicNs, Record, RunId};
use hopper_sim::Mission;
use lockstep::{Flown, PlannerSchedule};
use scenario::{Overrides, ResolvedScenario, Scenario};

fn world(changes: &[(&str, &str)]) -> ResolvedScenario {
    let mut text = include_str!("../../../scenarios/expedition.toml").to_owned();
    for (old, new) in changes {
        assert!(text.contains(old), "{old}");
        text = text.replace(old, new);
    }
    Scenario::parse(&text, "test").unwrap().with(&Overrides::default()).resolve().unwrap()
}

fn mission(world: &ResolvedScenario, seed: u64) -> Mission {
    let brief = Brief { run: RunId(1), ..world.brief };
    Mission { brief, terrain: world.terrain.clone(), seed, fleet: world.fleet.clone() }
}

fn fly(world: &ResolvedScenario, seed: u64, schedule: &PlannerSchedule) -> (Flown, Vec<Record>) {
    let mut records = Vec::new();
    let mut clock = || MonotonicNs(1);
    let observe = &mut |record: &Record| records.push(*record);
    let flown = lockstep::fly(mission(world, seed), schedule, &mut clock, observe).unwrap();
    (flown, records)
}

fn own_planners(world: &ResolvedScenario) -> PlannerSchedule {
    let names: Vec<_> = world.planners.iter().flatten().copied().collect();
    PlannerSchedule::of_robots(&names)
}

#[test]
fn look() {
    let world = world(&[]);
    let (flown, records) = fly(&world, 1, &own_planners(&world));
    println!("{:?} {} {:?}", flown.state.status, records.len(), flown.refusals);
    for robot in 0..6 {
        let of: Vec<_> = records.iter().filter(|record| record.robot.0 == robot).collect();
        let last = of.last().unwrap();
        println!(
            "robot {robot}: {} actions, last {:?} {:?} at {:?}",
            of.len(),
            last.action,
            last.outcome.branch,
            last.outcome.to
        );
    }
}
