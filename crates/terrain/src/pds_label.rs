//! The unit of heights in the label of a PDS3 image, which GDAL does not carry over.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::{TerrainError, sidecar};

/// What such a label begins with.
const BEGINNING: &str = "PDS_VERSION_ID";

/// Most bytes read of a label.
const LABEL_BYTES_MAX: u64 = 1 << 16;

/// The unit in the label that the file at `path` begins with; `None` without one.
pub(crate) fn unit(path: &Path) -> Result<Option<String>, TerrainError> {
    let mut bytes = Vec::new();
    File::open(path)?.take(LABEL_BYTES_MAX).read_to_end(&mut bytes)?;
    Ok(of_label(&sidecar::decoded(&bytes)))
}

fn of_label(text: &str) -> Option<String> {
    if !text.trim_start().starts_with(BEGINNING) {
        return None;
    }
    let statements = text.lines().filter_map(|line| line.split_once('='));
    let of_image = statements.map(|(key, value)| (key.trim(), value.trim())).skip_while(|(key, value)| {
        let is_image = value.trim_matches('"').to_ascii_uppercase().ends_with("IMAGE");
        !(key.eq_ignore_ascii_case("OBJECT") && is_image)
    });
    let unit = of_image
        .take_while(|(key, _)| !key.eq_ignore_ascii_case("END_OBJECT"))
        .find(|(key, _)| key.eq_ignore_ascii_case("UNIT"))?;
    let value = unit.1.split("/*").next().unwrap_or_default();
    Some(value.trim().trim_matches(|c| "\"'<>".contains(c)).trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_the_image_is_read() {
        let label = |unit: &str| {
            format!(
                "PDS_VERSION_ID = PDS3\r\nUNIT = PIXEL\r\nOBJECT = IMAGE\r\n  LINES = 3\r\n  {unit}\r\nEND_OBJECT = IMAGE\r\nOBJECT = X\r\n UNIT = DAY\r\n"
            )
        };
        for unit in ["UNIT = KILOMETER", "UNIT=\"KILOMETER\"", "unit = <KILOMETER> /* of heights */"] {
            assert_eq!(of_label(&label(unit)).as_deref(), Some("KILOMETER"), "{unit}");
        }
        assert_eq!(of_label(&label("")), None);
        assert_eq!(of_label(&label("UNIT = KILOMETER")["PDS".len()..]), None);
    }
}
