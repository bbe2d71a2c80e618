//! What one cell of terrain is like.

use serde::{Deserialize, Serialize};

/// The soil of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Soil {
    /// Firm ground: full hops.
    Hard,
    /// Loose regolith: half hops, more slip, a risk of staying stuck.
    Sand,
}

/// Height, slope and soil of one cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ground {
    /// Height above the brief's datum, metres.
    pub height_m: f64,
    /// Height gradient (∂h/∂x, ∂h/∂y), metres per metre, x east and y north.
    pub gradient: [f64; 2],
    /// Soil.
    pub soil: Soil,
    /// Whether the hopper survives landing here: not nodata, not steeper than the slope limit.
    pub passable: bool,
}

impl Ground {
    /// Flat hard ground at the datum: what a planner assumes of a cell nobody has seen.
    pub const FLAT: Ground = Ground { height_m: 0.0, gradient: [0.0, 0.0], soil: Soil::Hard, passable: true };

    /// Steepness |∇h|, metres per metre.
    #[must_use]
    pub fn steepness(&self) -> f64 {
        let [gx, gy] = self.gradient;
        (gx * gx + gy * gy).sqrt()
    }
}
