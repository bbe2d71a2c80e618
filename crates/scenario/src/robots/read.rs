//! Reading of `[[robots]]`: first the body of each, then the fields that this body has.
//!
//! An enum that is read at once by its tag forgets where its fields stand in the text; this way a field that is unknown or wrong is
//! named with its line.

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeValue, Error, ValueDeserializer};

use super::{Body, RobotRules};

/// The body of a robot, whatever else it has.
#[derive(Deserialize)]
struct Named {
    body: Body,
}

/// The robots of a list of tables.
///
/// # Errors
/// The first error, with the place in the text, and the body by which the robot was read.
pub(crate) fn read(robots: Spanned<DeValue<'_>>) -> Result<Vec<RobotRules>, (Error, Option<String>)> {
    let named = Vec::<Named>::deserialize(ValueDeserializer::from(robots.clone()));
    let named = named.map_err(|error| (error, None))?;
    let DeValue::Array(tables) = robots.into_inner() else { return Ok(Vec::new()) };
    let read = |(number, (table, Named { body })): (usize, (Spanned<DeValue<'_>>, Named))| {
        let (robot, name) = body.read(without_body(table));
        robot.map_err(|error| (error, Some(format!("for robot {number}, a {name}"))))
    };
    tables.into_iter().zip(named).enumerate().map(read).collect()
}

/// The fields of a robot's table beside its body.
fn without_body(mut table: Spanned<DeValue<'_>>) -> ValueDeserializer<'_> {
    if let DeValue::Table(fields) = table.get_mut() {
        fields.remove("body");
    }
    ValueDeserializer::from(table)
}
