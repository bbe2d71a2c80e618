//! What has been seen so far.

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3;

use crate::{Cell, Decision, Grid, Ground, MonotonicNs, RobotId, RunId, Soil};

/// The observed map: every cell either seen, or unknown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObservedMap {
    /// The run.
    pub run: RunId,
    /// The robot whose sensor built it.
    pub robot: RobotId,
    /// The last decision whose pose is folded in; `None` while nothing is.
    pub through: Option<Decision>,
    /// Counts publications of one perception process.
    pub sequence: u64,
    /// When the pose of `through` was folded in.
    pub sensed: MonotonicNs,
    /// When it was published.
    pub published: MonotonicNs,
    /// The lattice.
    pub grid: Grid,
    /// Cells in index order, `None` where unseen.
    pub cells: Vec<Option<Ground>>,
    /// Cells with treasures that have been seen and not yet collected, in index order.
    pub treasures: Vec<Cell>,
}

impl ObservedMap {
    /// A map of `grid` on which nothing has been seen.
    #[must_use]
    pub fn unseen(run: RunId, robot: RobotId, grid: Grid) -> Self {
        Self {
            run,
            robot,
            through: None,
            sequence: 0,
            sensed: MonotonicNs(0),
            published: MonotonicNs(0),
            grid,
            cells: vec![None; grid.cells()],
            treasures: Vec::new(),
        }
    }

    /// What is known of `cell`; `None` where unseen or outside.
    #[must_use]
    pub fn ground(&self, cell: Cell) -> Option<&Ground> {
        self.cells[self.grid.index(cell)?].as_ref()
    }

    /// Number of seen cells.
    #[must_use]
    pub fn seen_cells(&self) -> usize {
        self.cells.iter().flatten().count()
    }

    /// Share of the map seen, 0 to 1.
    #[must_use]
    pub fn coverage(&self) -> f64 {
        self.seen_cells() as f64 / self.cells.len() as f64
    }

    /// Fingerprint (XXH3-64) of what is known: equal for equal cells, whoever built the map and when.
    #[must_use]
    pub fn observation(&self) -> u64 {
        let mut hasher = Xxh3::new();
        for (index, ground) in self.cells.iter().enumerate() {
            let Some(ground) = ground else { continue };
            let mut bytes = [0; 30];
            bytes[..4].copy_from_slice(&(index as u32).to_le_bytes());
            bytes[4..12].copy_from_slice(&ground.height_m.to_bits().to_le_bytes());
            bytes[12..20].copy_from_slice(&ground.gradient[0].to_bits().to_le_bytes());
            bytes[20..28].copy_from_slice(&ground.gradient[1].to_bits().to_le_bytes());
            bytes[28] = u8::from(ground.soil == Soil::Sand);
            bytes[29] = u8::from(ground.passable);
            hasher.update(&bytes);
        }
        for treasure in &self.treasures {
            hasher.update(&treasure.x.to_le_bytes());
            hasher.update(&treasure.y.to_le_bytes());
        }
        hasher.digest()
    }
}
