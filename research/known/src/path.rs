//! The path of a policy: its intended moves from the start.

use std::fmt;

use contract::{Cell, Soil};
use serde::Serialize;

use crate::{Hop, Model, Solution, World};

/// How a path ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// At the goal.
    Arrives,
    /// It comes back to a cell it has been in: there is no path.
    Loops,
    /// It leaves the map.
    Leaves,
    /// It comes to a cell where no hop is offered.
    Stands,
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Ending::Arrives => "arrives",
            Ending::Loops => "loops",
            Ending::Leaves => "leaves the map",
            Ending::Stands => "stands",
        })
    }
}

/// What a path runs over; means are over its cells, start and end included.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Path {
    /// Its cells from the start on; a loop's last cell is its first repeated one.
    pub cells: Vec<Cell>,
    /// The hop out of each cell but the last.
    pub hops: Vec<Hop>,
    /// How it ends.
    pub ending: Ending,
    /// Height of each cell, metres.
    pub heights_m: Vec<f64>,
    /// Steepness |∇h| of each cell, metres per metre.
    pub slopes: Vec<f64>,
    /// Mean height, metres.
    pub mean_height_m: f64,
    /// Mean steepness |∇h|, metres per metre.
    pub mean_slope: f64,
    /// Cells on sand.
    pub sand_cells: usize,
}

impl Path {
    /// Follows the policy of `solution`.
    #[must_use]
    pub fn follow(world: &World, model: &Model, solution: &Solution) -> Self {
        let mut seen = vec![false; model.cells()];
        let (mut cells, mut hops) = (vec![world.start], Vec::new());
        let mut at = world.grid.index(world.start).expect("a start on the map");
        let ending = loop {
            if world.grid.cell(at) == world.goal {
                break Ending::Arrives;
            }
            if std::mem::replace(&mut seen[at], true) {
                break Ending::Loops;
            }
            let Some(choice) = solution.policy[at] else { break Ending::Stands };
            let next = model.landings[choice][0].index;
            hops.push(model.choices[choice].hop);
            if next == model.cells() {
                hops.pop();
                break Ending::Leaves;
            }
            cells.push(world.grid.cell(next));
            at = next;
        };
        let ground: Vec<_> = cells.iter().map(|cell| world.at(*cell).expect("a path on the map")).collect();
        let heights_m: Vec<f64> = ground.iter().map(|ground| ground.height_m).collect();
        let slopes: Vec<f64> = ground.iter().map(|ground| ground.steepness()).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        Self {
            mean_height_m: mean(&heights_m),
            mean_slope: mean(&slopes),
            sand_cells: ground.iter().filter(|ground| ground.soil == Soil::Sand).count(),
            heights_m,
            slopes,
            cells,
            hops,
            ending,
        }
    }

    /// Whether there is a path: the policy's intended moves lead from the start to the goal.
    #[must_use]
    pub fn arrives(&self) -> bool {
        self.ending == Ending::Arrives
    }

    /// The cells from which it hops vertically.
    pub fn ups(&self) -> impl Iterator<Item = Cell> + '_ {
        self.cells.iter().zip(&self.hops).filter(|(_, hop)| hop.is_up()).map(|(cell, _)| *cell)
    }
}
