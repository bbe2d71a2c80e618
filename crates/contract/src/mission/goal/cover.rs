//! The goal of robots that visit ground.

use serde::{Deserialize, Serialize};

use super::GoalKind;
use crate::block::Block;
use crate::codec::whole;
use crate::mission::kind::Kind;

/// How much ground rovers shall visit, and who visits which: the same for all robots of a mission that have this goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cover {
    /// Share of the cells that can be reached, 1 to 100 %.
    pub percent: u32,
    /// How the rovers share the ground.
    pub mode: CoverMode,
}

impl Default for Cover {
    fn default() -> Self {
        Self { percent: 100, mode: CoverMode::Overlap }
    }
}

/// Which ground a rover covers (Laîné & Yoshida 2019, section 2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CoverMode {
    /// All rovers cover all ground together ("path overlapping").
    #[default]
    Overlap,
    /// Each rover keeps to the cells that are nearest to its start ("environment sharing").
    Voronoi,
}

impl Kind for Cover {
    const NAME: &'static str = "cover";

    fn parameters(&mut self, block: &mut Block<'_>) {
        block.whole(
            "percent",
            "Share of the cells that can be reached, %.",
            whole(1, 100),
            &mut self.percent,
        );
        let all = [CoverMode::Overlap, CoverMode::Voronoi];
        block.choice("mode", "0 all together, 1 each the cells nearest to its start.", &all, &mut self.mode);
    }
}

impl GoalKind for Cover {
    fn cover(&self) -> Option<Cover> {
        Some(*self)
    }
}
