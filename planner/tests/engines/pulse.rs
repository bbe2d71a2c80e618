//! A long plan gives signs of life as its work goes on.

use std::cell::Cell as Counter;

use contract::{Cell, Decision, Profile};
use planner::{Budget, Pulse, algorithm};

use crate::world::{PROFILES, Soils, World};

/// P-PULSE: A planner sends heartbeats during a long plan as its work proceeds.
#[test]
fn a_long_plan_beats_as_its_work_goes_on() {
    let world = World::flat(120, Cell::new(0, 0), Cell::new(119, 119), Profile::Hopper);
    let map = world.unseen();
    let state = world.state(world.leg.start, Decision(0), 0);
    let situation = world.situation(&map, &state);
    // Under a bound on its work the MDP counts sweeps, without one backups.
    for (name, stride, work_max) in [
        ("mdp", 48, Some(u64::MAX)),
        ("mdp", 100 * world.leg.grid.cells() as u64, None),
        ("astar", Pulse::STRIDE, None),
        ("dstar_lite", Pulse::STRIDE, None),
    ] {
        let beats = Counter::new(0);
        let beat = || beats.set(beats.get() + 1);
        let budget = Budget { work_max, pulse: Pulse::new(&beat) };
        let plan = algorithm(name).unwrap().plan(&situation, &budget);
        assert!(beats.get() >= plan.work / stride, "{name}: {} beats for {} units", beats.get(), plan.work);
        assert!(beats.get() > 0 && plan.work > 0, "{name} works long here: {} units", plan.work);
        assert_eq!(algorithm(name).unwrap().plan(&situation, &Budget::of(work_max)), plan, "{name}");
    }
}

/// P-PULSE. An online model that continues from what it knows sends heartbeats too.
#[test]
fn a_session_beats_whenever_it_works_on_news() {
    for profile in PROFILES {
        let world = World::paper(Soils::Heterogeneous, [0.5, 0.5], profile);
        let mut mdp = algorithm("mdp").unwrap();
        let mut worked = 0;
        let mut map = world.unseen();
        let mut cell = world.leg.start;
        for decision in 0..16 {
            cell = Cell::new(cell.x + 1, cell.y + decision % 2);
            world.sense(&mut map, cell);
            let state = world.state(cell, Decision(decision as u64), 0);
            let situation = world.situation(&map, &state);
            let beats = Counter::new(0);
            let beat = || beats.set(beats.get() + 1);
            let plan = mdp.plan(&situation, &Budget { work_max: None, pulse: Pulse::new(&beat) });
            assert!(beats.get() > 0 || plan.work == 0, "decision {decision}: {} units in silence", plan.work);
            worked += u64::from(plan.work > 0);
        }
        assert!(worked > 8, "{worked} decisions took work");
    }
}
