//! One cell of terrain on the wire.

use super::declaration::wire;
use crate::codec::{Code, Codec, Ends, FLAG, GRADIENT, LENGTH, unknown_tag};
use crate::{DriveSpeed, Ground, Refusal, Soil};

wire! {
    /// The true ground of a cell.
    pub struct GroundV2 = "hop.Ground.v2", 32 bytes, refused as "ground" {
        /// Height above the datum, metres.
        height_m: f64 = LENGTH,
        /// Gradient (∂h/∂x, ∂h/∂y), metres per metre.
        gradient: [f64; 2] = GRADIENT,
        /// 1 hard, 2 sand, plus 16 for each speed of [`DriveSpeed::ALL`] up to the cell's, plus 128 and 4 times
        /// the number of a camera's reading there.
        soil: u32 = SOIL,
        /// 1 where a robot can stand.
        passable: u32 = FLAG,
    }
    of Ground { height_m, gradient, soil, passable, speed, reading, reported }
    to_wire {
        let soil = &(*soil, *speed, *reading);
    }
    from_wire(wire) {
        let (soil, speed, reading) = soil;
        let reported = None;
    }
}

/// Soil, speed and reading of a cell in one number of 8 bits: 1 hard, 2 sand, plus 16, 32, 48 or 64 where the cell has a
/// speed, plus 128, 132, 136 or 140 where it has a reading.
pub(super) struct SoilCode;

pub(super) const SOIL: SoilCode = SoilCode;

impl<W: Code> Codec<W> for SoilCode {
    type Value = (Soil, Option<DriveSpeed>, Option<DriveSpeed>);

    #[inline]
    fn to_wire(&self, &(soil, speed, reading): &Self::Value) -> W {
        let soil = match soil {
            Soil::Hard => 1,
            Soil::Sand => 2,
        };
        let speed = speed.map_or(0, |speed| 16 * (speed as u32 + 1));
        W::of(soil + speed + reading.map_or(0, |reading| 128 + 4 * reading as u32))
    }

    #[inline]
    fn from_wire(&self, field: &str, wire: W) -> Result<Self::Value, Refusal> {
        let code = wire.get();
        let refuse = || unknown_tag(field, code);
        let speed_of = |number: u32| DriveSpeed::ALL.get(number as usize).copied().ok_or_else(refuse);
        let soil = match code % 4 {
            1 => Soil::Hard,
            2 => Soil::Sand,
            _ => return Err(refuse()),
        };
        let speed = match code / 16 % 8 {
            0 => None,
            number => Some(speed_of(number - 1)?),
        };
        let reading = match (code / 128, code / 4 % 4) {
            (0, 0) => None,
            (1, number) => Some(speed_of(number)?),
            _ => return Err(refuse()),
        };
        Ok((soil, speed, reading))
    }

    fn range(&self) -> String {
        "1 or 2, plus 0, 16, 32, 48 or 64, plus 0, 128, 132, 136 or 140".into()
    }

    fn ends(&self) -> Ends<W> {
        let ends = |codes: &[u32]| codes.iter().map(|code| W::of(*code)).collect();
        Ends { inside: ends(&[1, 2, 66, 206]), outside: ends(&[0, 3, 5, 81, 255]) }
    }
}

/// As [`SoilCode`], with whether a robot can stand there: where none can, the lowest bit is the other one.
pub(super) struct SeenSoilCode;

pub(super) const SEEN_SOIL: SeenSoilCode = SeenSoilCode;

/// The code of soil, speed and reading (`hop.Ground.v2`) in that of a seen cell, and whether a robot can stand there.
#[must_use]
#[inline]
pub fn soil_of_seen(code: u8) -> (u8, bool) {
    let passable = matches!(code % 4, 1 | 2);
    (code ^ u8::from(!passable), passable)
}

/// The code of a seen cell, of which [`soil_of_seen`] makes these.
#[must_use]
#[inline]
pub fn seen_soil(soil: u8, passable: bool) -> u8 {
    soil ^ u8::from(!passable)
}

impl Codec<u8> for SeenSoilCode {
    type Value = (Soil, Option<DriveSpeed>, Option<DriveSpeed>, bool);

    #[inline]
    fn to_wire(&self, &(soil, speed, reading, passable): &Self::Value) -> u8 {
        seen_soil(SOIL.to_wire(&(soil, speed, reading)), passable)
    }

    #[inline]
    fn from_wire(&self, field: &str, wire: u8) -> Result<Self::Value, Refusal> {
        let (soil, passable) = soil_of_seen(wire);
        let told = SOIL.from_wire(field, soil);
        let (soil, speed, reading) = told.map_err(|_| unknown_tag(field, u32::from(wire)))?;
        Ok((soil, speed, reading, passable))
    }

    fn range(&self) -> String {
        "0 to 3, plus 0, 16, 32, 48 or 64, plus 0, 128, 132, 136 or 140".into()
    }

    fn ends(&self) -> Ends<u8> {
        Ends { inside: vec![1, 0, 2, 3, 66, 207], outside: vec![4, 5, 81, 255] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soil_speed_and_reading_survive_their_code_and_no_other_code_is_one() {
        let speeds = || DriveSpeed::ALL.map(Some).into_iter().chain([None]);
        let (mut codes, mut seen_codes) = (Vec::new(), Vec::new());
        for (speed, reading) in speeds().flat_map(|speed| speeds().map(move |reading| (speed, reading))) {
            for soil in [Soil::Hard, Soil::Sand] {
                let code = SOIL.to_wire(&(soil, speed, reading));
                assert_eq!(Codec::<u32>::from_wire(&SOIL, "soil", code), Ok((soil, speed, reading)));
                codes.push(code);
                for passable in [true, false] {
                    let seen = (soil, speed, reading, passable);
                    let code = SEEN_SOIL.to_wire(&seen);
                    assert_eq!(SEEN_SOIL.from_wire("soil", code), Ok(seen));
                    seen_codes.push(code);
                }
            }
        }
        assert!(codes.contains(&1) && codes.contains(&2), "those without a speed are as before");
        for code in (0..1000).chain([u32::MAX]).filter(|code| !codes.contains(code)) {
            assert!(Codec::<u32>::from_wire(&SOIL, "soil", code).is_err(), "{code}");
        }
        for code in (0..=u8::MAX).filter(|code| !seen_codes.contains(code)) {
            assert!(SEEN_SOIL.from_wire("soil", code).is_err(), "{code}");
        }
    }
}
