//! Codes of coordinate systems: those of EPSG, and those of the IAU for other bodies.

use super::{CoordinateSystem, EARTH_RADIUS_M, Heights, Identity, Kind, proj_string};
use crate::unit::LengthUnit;

/// Code of the unit of heights of EPSG's vertical systems whose heights are not in metres, upwards (EPSG 11).
const HEIGHTS_NOT_IN_METRES: [(u64, u64); 9] = [
    (5702, 9003),
    (5754, 9095),
    (6130, 9002),
    (6131, 9002),
    (6132, 9002),
    (6360, 9003),
    (8050, 9002),
    (8052, 9003),
    (8228, 9002),
];

/// EPSG's vertical systems of depths, positive downwards (EPSG 11).
const DEPTHS: &[u64] = &[
    5336, 5612, 5614, 5706, 5715, 5734, 5739, 5789, 5831, 5861, 5862, 5863, 5864, 5865, 5866, 5867, 5873,
    6357, 6358, 6359, 7976, 8051, 8053, 8358, 8378, 8897, 9287, 9288, 9672, 10150, 10151, 10349, 10364,
    10370, 10371, 10372, 10373, 10374, 10375, 10376, 10377, 10378, 10379, 10547, 10548, 10549, 10550, 10551,
    10552, 10649, 10650, 10678,
];

/// The system that EPSG's `code` stands for; `None` for a code that is not known.
pub(crate) fn of_code(code: u64) -> Option<CoordinateSystem> {
    let definition = u16::try_from(code).ok().and_then(crs_definitions::from_code)?;
    let mut system = proj_string::read(definition.proj4).ok()?;
    system.name = format!("EPSG:{code}");
    system.identity = Identity { code: Some(system.name.clone()), title: None };
    if let Some(Kind::Degrees { radius_m }) = &mut system.kind {
        // EPSG has systems of the Earth alone.
        radius_m.get_or_insert(EARTH_RADIUS_M);
    }
    Some(system)
}

/// The heights of EPSG's vertical system `code`: in metres and upwards, unless it is one of those that are not.
pub(crate) fn vertical(code: u64) -> Heights {
    let unit =
        HEIGHTS_NOT_IN_METRES.iter().find(|(system, _)| *system == code).map_or(9001, |(_, unit)| *unit);
    Heights { unit: LengthUnit::of_epsg(unit), downwards: DEPTHS.contains(&code), ..Heights::default() }
}

/// The system that a text names by nothing but a code, if it does.
pub(super) fn of_text(text: &str) -> Option<Result<CoordinateSystem, String>> {
    let plain = one_code(text);
    let (authority, codes) = match plain.rsplit_once([':', '/']) {
        Some((before, codes)) => (before.to_owned(), codes.to_owned()),
        None => ("epsg".to_owned(), plain),
    };
    if codes.is_empty() || !codes.chars().all(|c| c.is_ascii_digit() || c == '+') {
        return None;
    }
    // A part such as the version in urn:ogc:def:crs:EPSG:9.8:2263 stands between authority and code.
    let is_of = |name: &str| authority.split([':', '/']).any(|part| part.starts_with(name));
    if is_of("iau") {
        return Some(of_iau(&codes, text));
    }
    if !is_of("epsg") {
        return Some(Err(format!("a code of EPSG or IAU, got {}", super::beginning(text))));
    }
    Some(of_epsg(&codes))
}

/// A code without what people write around it: `EPSG 32633`, `EPSG:32633+EPSG:6360`,
/// `urn:ogc:def:crs,crs:EPSG::32633,crs:EPSG::6360`.
fn one_code(text: &str) -> String {
    let lower = text.trim_end_matches('/').to_ascii_lowercase();
    let spaced = match lower.strip_prefix("epsg") {
        Some(rest) if rest.starts_with(char::is_whitespace) => format!("epsg:{}", rest.trim_start()),
        _ => lower,
    };
    let plain: String = spaced.split_whitespace().collect();
    plain.replace(",crs:epsg::", "+").replacen("crs+", "crs:epsg::", 1).replace("+epsg:", "+")
}

/// A code, or a horizontal and a vertical one: `32633+5703`.
fn of_epsg(codes: &str) -> Result<CoordinateSystem, String> {
    let number = |text: &str| text.parse::<u64>().map_err(|_| format!("a code of EPSG, got {text:?}"));
    let (code, heights) = match codes.split_once('+') {
        Some((code, vertical)) => (number(code)?, Some(number(vertical)?)),
        None => (number(codes)?, None),
    };
    let mut system = of_code(code).ok_or_else(|| {
        format!(
            "a code of EPSG whose unit is known here, got EPSG:{code}; give the text of the system instead"
        )
    })?;
    if let Some(code) = heights {
        system.heights = vertical(code);
        system.name = format!("{}+{code}", system.name);
    }
    Ok(system)
}

/// IAU's codes are the number of the body in NAIF's list times 100, then 00 to 09 for a geographic system and 10 to 99 for a
/// projected one, in metres.
fn of_iau(code: &str, text: &str) -> Result<CoordinateSystem, String> {
    match code.parse::<u64>() {
        Ok(number) if number >= 1000 => {
            let kind = if number % 100 < 10 { Kind::Degrees { radius_m: None } } else { Kind::Plane };
            let mut system = CoordinateSystem::new(text, Some(kind));
            system.unit = Some(LengthUnit::metre());
            system.identity.code = Some(format!("IAU:{number}"));
            Ok(system)
        }
        _ => Err(format!("a code of IAU, got {}", super::beginning(text))),
    }
}
