//! PROJ strings: `+proj=utm +zone=33 +units=us-ft`.

use std::collections::BTreeMap;

use super::{CoordinateSystem, EARTH_RADIUS_M, Heights, Kind, beginning, body_radius};
use crate::unit::LengthUnit;

pub(super) fn is_like(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    lower.starts_with("proj=")
        || lower.starts_with("init=")
        || lower.contains("+proj")
        || lower.contains("+init")
}

/// What stands behind each `+key=`, in small letters.
fn parameters(lower: &str) -> BTreeMap<&str, &str> {
    lower
        .split(|c: char| c.is_whitespace() || c == '+')
        .filter_map(|word| word.split_once('='))
        .map(|(key, value)| (key.trim(), value.trim().trim_matches(['"', '\''])))
        .collect()
}

/// The code that stands for the whole system: `+init=epsg:32633`.
pub(super) fn initial_code(text: &str) -> Option<String> {
    parameters(&text.to_ascii_lowercase()).get("init").map(|code| (*code).to_owned())
}

/// Reads a string that names no code.
pub(super) fn read(text: &str) -> Result<CoordinateSystem, String> {
    let lower = text.to_ascii_lowercase();
    let parameters = parameters(&lower);
    let projection = parameters.get("proj").ok_or_else(|| format!("+proj=, got {}", beginning(text)))?;
    let number = |key: &str| parameters.get(key).and_then(|value| value.parse::<f64>().ok());
    let kind = match *projection {
        "longlat" | "latlong" | "lonlat" | "latlon" | "ob_tran" => {
            // PROJ knows data of the Earth alone.
            let of_datum = parameters.contains_key("datum").then_some(EARTH_RADIUS_M);
            Kind::Degrees { radius_m: number("a").or(number("r")).and_then(body_radius).or(of_datum) }
        }
        "geocent" | "cart" => Kind::Geocentric,
        _ => Kind::Plane,
    };
    let mut system = CoordinateSystem::new(text, Some(kind));
    // Projected coordinates are in metres where PROJ is told nothing else.
    let unit = unit(&parameters, "units", "to_meter")?;
    system.unit = Some(unit.unwrap_or_else(LengthUnit::metre));
    system.heights =
        Heights { unit: vertical(&parameters)?, downwards: is_down(&parameters), ..Heights::default() };
    let of_earth = ["datum", "ellps"].iter().any(|key| parameters.contains_key(key));
    let stated = number("a").or(number("r")).and_then(body_radius);
    system.radius_m = stated.or(of_earth.then_some(EARTH_RADIUS_M));
    Ok(system)
}

fn vertical(parameters: &BTreeMap<&str, &str>) -> Result<Option<LengthUnit>, String> {
    unit(parameters, "vunits", "vto_meter")
}

/// The third axis of `+axis=enu` points up, that of `+axis=end` down.
fn is_down(parameters: &BTreeMap<&str, &str>) -> bool {
    parameters.get("axis").is_some_and(|axis| axis.ends_with('d'))
}

fn unit(parameters: &BTreeMap<&str, &str>, named: &str, length: &str) -> Result<Option<LengthUnit>, String> {
    if let Some(text) = parameters.get(length) {
        let metres = match text.split_once('/') {
            Some((above, below)) => {
                above.parse::<f64>().ok().zip(below.parse::<f64>().ok()).map(|(a, b)| a / b)
            }
            None => text.parse().ok(),
        };
        let unit = metres.and_then(|metres| LengthUnit::of_length("unit", metres));
        return unit.map(Some).ok_or_else(|| format!("a length after +{length}=, got {text:?}"));
    }
    match parameters.get(named) {
        None => Ok(None),
        Some(name) => LengthUnit::of_name(name)
            .map(Some)
            .ok_or_else(|| format!("a unit of length after +{named}=, got {name:?}")),
    }
}
