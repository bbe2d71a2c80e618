//! PROJJSON: coordinate systems as JSON objects.

use serde_json::Value;

use super::{CoordinateSystem, Heights, Kind, NESTING_MAX, body_radius, epsg};
use crate::unit::LengthUnit;

pub(super) fn read(text: &str) -> Result<CoordinateSystem, String> {
    let value: Value =
        serde_json::from_str(text).map_err(|error| format!("PROJJSON, got JSON with an error: {error}"))?;
    system(&value, 0)
}

fn system(value: &Value, depth: u32) -> Result<CoordinateSystem, String> {
    if depth > NESTING_MAX {
        return Err(format!("at most {NESTING_MAX} coordinate systems within each other, got more"));
    }
    let name = value["name"].as_str().unwrap_or_default();
    let kind = value["type"].as_str().unwrap_or_default();
    match kind {
        "GeographicCRS" | "DerivedGeographicCRS" => {
            Ok(CoordinateSystem::new(name, Some(Kind::Degrees { radius_m: radius_m(value) })))
        }
        "GeodeticCRS" | "DerivedGeodeticCRS" => {
            let is_cartesian = value["coordinate_system"]["subtype"].as_str() == Some("Cartesian");
            let kind =
                if is_cartesian { Kind::Geocentric } else { Kind::Degrees { radius_m: radius_m(value) } };
            Ok(CoordinateSystem::new(name, Some(kind)))
        }
        "ProjectedCRS" | "DerivedProjectedCRS" | "EngineeringCRS" | "DerivedEngineeringCRS" => {
            plane(name, value)
        }
        "VerticalCRS" | "DerivedVerticalCRS" => {
            let mut system = CoordinateSystem::new(name, None);
            system.heights = heights(value)?;
            Ok(system)
        }
        "CompoundCRS" => {
            let mut compound = CoordinateSystem::new(name, None);
            for component in value["components"].as_array().into_iter().flatten() {
                let part = self::system(component, depth + 1)?;
                if part.kind.is_some() {
                    (compound.kind, compound.unit) = (part.kind, part.unit);
                    (compound.radius_m, compound.identity) = (part.radius_m, part.identity);
                }
                if part.heights != Heights::default() {
                    compound.heights = part.heights;
                }
            }
            Ok(compound)
        }
        "BoundCRS" => system(&value["source_crs"], depth + 1),
        _ => Err(format!("PROJJSON of a coordinate system, got the type {kind:?}")),
    }
}

fn plane(name: &str, value: &Value) -> Result<CoordinateSystem, String> {
    let mut system = CoordinateSystem::new(name, Some(Kind::Plane));
    let axes = axes(value);
    match axes.first().map(|axis| &axis["unit"]) {
        Some(unit) if is_angle(unit) => system.kind = Some(Kind::Degrees { radius_m: None }),
        Some(unit) => system.unit = self::unit(unit)?,
        None => match id(value).and_then(epsg::of_code) {
            Some(of_code) => system.unit = of_code.unit,
            None => {
                return Err(format!("a coordinate_system with the units of its axes, got none in {name:?}"));
            }
        },
    }
    if let Some(third) = axes.get(2) {
        system.heights =
            Heights { unit: unit(&third["unit"])?, downwards: is_down(third), ..Heights::default() };
    }
    system.radius_m = radius_m(&value["base_crs"]);
    system.identity.code = id(value).map(|code| format!("EPSG:{code}"));
    Ok(system)
}

fn heights(value: &Value) -> Result<Heights, String> {
    match (axes(value).first(), id(value)) {
        (Some(axis), _) => {
            Ok(Heights { unit: unit(&axis["unit"])?, downwards: is_down(axis), ..Heights::default() })
        }
        (None, Some(code)) => Ok(epsg::vertical(code)),
        (None, None) => Ok(Heights::default()),
    }
}

fn axes(value: &Value) -> &[Value] {
    value["coordinate_system"]["axis"].as_array().map_or(&[], Vec::as_slice)
}

fn is_down(axis: &Value) -> bool {
    axis["direction"].as_str() == Some("down")
}

/// EPSG's code of the system, where it says so.
fn id(value: &Value) -> Option<u64> {
    let id = &value["id"];
    let is_epsg = id["authority"].as_str().is_some_and(|authority| authority.eq_ignore_ascii_case("EPSG"));
    if is_epsg { id["code"].as_u64().or_else(|| id["code"].as_str()?.parse().ok()) } else { None }
}

fn is_angle(unit: &Value) -> bool {
    let name = unit.as_str().or_else(|| unit["name"].as_str()).unwrap_or_default().to_ascii_lowercase();
    unit["type"].as_str() == Some("AngularUnit")
        || name.starts_with("deg")
        || name.starts_with("rad")
        || name == "grad"
}

/// A unit is a name, or an object with its factor.
fn unit(unit: &Value) -> Result<Option<LengthUnit>, String> {
    let name = unit.as_str().or_else(|| unit["name"].as_str()).unwrap_or_default();
    let of_factor = unit["conversion_factor"].as_f64().and_then(|metres| LengthUnit::of_length(name, metres));
    match of_factor.or_else(|| LengthUnit::of_name(name)) {
        Some(unit) => Ok(Some(unit)),
        None if unit.is_null() => Ok(None),
        None => Err(format!("a unit of length, got {name:?}")),
    }
}

/// Equatorial radius of the body, wherever its ellipsoid stands.
fn radius_m(value: &Value) -> Option<f64> {
    let datum =
        ["datum", "datum_ensemble"].into_iter().map(|key| &value[key]).find(|datum| !datum.is_null())?;
    let ellipsoid = &datum["ellipsoid"];
    let number = |key: &str| ellipsoid[key].as_f64().or_else(|| ellipsoid[key]["value"].as_f64());
    number("semi_major_axis").or_else(|| number("radius")).and_then(body_radius)
}
