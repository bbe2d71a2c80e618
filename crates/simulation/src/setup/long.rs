//! Missions of many decisions, whose pasts need several pages: one seed in [`ONE_IN`].

use contract::limits::PAST_PAGE_RECORDS;
use contract::{Cover, Goal, Grid, Guard, Limits, Visit};
use hopper_sim::Mission;
use terrain::Terrain;

use super::{Missions, Setup};
use crate::chance::Chance;

/// One seed in so many has long missions.
const ONE_IN: u64 = 64;

/// Hops from goal to goal, and actions of a robot at most.
const ACTIONS_MAX: u64 = 1_200;

/// Actions of each robot at most, where the fallback takes most of its first actions.
const ROBOT_ACTIONS_MAX: u64 = 320;

/// Until when a decision has to be taken in missions that slow planners make long, nanoseconds.
const DEADLINE_NS: u64 = 20_000_000;

/// How many plans of such a planner take how long, nanoseconds: most of its first decisions are those of the fallback.
const SLOW: (u64, u64) = (90, 70_000_000);

/// Whether the missions of a seed are long.
pub(crate) fn is_long(seed: u64) -> bool {
    seed % ONE_IN == ONE_IN - 1
}

/// The columns and rows of a map that rovers cover in a long mission.
pub(super) fn covered_grid() -> Grid {
    Grid::new(22, 17, 1.0, 1).expect("a small grid is a grid")
}

/// Makes the mission of one seed long.
pub(super) fn lengthen(missions: Missions, seed: u64, number: u64, mission: &mut Mission) {
    let mut chance = Chance::new(seed ^ number.rotate_left(32), "long");
    let brief = &mut mission.brief;
    brief.limits = Limits { steps_max: ACTIONS_MAX, ..brief.limits };
    match missions {
        Missions::Hopper | Missions::Accompanied | Missions::Protocol => {
            // Nothing ends the visits early.
            let hops = chance.between(500, 900);
            let hopper = &mut brief.robots[0];
            let goal = hopper.goal.cell(&brief.grid, 0).expect("a hopper goes to cells");
            let visit = Visit::new(&[goal, hopper.start.cell], hops).expect("start and goal differ");
            hopper.goal = Goal::Visit(visit);
            brief.guard = Guard { hazard_max: 0.0, ..brief.guard };
            let mut terrain: Terrain = (*mission.terrain).clone();
            terrain.cells.iter_mut().for_each(|ground| ground.passable = true);
            mission.terrain = terrain.into();
        }
        Missions::Scouts | Missions::Mixed => {
            brief.guard.deadline_ns = DEADLINE_NS;
            brief.limits.steps_max = ROBOT_ACTIONS_MAX;
        }
        Missions::Rovers => {
            for robot in brief.robots.iter_mut() {
                if let Goal::Cover(Cover { percent, .. }) = &mut robot.goal {
                    *percent = 100;
                }
            }
        }
    }
    mission.faults.iter_mut().for_each(|fault| fault.action += 150);
    if missions == Missions::Accompanied {
        mission.faults.retain(|fault| fault.robot.0 > 0);
    }
}

/// The setup of a long mission: pages as large as real ones.
pub(super) fn setup(setup: Setup) -> Setup {
    let is_made_long = [Missions::Scouts, Missions::Mixed].contains(&setup.missions);
    Setup {
        page_records: PAST_PAGE_RECORDS,
        page_cells: 512,
        pace: contract::Pace::Max,
        slow: if is_made_long { SLOW } else { (0, 0) },
        ..setup
    }
}
