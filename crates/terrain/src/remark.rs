//! What reading an elevation model had to decide, and says.

use std::fmt;

use crate::Fill;

/// A decision about the heights or the place of a model, which whoever flies over it should know. Displayed, it is a sentence.
#[derive(Clone, Debug, PartialEq)]
pub enum Remark {
    /// Cells that hold a value which looks like nodata are taken for cells without height.
    SuspectedNodata(Fill),
    /// Coordinates were converted to metres from this unit.
    CoordinatesConverted(String),
    /// Heights were converted to metres from this unit.
    HeightsConverted(String),
    /// The coordinate system of this name states no unit.
    NoUnit(String),
    /// The file begins with a byte order mark.
    ByteOrderMark,
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SuspectedNodata(fill) => {
                let value = fill.in_words();
                write!(
                    f,
                    "{fill}; these cells are taken for cells without height: settle it with --nodata {value} or \
                     gdal_translate -a_nodata {value} IN OUT, or with --nodata none if they are heights"
                )
            }
            Self::CoordinatesConverted(unit) => {
                write!(f, "coordinates and cells are measured in the {unit}: converted to metres")
            }
            Self::HeightsConverted(unit) => {
                write!(f, "heights are measured in the {unit}: converted to metres")
            }
            Self::NoUnit(system) => {
                write!(f, "the coordinate system {system} states no unit: taken for metres")
            }
            Self::ByteOrderMark => f.write_str(
                "the file begins with a byte order mark (BOM), which no grid should have: skipped",
            ),
        }
    }
}
