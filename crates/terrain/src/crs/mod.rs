//! What a text says of a coordinate system: whether its cells are in degrees, and the units of its coordinates and heights.
//!
//! No crate reads what is needed here. `proj-wkt` (0.13) takes a text only if it can compute its projection, so that the
//! SimpleCylindrical of a HiRISE model, or a prime meridian of another body, makes it refuse the whole; `proj4wkt` (0.2) does
//! so too, and `epsg-utils` (0.0.3) reads the second edition of well-known text alone. What EPSG's codes stand for comes from
//! `crs-definitions`.

mod arc_info;
mod epsg;
mod proj_string;
mod projjson;
mod wkt;

pub(crate) use epsg::{of_code, vertical};

use crate::unit::LengthUnit;

/// Equatorial radius of the Earth (WGS 84), metres. Geographic systems with a code of EPSG are all the Earth's.
pub(crate) const EARTH_RADIUS_M: f64 = 6_378_137.0;

/// Longest name of a coordinate system that is kept, characters.
const NAME_CHARACTERS_MAX: usize = 80;

/// Most coordinate systems within each other, in texts that nest.
const NESTING_MAX: u32 = 16;

/// A coordinate system, as far as reading heights depends on it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CoordinateSystem {
    pub name: String,
    /// `None` for a system of heights alone.
    pub kind: Option<Kind>,
    /// Unit of eastings and northings, where it is stated.
    pub unit: Option<LengthUnit>,
    pub heights: Heights,
}

/// What the coordinates of cells are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// Lengths in a plane: projected, or local to a site.
    Plane,
    /// Longitude and latitude.
    Degrees {
        /// Equatorial radius of the body, metres, where it is stated.
        radius_m: Option<f64>,
    },
    /// Lengths from the centre of the body.
    Geocentric,
}

/// How heights are counted.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Heights {
    /// Their unit, where it is stated.
    pub unit: Option<LengthUnit>,
    /// Whether they are depths, positive downwards.
    pub downwards: bool,
}

impl CoordinateSystem {
    fn new(name: &str, kind: Option<Kind>) -> Self {
        let name = name.trim();
        let name = if name.is_empty() { "unnamed" } else { name };
        let name = name.chars().take(NAME_CHARACTERS_MAX).collect();
        Self { name, kind, unit: None, heights: Heights::default() }
    }

    /// What `text` describes: well-known text of either edition, PROJJSON, a PROJ string, a code of EPSG or IAU, or the keywords
    /// of ArcInfo. `None` if it is empty.
    ///
    /// # Errors
    /// What is not understood, in words.
    pub fn of_text(text: &str) -> Result<Option<Self>, String> {
        let text = text.trim_matches(|c: char| c.is_whitespace() || c == '\0' || c == '\u{feff}');
        if text.is_empty() {
            return Ok(None);
        }
        let system = if text.starts_with('{') {
            projjson::read(text)?
        } else if proj_string::is_like(text) {
            match proj_string::initial_code(text) {
                Some(code) => epsg::of_text(&code)
                    .unwrap_or_else(|| Err(format!("a code after +init=, got {code:?}")))?,
                None => proj_string::read(text)?,
            }
        } else if let Some(system) = epsg::of_text(text) {
            system?
        } else if wkt::is_like(text) {
            wkt::read(text)?
        } else {
            arc_info::read(text)?
        };
        Ok(Some(system))
    }
}

/// A radius that a body may have, metres.
fn body_radius(radius_m: f64) -> Option<f64> {
    if (1.0..1e9).contains(&radius_m) { Some(radius_m) } else { None }
}

/// The beginning of a text that is not understood.
fn beginning(text: &str) -> String {
    let start: String = text.chars().take(40).collect();
    format!("{:?}", start)
}

#[cfg(test)]
mod tests;
