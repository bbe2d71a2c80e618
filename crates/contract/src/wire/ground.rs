//! One cell of terrain on the wire.

use bytemuck::{Pod, Zeroable};

use super::{Wire, flag, gradient, length, tag};
use crate::{Ground, Refusal, Soil};

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GroundV1 {
    /// Height above the datum, metres.
    pub height_m: f64,
    /// Gradient (∂h/∂x, ∂h/∂y), metres per metre.
    pub gradient: [f64; 2],
    /// 1 hard, 2 sand.
    pub soil: u32,
    /// 1 where the hopper survives landing.
    pub passable: u32,
}

const _: () = assert!(size_of::<GroundV1>() == 32);

impl Wire for GroundV1 {
    const NAME: &'static str = "hop.Ground.v1";
}

impl From<&Ground> for GroundV1 {
    #[inline]
    fn from(ground: &Ground) -> Self {
        Self {
            height_m: ground.height_m,
            gradient: ground.gradient,
            soil: match ground.soil {
                Soil::Hard => 1,
                Soil::Sand => 2,
            },
            passable: u32::from(ground.passable),
        }
    }
}

impl TryFrom<&GroundV1> for Ground {
    type Error = Refusal;

    #[inline]
    fn try_from(wire: &GroundV1) -> Result<Self, Refusal> {
        Ok(Self {
            height_m: length("ground.height_m", wire.height_m)?,
            gradient: gradient("ground.gradient", wire.gradient)?,
            soil: tag("ground.soil", wire.soil, |code| match code {
                1 => Some(Soil::Hard),
                2 => Some(Soil::Sand),
                _ => None,
            })?,
            passable: flag("ground.passable", wire.passable)?,
        })
    }
}
