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
    /// 1 hard, 2 sand, plus 16 for each speed of [`DriveSpeed::ALL`] up to the cell's, plus 128 and 4 times
    /// the number of a camera's reading there; see `soil_code`.
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
        let (soil, speed, reading) = soil_from_code("ground.soil", wire.soil)?;
        Ok(Self {
            height_m: length("ground.height_m", wire.height_m)?,
            gradient: gradient("ground.gradient", wire.gradient)?,
            soil,
            passable: flag("ground.passable", wire.passable)?,
            speed,
            reading,
        })
    }
}

/// Soil, speed and reading of a cell in one number of 8 bits: 1 hard, 2 sand, plus 16, 32, 48 or 64 where the cell has a
/// speed, plus 128, 132, 136 or 140 where it has a reading.
#[inline]
pub(super) fn soil_code(ground: &Ground) -> u32 {
    let soil = match ground.soil {
        Soil::Hard => 1,
        Soil::Sand => 2,
    };
    let speed = ground.speed.map_or(0, |speed| 16 * (speed as u32 + 1));
    soil + speed + ground.reading.map_or(0, |reading| 128 + 4 * reading as u32)
}

/// What [`soil_code`] stands for.
#[inline]
pub(super) fn soil_from_code(
    field: &str,
    code: u32,
) -> Result<(Soil, Option<DriveSpeed>, Option<DriveSpeed>), Refusal> {
    let soil = tag(field, code, |code| match code % 4 {
        1 => Some(Soil::Hard),
        2 => Some(Soil::Sand),
        _ => None,
    })?;
    let speed = match code / 16 % 8 {
        0 => None,
        number => Some(tag(field, code, |_| DriveSpeed::ALL.get(number as usize - 1).copied())?),
    };
    let reading = match (code / 128, code / 4 % 4) {
        (0, 0) => None,
        (1, number) => Some(tag(field, code, |_| DriveSpeed::ALL.get(number as usize).copied())?),
        _ => Some(tag(field, code, |_| None)?),
    };
    Ok((soil, speed, reading))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soil_speed_and_reading_survive_their_code_and_no_other_code_is_one() {
        let speeds = || DriveSpeed::ALL.map(Some).into_iter().chain([None]);
        let mut codes = Vec::new();
        for (speed, reading) in speeds().flat_map(|speed| speeds().map(move |reading| (speed, reading))) {
            for soil in [Soil::Hard, Soil::Sand] {
                let code = soil_code(&Ground { soil, speed, reading, ..Ground::FLAT });
                assert_eq!(soil_from_code("soil", code), Ok((soil, speed, reading)));
                codes.push(code);
            }
        }
        assert!(codes.contains(&1) && codes.contains(&2), "those without a speed are as before");
        for code in (0..1000).chain([u32::MAX]).filter(|code| !codes.contains(code)) {
            assert!(soil_from_code("soil", code).is_err(), "{code}");
        }
    }
}
