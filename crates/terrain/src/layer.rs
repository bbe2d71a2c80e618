//! Values of further rasters on the cells of an elevation model.

use std::path::Path;

use crate::elevation::{resample_ratio, resampled_side};
use crate::raster::Lies;
use crate::{Fill, Georeference, RasterFile, TerrainError, Window};

/// The cells of a terrain's source, and which of them became the terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceCells {
    /// Columns and rows of the source.
    pub shape: (u32, u32),
    /// What was cropped out of it.
    pub window: Window,
    /// New cell size over old, if it was resampled then.
    pub ratio: Option<f64>,
    /// Where the source lies; `None` for generated terrain.
    pub georeference: Option<Georeference>,
}

/// The values of a further raster.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// In index order; NaN for nodata.
    pub values: Vec<f64>,
    /// What reading it had to decide.
    pub notes: LayerNotes,
}

/// What reading a further raster had to decide.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerNotes {
    /// Values that were taken for nodata though the file does not declare them.
    pub fills: Vec<Fill>,
    /// Its coordinate system and that of the model, where their names differ and it is not known whether they do.
    pub other_system: Option<[String; 2]>,
}

/// Reads the raster at `path`.
///
/// The raster needs the shape of the terrain's source and, where both say so, its position. It is cropped as the source
/// was. If the source was resampled, each new cell takes the value of the old cell that its middle lies in.
///
/// # Errors
/// If the file cannot be read, has another shape, lies elsewhere or in another coordinate system.
pub fn read_layer(path: &Path, source: &SourceCells) -> Result<Layer, TerrainError> {
    let &SourceCells { shape: (width, height), window, ratio, ref georeference } = source;
    let mut raster = RasterFile::open(path)?;
    let (got_width, got_height) = (raster.header().width, raster.header().height);
    if (got_width, got_height) != (width, height) {
        let shape =
            TerrainError::LayerShape { need_width: width, need_height: height, got_width, got_height };
        return Err(shape.of(path));
    }
    let mut other_system = None;
    if let Some(need) = georeference {
        let at = |of: &Georeference| {
            format!("cells of {} m from ({}, {}) m", of.cell_size_m, of.west_m, of.south_m)
        };
        let system = |of: &Georeference| of.coordinate_system.clone();
        match raster.lies(need).map_err(|error| error.of(path))? {
            Lies::There => {}
            Lies::Elsewhere(got) => {
                return Err(TerrainError::LayerPosition { need: at(need), got: at(&got) }.of(path));
            }
            Lies::InOtherSystem(got) => {
                return Err(TerrainError::LayerSystem { need: system(need), got: system(&got) }.of(path));
            }
            Lies::MaybeInOtherSystem(got) => other_system = Some([system(&got), system(need)]),
        }
    }
    let (values, fills) = raster.layer(window).map_err(|error| error.of(path))?;
    let notes = LayerNotes { fills, other_system };
    let Some(ratio) = ratio else { return Ok(Layer { values, notes }) };
    let ratio = resample_ratio(1.0, ratio)?;
    let (columns, rows) = (resampled_side(window.width, ratio)?, resampled_side(window.height, ratio)?);
    let nearest = |cell: u32, side: u32| (((f64::from(cell) + 0.5) * ratio) as u32).min(side - 1) as usize;
    let value = |(x, y): (u32, u32)| {
        values[nearest(y, window.height) * window.width as usize + nearest(x, window.width)]
    };
    let values = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).map(value).collect();
    Ok(Layer { values, notes })
}
