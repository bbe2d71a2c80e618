//! A policy as arrows of points around the robot that it is for.

use contract::{Action, Brief, Cell, Direction, ObservedMap, Policy};
use report::colour;

use super::middle;
use super::point_cloud::{Cloud, Point};

/// Farthest cell from the robot with an arrow, in columns and rows: a policy may have hundreds of thousands of cells.
const REACH_CELLS: i32 = 24;

/// Points of an arrow, in cells from the middle of its own: along it, and to its left.
const ARROW: [(f64, f64); 7] =
    [(-0.3, 0.0), (-0.15, 0.0), (0.0, 0.0), (0.15, 0.0), (0.3, 0.0), (0.15, 0.12), (0.15, -0.12)];

/// Height of an arrow above the ground, cells.
const ABOVE_CELLS: f64 = 0.1;

/// Adds the arrows of seen cells not far from `around`.
pub(super) fn arrows(cloud: &mut Cloud, brief: &Brief, map: &ObservedMap, policy: &Policy, around: Cell) {
    for y in around.y.saturating_sub(REACH_CELLS)..=around.y.saturating_add(REACH_CELLS) {
        for x in around.x.saturating_sub(REACH_CELLS)..=around.x.saturating_add(REACH_CELLS) {
            let cell = Cell { x, y };
            let action = brief.grid.index(cell).and_then(|index| policy.cells.get(index));
            let Some((Action::Hop(direction) | Action::Up(direction) | Action::Step(direction), ground)) =
                action.map(|cell| cell.action).zip(map.ground(cell))
            else {
                continue;
            };
            arrow(cloud, brief, middle(brief, cell, ground.height_m), direction);
        }
    }
}

fn arrow(cloud: &mut Cloud, brief: &Brief, middle: Point, direction: Direction) {
    let size_m = brief.grid.cell_size_m;
    let ((dx, dy), (left_x, left_y)) = (direction.step(), direction.left().step());
    for (along, aside) in ARROW {
        let offset =
            |forward: i32, left: i32| size_m * (along * f64::from(forward) + aside * f64::from(left));
        let at = Point {
            x: middle.x + offset(dx, left_x),
            y: middle.y + offset(dy, left_y),
            z: middle.z + ABOVE_CELLS * size_m,
        };
        cloud.push(at, colour::rgb(colour::arrow(direction)));
    }
}
