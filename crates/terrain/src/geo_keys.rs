//! The GeoKeys of a GeoTIFF (OGC 19-008, chapter 7): which coordinate system its numbers are in.

use std::collections::BTreeMap;

use crate::TerrainError;
use crate::raster_header::PixelIs;

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const CITATION: u16 = 1026;
const GEOGRAPHIC_SYSTEM: u16 = 2048;
const SEMI_MAJOR_AXIS: u16 = 2057;
const PROJECTED_SYSTEM: u16 = 3072;
const PROJECTED_CITATION: u16 = 3073;
const LINEAR_UNITS: u16 = 3076;
const VERTICAL_UNITS: u16 = 4099;
const METRE: u16 = 9001;
const USER_DEFINED: u16 = 32767;
/// Tag of the numbers that keys with fractions point into.
const NUMBERS_TAG: u16 = 34736;
/// Tag of the text that citations are cut from.
const TEXT_TAG: u16 = 34737;

/// Equatorial radius of the Earth (WGS 84), metres. Geographic systems with a code of EPSG are all the Earth's.
pub(crate) const EARTH_RADIUS_M: f64 = 6_378_137.0;

/// The keys with short integer values, and the citation that names the coordinate system.
#[derive(Debug, Default)]
pub(crate) struct GeoKeys {
    shorts: BTreeMap<u16, u16>,
    /// Semi-major axis of the ellipsoid, metres.
    semi_major_m: Option<f64>,
    citation: Option<String>,
}

impl GeoKeys {
    /// Reads the key directory: a header of four shorts, then four per key (key, tag, count, value).
    pub fn new(directory: &[u64], numbers: &[f64], text: &str) -> Result<Self, TerrainError> {
        let malformed = |need: &str, got: String| TerrainError::Malformed {
            what: "GeoKeyDirectory",
            need: need.into(),
            got,
        };
        let [1, _, _, count, keys @ ..] = directory else {
            return Err(malformed(
                "a header of version 1",
                format!("{:?}", &directory[..directory.len().min(4)]),
            ));
        };
        if (keys.len() as u64) < count.saturating_mul(4) {
            return Err(malformed(
                &format!("{count} keys of four numbers"),
                format!("{} numbers", keys.len()),
            ));
        }
        let mut result = Self::default();
        for key in keys.chunks_exact(4).take(*count as usize) {
            let [id, tag, length, value] = [key[0], key[1], key[2], key[3]].map(|number| number as u16);
            match tag {
                0 => {
                    result.shorts.insert(id, value);
                }
                NUMBERS_TAG if id == SEMI_MAJOR_AXIS => {
                    let radius_m = numbers.get(usize::from(value)).copied();
                    result.semi_major_m = radius_m.filter(|radius_m| (1.0..1e9).contains(radius_m));
                }
                TEXT_TAG if id == PROJECTED_CITATION || id == CITATION && result.citation.is_none() => {
                    let (start, length) = (usize::from(value), usize::from(length));
                    let cited = text.get(start..(start + length).min(text.len())).unwrap_or_default();
                    let cited = cited.trim_matches(|c: char| c == '|' || c.is_whitespace() || c.is_control());
                    if !cited.is_empty() {
                        result.citation = Some(cited.into());
                    }
                }
                _ => {}
            }
        }
        Ok(result)
    }

    /// Whether tie points refer to corners or middles of cells; corners by default.
    pub fn pixel_is(&self) -> PixelIs {
        if self.shorts.get(&RASTER_TYPE) == Some(&2) { PixelIs::Point } else { PixelIs::Area }
    }

    /// The coordinate system in words; `None` if the keys name none.
    pub fn coordinate_system(&self) -> Result<Option<String>, TerrainError> {
        let code = |key| self.shorts.get(&key).copied();
        let named = |kind: &str, key| {
            let citation = self.citation.as_ref().map_or(String::new(), |text| format!(" ({text})"));
            match code(key) {
                Some(code) if code != 0 && code != USER_DEFINED => format!("{kind}, EPSG:{code}{citation}"),
                _ => format!("{kind}, user-defined{citation}"),
            }
        };
        let degrees = || {
            let is_earth = code(GEOGRAPHIC_SYSTEM).is_some_and(|code| code != 0 && code != USER_DEFINED);
            TerrainError::Degrees {
                got: named("geographic", GEOGRAPHIC_SYSTEM),
                radius_m: self.semi_major_m.or(is_earth.then_some(EARTH_RADIUS_M)),
                centre_deg: None,
            }
        };
        let projected = match code(MODEL_TYPE) {
            Some(1) => true,
            Some(2) => return Err(degrees()),
            Some(3) => {
                return Err(TerrainError::Unsupported {
                    what: "coordinate system",
                    need: "a projected one in metres",
                    got: "a geocentric one".into(),
                    remedy: "reproject it with gdalwarp -t_srs",
                });
            }
            _ if code(PROJECTED_SYSTEM).is_some() => true,
            _ if code(GEOGRAPHIC_SYSTEM).is_some() => return Err(degrees()),
            _ => false,
        };
        for (what, key) in [("unit of coordinates", LINEAR_UNITS), ("unit of heights", VERTICAL_UNITS)] {
            if let Some(unit) = code(key).filter(|&unit| unit != METRE && unit != 0) {
                return Err(TerrainError::Unsupported {
                    what,
                    need: "metres (EPSG:9001)",
                    got: format!("EPSG:{unit}"),
                    remedy: "convert it with gdalwarp -t_srs to a system in metres",
                });
            }
        }
        Ok(projected.then(|| named("projected", PROJECTED_SYSTEM)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(keys: &[u64], numbers: &[f64]) -> String {
        GeoKeys::new(keys, numbers, "").unwrap().coordinate_system().unwrap_err().to_string()
    }

    #[test]
    fn degrees_are_to_be_projected_with_the_radius_of_their_own_body() {
        let mars = refusal(&[1, 1, 0, 2, 1024, 0, 1, 2, 2057, 34736, 1, 0], &[3_396_190.0]);
        assert!(mars.contains("+R=3396190 +units=m"), "{mars}");
        let earth = refusal(&[1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326], &[]);
        assert!(earth.contains("+ellps=WGS84 +units=m") && !earth.contains("+R="), "{earth}");
        let unknown = refusal(&[1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 32767], &[]);
        assert!(unknown.contains("+R=RADIUS") && unknown.contains("3396190 of Mars"), "{unknown}");
    }
}
