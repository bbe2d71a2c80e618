//! Where robots shall go.

use contract::{Brief, Cell, Goal, Grid, Robot};
use hopper_sim::Mission;

use super::body;

/// The cell to which `robot` is to go after so many visits, if it goes to cells.
pub(super) fn goal_cell(grid: &Grid, robot: &Robot, visits: u64) -> Option<Cell> {
    match robot.goal {
        Goal::Reach(reach) => {
            let along = |metres: f64| (metres / grid.cell_size_m).floor() as i32;
            Some(Cell::new(along(reach.at.x_m), along(reach.at.y_m)))
        }
        Goal::Visit(visit) => Some(visit.goals()[visits as usize % visit.goals().len()]),
        Goal::Cover(_) | Goal::LookAhead(_) => None,
    }
}

/// Where hoppers go, which rovers that cover ground keep off.
pub(super) fn goals_of_hoppers(mission: &Mission) -> Vec<Cell> {
    let Brief { robots, grid, .. } = &mission.brief;
    let hoppers = robots.iter().filter(|robot| body::of(robot).hops());
    hoppers.filter_map(|robot| goal_cell(grid, robot, 0)).collect()
}
