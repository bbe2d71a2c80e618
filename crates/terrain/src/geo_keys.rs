//! The GeoKeys of a GeoTIFF (OGC 19-008, chapter 7): which coordinate system its numbers are in.

use std::collections::BTreeMap;

use crate::TerrainError;
use crate::crs::{self, CoordinateSystem, EARTH_RADIUS_M, Heights, Identity, Kind};
use crate::raster_header::PixelIs;
use crate::unit::LengthUnit;

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const CITATION: u16 = 1026;
const GEOGRAPHIC_SYSTEM: u16 = 2048;
const SEMI_MAJOR_AXIS: u16 = 2057;
const PROJECTED_SYSTEM: u16 = 3072;
const PROJECTED_CITATION: u16 = 3073;
const LINEAR_UNITS: u16 = 3076;
const LINEAR_UNIT_SIZE: u16 = 3077;
const VERTICAL_SYSTEM: u16 = 4096;
const VERTICAL_CITATION: u16 = 4097;
const VERTICAL_UNITS: u16 = 4099;
const USER_DEFINED: u16 = 32767;
/// Tag of the numbers that keys with fractions point into.
const NUMBERS_TAG: u16 = 34736;
/// Tag of the text that citations are cut from.
const TEXT_TAG: u16 = 34737;

/// What ArcGIS writes in front of the well-known text that it puts into a citation.
const ESRI_TEXT: &str = "ESRI PE String =";

/// The keys with short integer values, and the texts that name the coordinate system.
#[derive(Debug, Default)]
pub(crate) struct GeoKeys {
    shorts: BTreeMap<u16, u16>,
    /// Semi-major axis of the ellipsoid, metres.
    semi_major_m: Option<f64>,
    /// Length of a user-defined unit, metres.
    linear_unit_m: Option<f64>,
    citation: Option<String>,
    /// Name of the vertical system.
    vertical_citation: Option<String>,
    /// ESRI's text of the whole coordinate system.
    text: Option<String>,
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
            let number = || numbers.get(usize::from(value)).copied();
            match tag {
                0 => {
                    result.shorts.insert(id, value);
                }
                NUMBERS_TAG if id == SEMI_MAJOR_AXIS => {
                    result.semi_major_m = number().filter(|radius_m| (1.0..1e9).contains(radius_m));
                }
                NUMBERS_TAG if id == LINEAR_UNIT_SIZE => result.linear_unit_m = number(),
                TEXT_TAG => {
                    let (start, length) = (usize::from(value), usize::from(length));
                    let cited = text.get(start..(start + length).min(text.len())).unwrap_or_default();
                    result.cite(id, cited);
                }
                _ => {}
            }
        }
        Ok(result)
    }

    fn cite(&mut self, id: u16, cited: &str) {
        let cited = cited.trim_matches(|c: char| c == '|' || c.is_whitespace() || c.is_control());
        let described = cited.split_once(ESRI_TEXT).map(|(_, text)| text);
        if let Some(text) = described {
            self.text = Some(text.into());
        } else if id == VERTICAL_CITATION {
            self.vertical_citation = if cited.is_empty() { None } else { Some(cited.into()) };
        } else if !cited.is_empty() && (id == PROJECTED_CITATION || id == CITATION && self.citation.is_none())
        {
            self.citation = Some(cited.into());
        }
    }

    /// Whether tie points refer to corners or middles of cells; corners by default.
    pub fn pixel_is(&self) -> PixelIs {
        if self.shorts.get(&RASTER_TYPE) == Some(&2) { PixelIs::Point } else { PixelIs::Area }
    }

    /// The code of a key, unless it is undefined or user-defined.
    fn code(&self, key: u16) -> Option<u64> {
        let code = self.shorts.get(&key).copied()?;
        if code == 0 || code == USER_DEFINED { None } else { Some(u64::from(code)) }
    }

    /// The coordinate system; `None` if the keys name none.
    pub fn coordinate_system(&self) -> Result<Option<CoordinateSystem>, TerrainError> {
        let of_code = self.code(PROJECTED_SYSTEM).and_then(crs::of_code);
        // A text that is not understood says no more than none: the keys speak for themselves.
        let of_text = self.text.as_deref().and_then(|text| CoordinateSystem::of_text(text).ok().flatten());
        let kind = self.kind(of_code.as_ref(), of_text.as_ref());
        let mut system = match kind {
            Some(Kind::Plane) => self.named(self.plane_in_words(), PROJECTED_SYSTEM, of_text.as_ref()),
            Some(Kind::Degrees { .. }) => self.named("geographic", GEOGRAPHIC_SYSTEM, of_text.as_ref()),
            Some(Kind::Geocentric) => self.named("geocentric", GEOGRAPHIC_SYSTEM, of_text.as_ref()),
            None if self.says_of_heights() || self.vertical_citation.is_some() => {
                self.named("of heights alone", VERTICAL_SYSTEM, of_text.as_ref())
            }
            None => return Ok(None),
        };
        system.kind = kind;
        if kind == Some(Kind::Plane) {
            system.unit = self.unit(of_code.as_ref(), of_text.as_ref())?;
        }
        let of_ellipsoid = of_code.as_ref().and_then(|system| system.radius_m);
        system.radius_m = match kind {
            Some(Kind::Degrees { radius_m }) => radius_m,
            _ => self
                .semi_major_m
                .or(of_ellipsoid)
                .or(of_text.as_ref().and_then(|system| system.radius_m))
                .or(self.code(GEOGRAPHIC_SYSTEM).map(|_| EARTH_RADIUS_M)),
        };
        let stated = [of_code, of_text]
            .into_iter()
            .flatten()
            .map(|system| system.heights)
            .find(|heights| *heights != Heights::default());
        system.heights = self.heights(stated.unwrap_or_default())?;
        Ok(Some(system))
    }

    fn kind(&self, of_code: Option<&CoordinateSystem>, of_text: Option<&CoordinateSystem>) -> Option<Kind> {
        let is_earth = self.code(GEOGRAPHIC_SYSTEM).is_some();
        let by_code = match of_code.and_then(|system| system.kind) {
            Some(Kind::Degrees { radius_m }) => radius_m,
            _ => is_earth.then_some(EARTH_RADIUS_M),
        };
        let degrees = Kind::Degrees { radius_m: self.semi_major_m.or(by_code) };
        // A code that stands for degrees is in degrees, whatever the model is called.
        let is_plane = !matches!(of_code.and_then(|system| system.kind), Some(Kind::Degrees { .. }));
        match self.shorts.get(&MODEL_TYPE) {
            Some(1) if is_plane => return Some(Kind::Plane),
            Some(1 | 2) => return Some(degrees),
            Some(3) => return Some(Kind::Geocentric),
            _ => {}
        }
        match of_text.and_then(|system| system.kind) {
            Some(Kind::Degrees { radius_m: None }) => return Some(degrees),
            Some(kind) => return Some(kind),
            None => {}
        }
        if self.shorts.contains_key(&PROJECTED_SYSTEM) {
            return Some(if is_plane { Kind::Plane } else { degrees });
        }
        // A length as the unit of coordinates is that of a plane, such as one local to a site.
        if self.shorts.contains_key(&LINEAR_UNITS) {
            return Some(Kind::Plane);
        }
        self.shorts.contains_key(&GEOGRAPHIC_SYSTEM).then_some(degrees)
    }

    fn plane_in_words(&self) -> &'static str {
        let is_projected =
            self.shorts.contains_key(&PROJECTED_SYSTEM) || self.shorts.get(&MODEL_TYPE) == Some(&1);
        if is_projected || self.text.is_some() { "projected" } else { "local" }
    }

    /// Whether they tell of a vertical system or unit.
    pub fn says_of_heights(&self) -> bool {
        [VERTICAL_SYSTEM, VERTICAL_UNITS].iter().any(|key| self.shorts.contains_key(key))
    }

    fn named(&self, kind: &str, key: u16, of_text: Option<&CoordinateSystem>) -> CoordinateSystem {
        let title = self.citation.as_deref().or(of_text.map(|system| system.name.as_str()));
        let citation = title.map_or(String::new(), |text| format!(" ({text})"));
        let identity = Identity {
            code: self.code(key).map(|code| format!("EPSG:{code}")),
            title: title.map(str::to_owned),
        };
        let code = match self.code(key) {
            Some(code) => format!("EPSG:{code}"),
            None => "user-defined".into(),
        };
        let name = format!("{kind}, {code}{citation}");
        CoordinateSystem {
            name,
            kind: None,
            unit: None,
            heights: Heights::default(),
            radius_m: None,
            identity,
        }
    }

    /// The unit of coordinates: that of its own key, of the system's code, or of the system's text.
    fn unit(
        &self,
        of_code: Option<&CoordinateSystem>,
        of_text: Option<&CoordinateSystem>,
    ) -> Result<Option<LengthUnit>, TerrainError> {
        let what = "unit of coordinates";
        let by_key = match self.shorts.get(&LINEAR_UNITS) {
            None | Some(0) => None,
            Some(&USER_DEFINED) => {
                let unit =
                    self.linear_unit_m.and_then(|metres| LengthUnit::of_length("user-defined unit", metres));
                Some(unit.ok_or_else(|| unknown_unit(what, "a user-defined one without its length"))?)
            }
            Some(&code) => Some(
                LengthUnit::of_epsg(u64::from(code)).ok_or_else(|| unknown_unit(what, &in_words(code)))?,
            ),
        };
        let by_code = of_code.and_then(|system| system.unit.clone());
        let by_text = of_text.and_then(|system| system.unit.clone());
        if by_key.is_none()
            && by_code.is_none()
            && by_text.is_none()
            && let Some(code) = self.code(PROJECTED_SYSTEM)
        {
            return Err(TerrainError::Unsupported {
                what,
                need: "a code of EPSG whose unit is known here, or the unit itself",
                got: format!("EPSG:{code}"),
                remedy: "write the unit into the file: gdal_translate IN.tif OUT.tif",
            });
        }
        agreed(what, [by_key, by_code, by_text])
    }

    fn heights(&self, stated: Heights) -> Result<Heights, TerrainError> {
        let what = "unit of heights";
        let of_system = self.code(VERTICAL_SYSTEM).map(crs::vertical);
        let by_key = match self.shorts.get(&VERTICAL_UNITS) {
            None | Some(0) => None,
            Some(&code) => Some(
                LengthUnit::of_epsg(u64::from(code)).ok_or_else(|| unknown_unit(what, &in_words(code)))?,
            ),
        };
        let downwards = stated.downwards || of_system.as_ref().is_some_and(|heights| heights.downwards);
        let by_system = of_system.and_then(|heights| heights.unit);
        let unit = agreed(what, [by_key, by_system, stated.unit])?;
        Ok(match (&unit, &self.vertical_citation) {
            (None, Some(name)) => Heights::cited(name, downwards),
            _ => Heights { unit, downwards, ..Heights::default() },
        })
    }
}

/// What the code of a unit that is not known says.
fn in_words(code: u16) -> String {
    if code == USER_DEFINED { "a user-defined one".into() } else { format!("EPSG:{code}") }
}

fn unknown_unit(what: &'static str, got: &str) -> TerrainError {
    TerrainError::Unsupported {
        what,
        need: "a unit of length whose size is known",
        got: got.into(),
        remedy: "state it in metres: gdal_translate -a_srs SYSTEM IN.tif OUT.tif, or gdal_edit.py -units metre for heights",
    }
}

/// The first of the `units` that are stated, if all of them are the same.
pub(crate) fn agreed<const N: usize>(
    what: &'static str,
    units: [Option<LengthUnit>; N],
) -> Result<Option<LengthUnit>, TerrainError> {
    let mut stated = units.into_iter().flatten();
    let Some(first) = stated.next() else { return Ok(None) };
    match stated.find(|other| !other.is_same_as(&first)) {
        None => Ok(Some(first)),
        Some(other) => Err(TerrainError::Unsupported {
            what,
            need: "one unit",
            got: format!("{first} in one place and {other} in another"),
            remedy: "correct the file, or state the coordinate system anew with gdal_translate -a_srs",
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn system(keys: &[u64], numbers: &[f64], text: &str) -> Result<Option<CoordinateSystem>, TerrainError> {
        GeoKeys::new(keys, numbers, text).unwrap().coordinate_system()
    }

    fn radius_m(keys: &[u64], numbers: &[f64]) -> Option<f64> {
        match system(keys, numbers, "").unwrap().unwrap().kind {
            Some(Kind::Degrees { radius_m }) => radius_m,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn degrees_have_the_radius_of_their_own_body() {
        assert_eq!(
            radius_m(&[1, 1, 0, 2, 1024, 0, 1, 2, 2057, 34736, 1, 0], &[3_396_190.0]),
            Some(3_396_190.0)
        );
        assert_eq!(radius_m(&[1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326], &[]), Some(EARTH_RADIUS_M));
        assert_eq!(radius_m(&[1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 32767], &[]), None);
        assert_eq!(radius_m(&[1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 4326], &[]), Some(EARTH_RADIUS_M));
    }

    /// P-DEM-UNITS. Keys, the code of a system and ESRI's text each state the unit of coordinates
    /// and heights.
    #[test]
    fn units_come_from_keys_codes_and_texts() {
        let pe = "ESRI PE String = PROJCS[\"p\",GEOGCS[\"g\",UNIT[\"Degree\",0.0174]],UNIT[\"Foot_US\",0.3048006096]]|";
        let length = pe.len() as u64;
        let survey_foot = 1200.0 / 3937.0;
        for (keys, numbers, unit_m, height_m) in [
            (vec![1024, 0, 1, 1, 3072, 0, 1, 32633], vec![], Some(1.0), None),
            (vec![1024, 0, 1, 1, 3072, 0, 1, 2263], vec![], Some(survey_foot), None),
            (vec![1024, 0, 1, 1, 3072, 0, 1, 2222], vec![], Some(0.3048), None),
            (vec![1024, 0, 1, 1, 3072, 0, 1, 32767, 3076, 0, 1, 9036], vec![], Some(1000.0), None),
            (vec![1024, 0, 1, 1, 3076, 0, 1, 32767, 3077, 34736, 1, 0], vec![0.5], Some(0.5), None),
            (vec![1024, 0, 1, 1, 3072, 0, 1, 32767], vec![], None, None),
            (
                vec![1024, 0, 1, 32767, 2048, 0, 1, 32767, 3073, 34737, length, 0],
                vec![],
                Some(0.304_800_609_6),
                None,
            ),
            (vec![1024, 0, 1, 1, 3072, 0, 1, 32633, 4099, 0, 1, 9002], vec![], Some(1.0), Some(0.3048)),
            (vec![1024, 0, 1, 1, 3072, 0, 1, 32633, 4096, 0, 1, 6360], vec![], Some(1.0), Some(survey_foot)),
            (vec![1024, 0, 1, 1, 3072, 0, 1, 32633, 4096, 0, 1, 5703], vec![], Some(1.0), Some(1.0)),
            (vec![3076, 0, 1, 9002], vec![], Some(0.3048), None),
        ] {
            let directory = [vec![1, 1, 0, keys.len() as u64 / 4], keys].concat();
            let system = system(&directory, &numbers, pe).unwrap().unwrap();
            assert_eq!(system.kind, Some(Kind::Plane), "{directory:?}");
            let metres = |unit: &Option<LengthUnit>| unit.as_ref().map(|unit| unit.metres);
            assert_eq!(
                (metres(&system.unit), metres(&system.heights.unit)),
                (unit_m, height_m),
                "{directory:?}"
            );
        }
        let depths = system(&[1, 1, 0, 2, 1024, 0, 1, 1, 4096, 0, 1, 6357], &[], "").unwrap().unwrap();
        assert!(depths.heights.downwards);
        for (keys, says) in [
            (vec![1, 1, 0, 2, 3072, 0, 1, 2263, 3076, 0, 1, 9001], "one unit"),
            (vec![1, 1, 0, 2, 4096, 0, 1, 6360, 4099, 0, 1, 9001], "one unit"),
            (vec![1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 3139], "EPSG:3139"),
            (vec![1, 1, 0, 2, 1024, 0, 1, 1, 3076, 0, 1, 9102], "EPSG:9102"),
            (vec![1, 1, 0, 2, 1024, 0, 1, 1, 3076, 0, 1, 32767], "without its length"),
        ] {
            let refused = system(&keys, &[], "").unwrap_err().to_string();
            assert!(refused.contains(says), "{refused}");
        }
    }
}
