//! The path of a policy: its intended hops from the start.

use std::fmt;

use contract::{Cell, Soil};
use serde::Serialize;

use crate::{Hop, KnownMap, Model, Solution};

/// How a path ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PathEnd {
    /// It reaches the goal.
    Arrives,
    /// It returns to a cell it has visited: there is no path.
    Loops,
    /// It leaves the map.
    Leaves,
    /// It reaches a cell where no hop is possible.
    Stands,
}

impl fmt::Display for PathEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            PathEnd::Arrives => "arrives",
            PathEnd::Loops => "loops",
            PathEnd::Leaves => "leaves the map",
            PathEnd::Stands => "stands",
        })
    }
}

/// A path with the terrain under it. Means are over its cells, start and end included.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Path {
    /// Cells from the start on; the last cell of a loop is the first repeated one.
    pub cells: Vec<Cell>,
    /// The hop out of each cell but the last.
    pub hops: Vec<Hop>,
    /// Whether it reached the goal, or why it went no further.
    pub ending: PathEnd,
    /// Height of each cell, metres.
    pub heights_m: Vec<f64>,
    /// Steepness |∇h| of each cell, metres per metre.
    pub slopes: Vec<f64>,
    /// Mean height of its cells above the datum, metres.
    pub mean_height_m: f64,
    /// Mean steepness |∇h|, metres per metre.
    pub mean_slope: f64,
    /// Number of cells that are sand.
    pub sand_cells: usize,
}

impl Path {
    /// Follows the policy of `solution`.
    #[must_use]
    pub fn follow(map: &KnownMap, model: &Model, solution: &Solution) -> Self {
        let mut seen = vec![false; model.cells()];
        let (mut cells, mut hops) = (vec![map.start], Vec::new());
        let mut at = map.grid.index(map.start).expect("a start on the map");
        let ending = loop {
            if map.grid.cell(at) == map.goal {
                break PathEnd::Arrives;
            }
            if std::mem::replace(&mut seen[at], true) {
                break PathEnd::Loops;
            }
            let Some(choice) = solution.policy[at] else { break PathEnd::Stands };
            let next = model.landings[choice][0].index;
            hops.push(model.choices[choice].hop);
            if next == model.cells() {
                hops.pop();
                break PathEnd::Leaves;
            }
            cells.push(map.grid.cell(next));
            at = next;
        };
        let ground: Vec<_> = cells.iter().map(|cell| map.at(*cell).expect("a path on the map")).collect();
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

    /// Whether the intended hops lead from the start to the goal.
    #[must_use]
    pub fn arrives(&self) -> bool {
        self.ending == PathEnd::Arrives
    }

    /// Cells that it leaves by a vertical hop.
    pub fn ups(&self) -> impl Iterator<Item = Cell> + '_ {
        self.cells.iter().zip(&self.hops).filter(|(_, hop)| hop.is_up()).map(|(cell, _)| *cell)
    }
}
