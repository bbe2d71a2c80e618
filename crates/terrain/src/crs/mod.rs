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
    /// Equatorial radius of the body, metres, where it is stated.
    pub radius_m: Option<f64>,
    pub identity: Identity,
}

/// What tells a coordinate system from others.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Identity {
    /// Authority and code, in capitals.
    pub code: Option<String>,
    pub title: Option<String>,
}

impl Identity {
    /// Whether both are one system: by their codes, or by their names; `None` where that cannot be said.
    pub fn is_of(&self, other: &Self) -> Option<bool> {
        if let (Some(code), Some(other)) = (&self.code, &other.code) {
            return Some(code == other);
        }
        if [self, other].iter().any(|system| system.code.is_none() && system.title.is_none()) {
            // One of them is not named at all: the numbers are all there is.
            return Some(true);
        }
        match (&self.title, &other.title) {
            (Some(title), Some(other)) if plain(title) == plain(other) => Some(true),
            _ => None,
        }
    }
}

/// A name without what dialects write in different ways: `WGS_1984_UTM_Zone_33N` is `WGS 84 / UTM zone 33N`.
fn plain(title: &str) -> String {
    let letters: String = title.chars().filter(char::is_ascii_alphanumeric).collect();
    letters.to_ascii_lowercase().replace("19", "")
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
    /// A name of theirs in which a foot is mentioned, where nothing states their unit.
    pub maybe_feet: Option<String>,
}

impl Heights {
    /// What the mere name of a vertical system says: `NAVD88 height (ftUS)`.
    pub fn cited(name: &str, downwards: bool) -> Self {
        let lower = name.to_ascii_lowercase();
        let in_brackets = name.split(['(', '[']).skip(1).filter_map(|part| part.split([')', ']']).next());
        let unit = in_brackets.filter_map(LengthUnit::of_name).last();
        let words = lower.split(|c: char| !c.is_ascii_alphanumeric());
        let is_foot = |word: &str| ["ft", "foot", "feet", "ftus", "usft"].contains(&word);
        let maybe_feet = if unit.is_none() && words.clone().any(is_foot) { Some(name.into()) } else { None };
        Self { unit, downwards: downwards || words.clone().any(|word| word == "depth"), maybe_feet }
    }
}

impl CoordinateSystem {
    fn new(name: &str, kind: Option<Kind>) -> Self {
        let name = name.trim();
        let name = if name.is_empty() { "unnamed" } else { name };
        let name: String = name.chars().take(NAME_CHARACTERS_MAX).collect();
        let identity = Identity { code: None, title: Some(name.clone()) };
        Self { name, kind, unit: None, heights: Heights::default(), radius_m: None, identity }
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
