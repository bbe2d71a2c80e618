//! One cell of terrain on the wire.

use bytemuck::{Pod, Zeroable};

use super::{Wire, flag, gradient, length, tag};
use crate::{Ground, Refusal, Soil};

/// One cell; all zeros is a cell nobody has seen.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GroundV1 {
    /// Height above the datum, metres.
    pub height_m: f64,
    /// Gradient (∂h/∂x, ∂h/∂y), metres per metre.
    pub gradient: [f64; 2],
    /// 0 unseen, 1 hard, 2 sand.
    pub soil: u32,
    /// 1 where the hopper survives landing.
    pub passable: u32,
}

const _: () = assert!(size_of::<GroundV1>() == 32);

impl Wire for GroundV1 {
    const NAME: &'static str = "hop.Ground.v1";
}

impl GroundV1 {
    /// A cell nobody has seen.
    pub const UNSEEN: GroundV1 = GroundV1 { height_m: 0.0, gradient: [0.0; 2], soil: 0, passable: 0 };
}

impl From<Option<&Ground>> for GroundV1 {
    #[inline]
    fn from(ground: Option<&Ground>) -> Self {
        ground.map_or(Self::UNSEEN, |ground| Self {
            height_m: ground.height_m,
            gradient: ground.gradient,
            soil: match ground.soil {
                Soil::Hard => 1,
                Soil::Sand => 2,
            },
            passable: u32::from(ground.passable),
        })
    }
}

impl TryFrom<&GroundV1> for Option<Ground> {
    type Error = Refusal;

    #[inline]
    fn try_from(wire: &GroundV1) -> Result<Self, Refusal> {
        if *wire == GroundV1::UNSEEN {
            return Ok(None);
        }
        Ok(Some(Ground {
            height_m: length("ground.height_m", wire.height_m)?,
            gradient: gradient("ground.gradient", wire.gradient)?,
            soil: tag("ground.soil", wire.soil, |code| match code {
                1 => Some(Soil::Hard),
                2 => Some(Soil::Sand),
                _ => None,
            })?,
            passable: flag("ground.passable", wire.passable)?,
        }))
    }
}
