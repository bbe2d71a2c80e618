//! Makes a failing mission small: fewer robots, less ground, milder rules.

use scenario::{GuardRules, RobotRules, Scenario, TerrainSource};

use super::trial::Broken;
use super::{Draft, Kind};

/// Missions that may be flown to make one small.
const TRIES_MAX: usize = 200;

/// The smallest mission found in which the same promise does not hold. `fails` flies one.
pub fn shrink(draft: &Draft, promise: &str, mut fails: impl FnMut(&Draft) -> Option<Broken>) -> Draft {
    let mut smallest = draft.clone();
    let mut tries = 0;
    loop {
        let next = candidates(&smallest).into_iter().find(|candidate| {
            tries += 1;
            tries <= TRIES_MAX
                && candidate.world().is_some()
                && fails(candidate).is_some_and(|broken| broken.promise == promise)
        });
        match next {
            Some(next) => smallest = next,
            None => return smallest,
        }
    }
}

/// The mission with one thing less, in the order in which they are worth trying.
fn candidates(draft: &Draft) -> Vec<Draft> {
    let mut candidates = Vec::new();
    let mut less = |change: &dyn Fn(&mut Scenario)| {
        let mut candidate = draft.clone();
        change(&mut candidate.scenario);
        if candidate.scenario != draft.scenario {
            candidates.push(candidate);
        }
    };
    for robot in (0..draft.scenario.robots.len()).rev() {
        less(&|scenario| {
            scenario.robots.remove(robot);
            scenario.faults.retain(|fault| usize::from(fault.robot.0) != robot);
            for fault in &mut scenario.faults {
                fault.robot.0 -= u16::from(usize::from(fault.robot.0) > robot);
            }
        });
    }
    less(&|scenario| scenario.faults.clear());
    less(&|scenario| scenario.truth.sand = Default::default());
    less(&|scenario| scenario.truth.treasures.clear());
    less(&|scenario| scenario.guard = GuardRules::default());
    less(&|scenario| scenario.robot.sensor = Default::default());
    less(&|scenario| {
        let hop_distance_m = scenario.robot.hop_distance_m;
        scenario.robot = scenario::Robot { hop_distance_m, ..Default::default() };
    });
    less(&|scenario| {
        scenario.brief.goals.pop();
    });
    less(&|scenario| {
        if !scenario.brief.goals.is_empty() {
            scenario.brief.hops_max = scenario.brief.hops_max.div_ceil(2);
        }
    });
    less(&|scenario| scenario.limits.steps_max = scenario.limits.steps_max.div_ceil(2));
    less(&|scenario| {
        for rules in &mut scenario.robots {
            if let RobotRules::Rover(rules) = rules {
                rules.goal.cover = rules.goal.cover.div_ceil(2);
            }
        }
    });
    less(&|scenario| match &mut scenario.truth.terrain {
        TerrainSource::RandomHills(hills) => hills.hills /= 2,
        TerrainSource::Obstacles(obstacles) => obstacles.percent = (obstacles.percent / 2.0).floor(),
        _ => {}
    });
    for (columns, rows) in [(1, 0), (0, 1)] {
        less(&|scenario| {
            let (width, height) = match &mut scenario.truth.terrain {
                TerrainSource::RandomHills(hills) => (&mut hills.width_cells, &mut hills.height_cells),
                TerrainSource::Obstacles(obstacles) => {
                    (&mut obstacles.width_cells, &mut obstacles.height_cells)
                }
                _ => return,
            };
            if *width > columns + 1 && *height > rows + 1 {
                *width -= columns;
                *height -= rows;
            }
        });
    }
    if matches!(draft.kind, Kind::Hopper | Kind::Patrol) && draft.planner.as_str() != "greedy" {
        candidates.push(Draft { planner: "greedy".parse().expect("a name"), ..draft.clone() });
    }
    candidates
}
