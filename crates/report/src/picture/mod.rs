//! Pictures of missions in the style of the papers' figures (P23 figs. 3 to 13).
//!
//! They are written as plain SVG. The SVG backend of a chart library is not used: it emits one element with
//! its full style for every cell and arrow head (some 80 bytes a cell, 3 MB for 200×200), and it has no
//! hatching, clipping, halos, or y axis that points north. Here cells of one shade are one path of merged
//! rectangles, arrows of one direction are one path, and axes with round numbers take a page of code.
//!
//! Coordinates are metres from the centre of cell (0, 0). The output depends only on the [`Picture`], to the
//! byte.

mod boxes;
mod curves;
mod field_grid;
mod field_map;
mod frame;
mod legend;
mod log_curves;
mod mission;
mod panels;
mod paper;
mod picture_grid;
mod quiver;
mod scale;
mod style;
mod svg_writer;
mod symbols;
mod team;
mod tile_map;

pub use boxes::{BoxOf, Boxes};
pub use curves::{Chart, Curves, Line};
pub use field_grid::{Field, FieldGrid};
pub use field_map::{FieldMap, Way};
pub use log_curves::{LogChart, LogCurves, PointLine};
pub use mission::Picture;
pub use panels::{Aim, Panel, Panels};
pub use paper::COLUMN_MM;
pub use picture_grid::{PictureGrid, TitledPicture};
pub use style::PictureStyle;
pub(crate) use svg_writer::escaped;
