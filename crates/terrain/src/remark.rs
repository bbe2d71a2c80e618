//! What reading an elevation model had to decide, and says.

use std::fmt;

use crate::Fill;
use crate::fill::in_words;

/// A decision about the heights or the place of a model, which whoever flies over it should know. Displayed, it is a sentence.
#[derive(Clone, Debug, PartialEq)]
pub enum Remark {
    /// Cells that hold a value which looks like nodata are taken for cells without height.
    SuspectedNodata {
        /// The value and its cells.
        fill: Fill,
        /// All values that are suspected, as `--nodata` takes them.
        values: String,
    },
    /// Coordinates were converted to metres from this unit.
    CoordinatesConverted(String),
    /// Heights were converted to metres from this unit.
    HeightsConverted(String),
    /// The coordinate system of this name states no unit.
    NoUnit(String),
    /// The file begins with a byte order mark.
    ByteOrderMark,
    /// Cells hold values that are no heights of any body.
    BeyondHeights {
        /// Cells that hold such values.
        cells: u64,
        /// Lowest such value, metres.
        min_m: f64,
        /// Highest such value, metres.
        max_m: f64,
    },
    /// Cells beside nodata hold heights between those of the ground and the value of nodata.
    InterpolatedNodata {
        /// Cells that hold such values.
        cells: u64,
    },
    /// No cell holds a value that was said to be nodata.
    NoCellHolds(f64),
    /// No cell is as low as ground is.
    MaybeRadii {
        /// Lowest height, metres.
        lowest_m: f64,
    },
    /// A vertical system of this name states no unit, and its name may be that of one in feet.
    MaybeFeet(String),
    /// Without a coordinate system, numbers that could be degrees were taken for metres.
    TakenForLocal,
}

impl Remark {
    /// Whether it says why cells have no height.
    #[must_use]
    pub fn is_of_nodata(&self) -> bool {
        use Remark::*;
        matches!(
            self,
            SuspectedNodata { .. } | BeyondHeights { .. } | InterpolatedNodata { .. } | NoCellHolds(_)
        )
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SuspectedNodata { fill, values } => {
                // A file declares but one.
                let declare = match values.contains(',') {
                    true => String::new(),
                    false => format!(" or gdal_translate -a_nodata {values} IN OUT"),
                };
                write!(
                    f,
                    "{fill}; these cells are taken for cells without height: settle it with --nodata {values}{declare}, or \
                     with --nodata none if they are heights"
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
            Self::BeyondHeights { cells, min_m, max_m } => write!(
                f,
                "{}, beyond 1e6 m: taken for cells without height; if they are nodata, declare it with gdal_translate \
                 -a_nodata VALUE IN OUT; otherwise check unit, scale and offset",
                held(*cells, *min_m, *max_m)
            ),
            Self::InterpolatedNodata { cells } => write!(
                f,
                "{} beside nodata between the heights of the ground and the value of nodata, as a resampling leaves them \
                 behind: taken for cells without height; declare nodata before the file is resampled",
                if *cells == 1 { "1 cell lies".into() } else { format!("{cells} cells lie") }
            ),
            Self::NoCellHolds(value) => write!(
                f,
                "no cell that was read holds {}, which is said to be nodata: values that look like it are taken for it",
                in_words(*value)
            ),
            Self::MaybeRadii { lowest_m } => write!(
                f,
                "no height is below {lowest_m} m: if these are distances from the centre of the body, subtract its radius, for \
                 example with gdal_edit.py -offset -RADIUS FILE; if they are not in metres, name their unit with gdal_edit.py \
                 -units UNIT FILE"
            ),
            Self::MaybeFeet(name) => write!(
                f,
                "the vertical system {name:?} states no unit: taken for metres; for feet, say gdal_edit.py -units ft FILE"
            ),
            Self::TakenForLocal => f.write_str(
                "no coordinate system is named, and the cells lie where longitudes and latitudes may: taken for metres, as a \
                 corner is (0, 0); put LOCAL_CS[\"site\",UNIT[\"metre\",1]] into a .prj file beside it to say so",
            ),
        }
    }
}

/// Which cells hold values from `min_m` to `max_m`.
fn held(cells: u64, min_m: f64, max_m: f64) -> String {
    let values = if min_m == max_m {
        in_words(min_m)
    } else {
        format!("values from {} to {}", in_words(min_m), in_words(max_m))
    };
    if cells == 1 { format!("1 cell holds {values} m") } else { format!("{cells} cells hold {values} m") }
}
