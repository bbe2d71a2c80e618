//! Builds the true terrain of a mission from formulas or elevation files.
//!
//! Ground comes from a formula ([`Gaussian`], [`RandomField`]) or from an elevation file
//! ([`RasterFile`]: GeoTIFF or ESRI ASCII grid). Either way it becomes a [`Relief`], elevations with
//! gradients on a square lattice; a datum, a slope limit and the sand turn that into a [`Terrain`].
//!
//! ```
//! use contract::{Cell, Grid};
//! use terrain::{Gaussian, Relief, Sand, Terrain};
//!
//! let hill = Gaussian { centre_m: [5.0, 5.0], sigma_m: 1.0, amplitude_m: 2.0 };
//! let relief = Relief::of_gaussians(Grid::new(11, 11, 1.0, 1)?, &[hill]);
//! let terrain = Terrain::new(&relief, 0.0, 30_f64.to_radians(), &Sand::default());
//! let passable = |x, y| terrain.ground(Cell::new(x, y)).is_some_and(|ground| ground.passable);
//! assert!(passable(5, 5) && !passable(5, 6) && passable(0, 0), "flat on top, steep beside it");
//! # Ok::<(), contract::grid::GridError>(())
//! ```
//!
//! Files are untrusted input: sizes are checked against named limits before memory is allocated, and every
//! fault is one [`TerrainError`] that says what was needed, what was got and what to do about it.

#![warn(clippy::disallowed_methods)]

mod ascii_grid;
mod check;
mod crs;
mod differences;
mod elevation;
mod error;
mod fill;
mod gaussian;
mod geo_keys;
mod georeference;
mod geotiff;
mod interpolated;
mod lattice;
mod layer;
mod number;
mod pam;
mod pds_label;
mod radii;
mod random_field;
mod raster;
mod raster_header;
mod relief;
mod remark;
mod sand;
mod sidecar;
mod terrain;
mod tiff_chunk;
mod tiff_directory;
mod tiff_image;
mod unit;
mod window;

pub use check::{SlopeDistribution, TerrainCheck};
pub use differences::differences;
pub use elevation::Elevation;
pub use error::TerrainError;
pub use fill::Fill;
pub use gaussian::Gaussian;
pub use georeference::Georeference;
pub use lattice::{fitting_hop_m, hop_cells};
pub use layer::{Layer, LayerNotes, SourceCells, read_layer};
pub use random_field::RandomField;
pub use raster::{RasterFile, Survey};
pub use raster_header::{ELEVATION_CELLS_MAX, PixelIs, RasterFormat, RasterHeader};
pub use relief::Relief;
pub use remark::Remark;
pub use sand::{Rectangle, Sand};
pub use sidecar::CONVERTED;
pub use terrain::Terrain;
pub use window::Window;
