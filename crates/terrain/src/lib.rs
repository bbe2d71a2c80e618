//! The ground of a mission, as it truly is.
//!
//! Ground comes from a formula ([`Gaussian`], [`RandomField`]) or from an elevation file
//! ([`RasterFile`]: GeoTIFF or ESRI ASCII grid). Either way it becomes a [`Relief`], elevations with
//! gradients on a square lattice; a datum, a slope limit and the sand turn that into a [`Terrain`].
//!
//! Everything read from a file is foreign: sizes are checked against named limits before memory is
//! taken, and whatever is wrong is one [`TerrainError`] that says what was needed, what was got and
//! what to do about it.

mod ascii_grid;
mod differences;
mod elevation;
mod error;
mod gaussian;
mod geo_keys;
mod georeference;
mod geotiff;
mod lattice;
mod random_field;
mod raster;
mod raster_header;
mod relief;
mod sand;
mod survey;
mod terrain;
mod tiff_chunk;
mod tiff_directory;
mod window;

pub use differences::differences;
pub use elevation::Elevation;
pub use error::TerrainError;
pub use gaussian::Gaussian;
pub use georeference::Georeference;
pub use lattice::hop_cells;
pub use random_field::RandomField;
pub use raster::RasterFile;
pub use raster_header::{ELEVATION_CELLS_MAX, PixelIs, RasterFormat, RasterHeader};
pub use relief::Relief;
pub use sand::{Rectangle, Sand};
pub use survey::{SlopeDistribution, Survey};
pub use terrain::Terrain;
pub use window::Window;
