//! What one cell of terrain is like.

use std::num::NonZeroU8;

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

impl Soil {
    /// All soils, in the order of their codes.
    pub const ALL: [Soil; 2] = [Soil::Hard, Soil::Sand];

    /// The name in scenarios and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Soil::Hard => "hard",
            Soil::Sand => "sand",
        }
    }
}

/// How fast a driving rover gets on in a cell: one of the four speeds of Folsom et al. 2021.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveSpeed {
    /// 0 m/Sol: a rover that enters is stuck.
    Zero,
    /// 50 m/Sol.
    Slow,
    /// 150 m/Sol.
    Medium,
    /// 200 m/Sol.
    Fast,
}

impl DriveSpeed {
    /// All speeds, rising.
    pub const ALL: [DriveSpeed; 4] =
        [DriveSpeed::Zero, DriveSpeed::Slow, DriveSpeed::Medium, DriveSpeed::Fast];
}

/// Height, slope and soil of one cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ground {
    /// Height above the brief's datum, metres.
    pub height_m: f64,
    /// Height gradient (∂h/∂x, ∂h/∂y), metres per metre, x east and y north.
    pub gradient: [f64; 2],
    /// Decides how far a hop from here may stray.
    pub soil: Soil,
    /// Whether the hopper survives landing here: not nodata, not steeper than the slope limit.
    pub passable: bool,
    /// How fast a rover drives here; only where speeds are uncertain beforehand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<DriveSpeed>,
    /// What a camera that errs reads for the speed. On a map it stands alone until a rover has driven here; in the truth,
    /// where some camera errs, it stands beside the speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reading: Option<DriveSpeed>,
    /// What sensors report of the cell beside its ground, the highest so far; what it means is for the sensor to say. The truth has
    /// none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reported: Option<NonZeroU8>,
}

impl Ground {
    /// Flat hard ground at the datum: what a planner assumes of a cell nobody has seen.
    pub const FLAT: Ground = Ground {
        height_m: 0.0,
        gradient: [0.0, 0.0],
        soil: Soil::Hard,
        passable: true,
        speed: None,
        reading: None,
        reported: None,
    };

    /// Whether a rover that goes from cell to cell can stand here: as a hopper, and not where a rover gets stuck.
    #[must_use]
    pub fn is_drivable(&self) -> bool {
        self.passable && self.speed != Some(DriveSpeed::Zero)
    }

    /// Steepness |∇h|, metres per metre.
    #[must_use]
    pub fn steepness(&self) -> f64 {
        let [gx, gy] = self.gradient;
        (gx * gx + gy * gy).sqrt()
    }
}
