//! The keywords of ArcInfo's `.prj` files: a line each, with a value.

use super::{CoordinateSystem, Heights, Kind, beginning};
use crate::unit::LengthUnit;

pub(super) fn read(text: &str) -> Result<CoordinateSystem, String> {
    let value = |keyword: &str| {
        text.lines().find_map(|line| {
            let mut words = line.split_whitespace();
            let is_it =
                words.next().is_some_and(|word| word.trim_end_matches(':').eq_ignore_ascii_case(keyword));
            is_it.then(|| words.collect::<Vec<_>>().join(" "))
        })
    };
    let projection = value("projection").ok_or_else(|| {
        format!(
            "well-known text, PROJJSON, a PROJ string, a code of EPSG or ArcInfo's keywords, got {}",
            beginning(text)
        )
    })?;
    let name = match value("zone") {
        Some(zone) => format!("{projection} zone {zone}"),
        None => projection.clone(),
    };
    let units = value("units").unwrap_or_default();
    let is_angle =
        matches!(units.to_ascii_uppercase().as_str(), "DD" | "DMS" | "DS" | "DM" | "DEGREES" | "RADIANS");
    if projection.to_ascii_uppercase().starts_with("GEOGRAPHIC") || is_angle {
        return Ok(CoordinateSystem::new(&name, Some(Kind::Degrees { radius_m: None })));
    }
    let mut system = CoordinateSystem::new(&name, Some(Kind::Plane));
    system.unit = unit(&units)?;
    system.heights = Heights { unit: unit(&value("zunits").unwrap_or_default())?, ..Heights::default() };
    Ok(system)
}

/// A name, or how many of the unit are a metre. ArcInfo's foot is that of the US survey.
fn unit(text: &str) -> Result<Option<LengthUnit>, String> {
    if let Ok(per_metre) = text.parse::<f64>() {
        let unit = LengthUnit::of_length("unit", 1.0 / per_metre);
        return unit.map(Some).ok_or_else(|| format!("units to a metre, got {text:?}"));
    }
    match text.to_ascii_uppercase().as_str() {
        "" | "NO" | "NONE" | "UNKNOWN" => Ok(None),
        "FEET" | "FOOT" => Ok(LengthUnit::of_epsg(9003)),
        _ => LengthUnit::of_name(text).map(Some).ok_or_else(|| format!("a unit of length, got {text:?}")),
    }
}
