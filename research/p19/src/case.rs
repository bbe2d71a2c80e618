//! What rovers cover, and who they are.

use std::fmt;

use coverage::{Algorithm, CoverMode};
use serde::Serialize;

/// A square world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ground {
    /// Cells to a side.
    pub side: u32,
    /// Share of the cells that are obstacles.
    pub obstacle_percent: f64,
}

/// The paper's world, as far as it is known: 10 % is the specification's choice, and the paper's sizes are not printed.
pub const PAPER: Ground = Ground { side: 20, obstacle_percent: 10.0 };

/// Who covers what.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Case {
    /// Size of the worlds, and their share of obstacles.
    #[serde(flatten)]
    pub ground: Ground,
    /// Planner of all rovers.
    pub algorithm: Algorithm,
    /// How they share the ground.
    pub mode: CoverMode,
    /// Number of rovers, with random starts and headings.
    pub rovers: usize,
}

impl Case {
    /// The mode as files have it.
    pub fn mode_name(&self) -> &'static str {
        match self.mode {
            CoverMode::Overlap => "overlap",
            CoverMode::Voronoi => "voronoi",
        }
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { ground: Ground { side, obstacle_percent }, algorithm, rovers, .. } = self;
        let mode = self.mode_name();
        write!(f, "{algorithm} {mode} {rovers} on {side}x{side} with {obstacle_percent} %")
    }
}
