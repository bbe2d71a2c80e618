//! One cell of terrain on the wire.

use bytemuck::{Pod, Zeroable};

use super::{Wire, flag, gradient, length, tag};
use crate::{DriveSpeed, Ground, Refusal, Soil};

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GroundV2 {
    /// Height above the datum, metres.
    pub height_m: f64,
    /// Gradient (∂h/∂x, ∂h/∂y), metres per metre.
    pub gradient: [f64; 2],
    /// 1 hard, 2 sand, plus 16 for each speed of [`DriveSpeed::ALL`] up to the cell's; see `soil_code`.
    pub soil: u32,
    /// 1 where the hopper survives landing.
    pub passable: u32,
}

const _: () = assert!(size_of::<GroundV2>() == 32);

impl Wire for GroundV2 {
    const NAME: &'static str = "hop.Ground.v2";
}

impl From<&Ground> for GroundV2 {
    #[inline]
    fn from(ground: &Ground) -> Self {
        Self {
            height_m: ground.height_m,
            gradient: ground.gradient,
            soil: soil_code(ground),
            passable: u32::from(ground.passable),
        }
    }
}

impl TryFrom<&GroundV2> for Ground {
    type Error = Refusal;

    #[inline]
    fn try_from(wire: &GroundV2) -> Result<Self, Refusal> {
        let (soil, speed) = soil_from_code("ground.soil", wire.soil)?;
        Ok(Self {
            height_m: length("ground.height_m", wire.height_m)?,
            gradient: gradient("ground.gradient", wire.gradient)?,
            soil,
            passable: flag("ground.passable", wire.passable)?,
            speed,
        })
    }
}

/// Soil and speed of a cell in one number: 1 hard, 2 sand, plus 16, 32, 48 or 64 where the cell has a speed.
#[inline]
pub(super) fn soil_code(ground: &Ground) -> u32 {
    let soil = match ground.soil {
        Soil::Hard => 1,
        Soil::Sand => 2,
    };
    soil + 16 * ground.speed.map_or(0, |speed| speed as u32 + 1)
}

/// What [`soil_code`] stands for.
#[inline]
pub(super) fn soil_from_code(field: &str, code: u32) -> Result<(Soil, Option<DriveSpeed>), Refusal> {
    let soil = tag(field, code, |code| match code % 16 {
        1 => Some(Soil::Hard),
        2 => Some(Soil::Sand),
        _ => None,
    })?;
    let speed = match code / 16 {
        0 => None,
        speed => Some(tag(field, code, |_| DriveSpeed::ALL.get(speed as usize - 1).copied())?),
    };
    Ok((soil, speed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soil_and_speed_survive_their_code_and_no_other_code_is_one() {
        let speeds = DriveSpeed::ALL.map(Some).into_iter().chain([None]);
        let mut codes = Vec::new();
        for speed in speeds {
            for soil in [Soil::Hard, Soil::Sand] {
                let code = soil_code(&Ground { soil, speed, ..Ground::FLAT });
                assert_eq!(soil_from_code("soil", code), Ok((soil, speed)));
                codes.push(code);
            }
        }
        assert!(codes.contains(&1) && codes.contains(&2), "those without a speed are as before");
        for code in (0..300).chain([u32::MAX]).filter(|code| !codes.contains(code)) {
            assert!(soil_from_code("soil", code).is_err(), "{code}");
        }
    }
}
