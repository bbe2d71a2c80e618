//! Position of a raster in its coordinate system.

use serde::Serialize;

use crate::crs::Identity;
use crate::raster_header::PixelIs;
use crate::{TerrainError, Window};

/// Position, cell size and coordinate system of a raster.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Georeference {
    /// Edge of a square cell, metres.
    pub cell_size_m: f64,
    /// Easting of the middle of the westernmost cells, metres.
    pub west_m: f64,
    /// Northing of the middle of the southernmost cells, metres.
    pub south_m: f64,
    /// Which point of a cell the coordinates in the file referred to.
    pub pixel_is: PixelIs,
    /// Name of the coordinate system, or that the file names none.
    pub coordinate_system: String,
    /// Which system that is.
    #[serde(skip)]
    pub(crate) identity: Identity,
    /// The unit of the file's own coordinates, metres.
    #[serde(skip)]
    pub(crate) unit_m: f64,
}

impl Georeference {
    /// The window of the cells whose middles lie in the rectangle from (`west_m`, `south_m`), included, to
    /// (`west_m` + `width_m`, `south_m` + `height_m`), excluded, in the file's own coordinates. `cells` are the
    /// raster's columns and rows.
    ///
    /// # Errors
    /// [`TerrainError::Crop`] if the window is empty or reaches beyond the raster.
    pub fn window(
        &self,
        cells: (u32, u32),
        [west_m, south_m, width_m, height_m]: [f64; 4],
    ) -> Result<Window, TerrainError> {
        let along = |origin_m: f64, start_m: f64, length_m: f64, side: u32| {
            // Tolerates rounding of coordinates that were written as decimals.
            let first_at = |edge_m: f64| ((edge_m - origin_m) / self.cell_size_m - 1e-6).ceil();
            let (first, end) = (first_at(start_m), first_at(start_m + length_m));
            (first >= 0.0 && first < end && end <= f64::from(side))
                .then_some((first as u32, (end - first) as u32))
        };
        let (columns, rows) = cells;
        match (along(self.west_m, west_m, width_m, columns), along(self.south_m, south_m, height_m, rows)) {
            (Some((x, width)), Some((y, height))) => Ok(Window { x, y, width, height }),
            _ => {
                let half = self.cell_size_m / 2.0;
                let extent = |middle_m: f64, side: u32| {
                    let edge_m = middle_m - half;
                    format!("{edge_m} and {} m", edge_m + f64::from(side) * self.cell_size_m)
                };
                Err(TerrainError::Crop {
                    have: format!(
                        "eastings {} and northings {}",
                        extent(self.west_m, columns),
                        extent(self.south_m, rows)
                    ),
                    got: format!("{width_m} x {height_m} m from ({west_m}, {south_m})"),
                })
            }
        }
    }
}
