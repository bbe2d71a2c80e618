//! What the command line says of an elevation model beside its name.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use node::Failure;

use crate::conversion;

/// How the elevation model is read.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct ElevationArgs {
    /// Stored values of the elevation model that are nodata beside the declared one, or none: settles what is otherwise
    /// suspected.
    #[arg(long, value_name = "VALUE,...|none", allow_hyphen_values = true)]
    pub nodata: Option<Nodata>,
    /// Convert an elevation model of a format that is not read, with GDAL's gdal_translate, into a GeoTIFF beside it.
    #[arg(long)]
    pub convert: bool,
}

/// Values that are nodata; empty for none.
#[derive(Clone, Debug, PartialEq)]
pub struct Nodata(pub Vec<f64>);

impl FromStr for Nodata {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.eq_ignore_ascii_case("none") {
            return Ok(Self(Vec::new()));
        }
        let values: Result<Vec<f64>, _> = text.split(',').map(|value| value.trim().parse()).collect();
        match values {
            Ok(values) if values.iter().all(|value| value.is_finite()) => Ok(Self(values)),
            _ => Err(format!(
                "nodata is a value such as -9999, several with commas between them, or none; got {text:?}"
            )),
        }
    }
}

impl ElevationArgs {
    /// The values that are settled to be nodata.
    #[must_use]
    pub fn nodata(&self) -> Option<&[f64]> {
        self.nodata.as_ref().map(|nodata| nodata.0.as_slice())
    }

    /// The elevation model to read: `dem`, or what it was converted to.
    ///
    /// # Errors
    /// Exit code 2 if it needs to be converted and cannot be.
    pub fn model(&self, dem: &Path) -> Result<PathBuf, Failure> {
        if self.convert { conversion::converted(dem) } else { Ok(dem.into()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodata_is_values_or_none() {
        assert_eq!("-9999".parse(), Ok(Nodata(vec![-9999.0])));
        assert_eq!("-9999, 0".parse(), Ok(Nodata(vec![-9999.0, 0.0])));
        assert_eq!("none".parse(), Ok(Nodata(vec![])));
        for text in ["", "nan", "-", "1,,2", "low"] {
            assert!(text.parse::<Nodata>().is_err(), "{text}");
        }
    }
}
