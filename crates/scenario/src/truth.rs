//! Section `[truth]`: the true ground, known to the simulator only.

use std::collections::BTreeMap;
use std::path::PathBuf;

#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Dynamics, exact};

/// The true ground: terrain, sand and treasures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// Heights and slopes: generated or from an elevation file.
    pub terrain: TerrainSource,
    /// Where it is sand; nowhere by default.
    #[serde(default)]
    pub sand: SandRules,
    /// Where a hop ends; by default by the law of the papers.
    #[serde(default, skip_serializing_if = "Dynamics::is_law")]
    pub dynamics: Dynamics,
    /// How fast a rover drives on it, where robots drive: not in a hopper's mission.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mobility: Option<Mobility>,
    /// Cells (x, y) with treasures, at most 16; known to a planner once seen, collected on landing.
    #[serde(default, skip_serializing_if = "Vec::is_empty", deserialize_with = "exact::list")]
    pub treasures: Vec<[i32; 2]>,
}

/// The shape of the ground: exactly one of these.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum TerrainSource {
    /// Hills and hollows at given places.
    Gaussians(Gaussians),
    /// Hills and hollows at random places.
    RandomHills(RandomHills),
    /// Level ground with obstacles at random cells.
    Obstacles(Obstacles),
    /// A plain with rocks, whose tops are level.
    Rocks(Rocks),
    /// Level ground whose speeds are uncertain: two impassable discs and three passages, 200 x 200 cells of a metre.
    Passages(Passages),
    /// An elevation model from a file.
    ElevationFile(ElevationFile),
}

/// Hills and hollows h = ±a·exp(−r²/2σ²).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Gaussians {
    /// Columns, 1 to 1024.
    pub width_cells: u32,
    /// Rows, 1 to 1024.
    pub height_cells: u32,
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    /// Standard deviation σ, metres, above 0.
    pub sigma_m: f64,
    /// Height of a hill's top, metres.
    pub amplitude_m: f64,
    /// Where in a cell its ground is taken: cell (x, y) spans (x, y) to (x + 1, y + 1) times the cell size.
    #[serde(default, skip_serializing_if = "CellPoint::is_default")]
    pub ground_at: CellPoint,
    /// Centres (x, y) of the hills, metres from the corner of cell (0, 0).
    #[serde(default, deserialize_with = "exact::list")]
    pub raised_m: Vec<[f64; 2]>,
    /// Centres (x, y) of the hollows, metres from the corner of cell (0, 0).
    #[serde(default, deserialize_with = "exact::list")]
    pub lowered_m: Vec<[f64; 2]>,
}

/// A point of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum CellPoint {
    /// The south-western corner.
    #[default]
    Corner,
    /// The middle.
    Centre,
}

impl CellPoint {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Its offset from the corner, cells along each axis.
    pub(crate) fn offset_cells(self) -> f64 {
        match self {
            Self::Corner => 0.0,
            Self::Centre => 0.5,
        }
    }
}

/// A sum of random Gaussians; the same seed gives the same ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RandomHills {
    /// Columns, 1 to 1024.
    pub width_cells: u32,
    /// Rows, 1 to 1024.
    pub height_cells: u32,
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    /// Seed of the ground; the seed of a run scatters hops and leaves the ground alone.
    pub seed: u32,
    /// Hills and hollows together, 0 to 1000.
    pub hills: u32,
    /// Smallest and largest standard deviation σ, metres, above 0.
    #[serde(deserialize_with = "exact::array")]
    pub sigma_m: [f64; 2],
    /// Lowest and highest top of a hill, metres; a hollow is as deep.
    #[serde(deserialize_with = "exact::array")]
    pub amplitude_m: [f64; 2],
    /// Distance from its centre, in σ along an axis, at which a hill is cut off; at least 3, by default never.
    /// At 6 the cut is 1.5e-8 of its top, and a large map is generated in a fraction of the time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach_sigma: Option<f64>,
}

/// A plain with rocks: level within each cell, with vertical steps between cells, so that no cell has a slope.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Rocks {
    /// Columns, 1 to 1024.
    pub width_cells: u32,
    /// Rows, 1 to 1024.
    pub height_cells: u32,
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    /// Rocks, at most 1000; where several lie on a cell, the last of them counts.
    pub rocks: Vec<Rock>,
}

/// A rock on a rectangle of cells, its edges included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Rock {
    /// First and last column.
    #[serde(deserialize_with = "exact::array")]
    pub x: [i32; 2],
    /// First and last row.
    #[serde(deserialize_with = "exact::array")]
    pub y: [i32; 2],
    /// Height of its top above the plain, metres; below 0 for a hole.
    pub height_m: f64,
}

/// Level ground on which some cells are obstacles, while all others are connected; the same seed gives the same ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Obstacles {
    /// Columns, 1 to 1024.
    pub width_cells: u32,
    /// Rows, 1 to 1024.
    pub height_cells: u32,
    /// Edge of a cell, metres.
    pub cell_size_m: f64,
    /// Share of the cells that are obstacles, 0 % or more and below 100 %.
    pub percent: f64,
    /// Seed of the ground.
    pub seed: u64,
}

/// The Monte Carlo world of Folsom et al. 2021: what is known of its passages beforehand, their true speeds, start and goal
/// are drawn; the same seed gives the same world. Not for a hopper's mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Passages {
    /// Seed of the world.
    pub seed: u64,
}

/// How fast a rover drives on the terrain, whose cells need to be of a metre: exactly one of `class_file`, `classes` and
/// `speeds`. By class, slope and rock abundance give the speed (Folsom et al. 2021, Fig. 3). Where the terrain has no
/// height the speed is 0.
///
/// The truth is drawn: cells that touch and of which the same is known are of one class, or have one speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Mobility {
    /// Seed from which the truth is drawn.
    #[serde(default)]
    pub seed: u64,
    /// Share of the ground that rocks cover, 0 to 1: a number, or a raster.
    #[serde(default = "nothing")]
    pub rock_abundance: Layer,
    /// Raster of the terrain classes, 0 to 10, of ground on which they are certain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub class_file: Option<PathBuf>,
    /// Probability of each terrain class that there may be: a number, or a raster.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub classes: BTreeMap<String, Layer>,
    /// Probabilities of 0, 50, 150 and 200 m/Sol: each a number, or a raster.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::optional")]
    pub speeds: Option<[Layer; 4]>,
    /// Raster of the true speeds, 0, 50, 150 or 200 m/Sol, which are drawn otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub true_speed_file: Option<PathBuf>,
}

/// A value of each cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(untagged, expecting = "need a number, or the name of a raster file in quotes")]
pub enum Layer {
    /// The same everywhere.
    Everywhere(f64),
    /// Those of a GeoTIFF or ESRI ASCII grid with the cells of the terrain, or of the elevation model, with which it is cropped
    /// and resampled.
    File(PathBuf),
}

/// A GeoTIFF or an ESRI ASCII grid, north-up, in a unit of length. First cropped, then resampled, then exaggerated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ElevationFile {
    /// The file; a relative path starts from the scenario's folder.
    pub file: PathBuf,
    /// Part of the file to take, in cells.
    pub crop_cells: Option<CropCells>,
    /// Part of the file to take, in metres of its own coordinate system, converted from its unit if it has another.
    pub crop_m: Option<CropMetres>,
    /// Edge of a cell to resample to (bilinearly), metres; the file's own by default.
    pub cell_size_m: Option<f64>,
    /// Stored values that are nodata, beside the one that the file declares; an empty list for no others. By default values
    /// that look like nodata are taken for it, with a warning.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodata: Option<Vec<f64>>,
    /// Factor that heights are multiplied by, 0.001 to 1000.
    #[serde(default = "one")]
    pub vertical_exaggeration: f64,
}

/// A part of a raster in cells, counted from its south-western corner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CropCells {
    /// First column, from the west.
    pub x: u32,
    /// First row, from the south.
    pub y: u32,
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
}

/// A part of a raster in metres: the cells whose middles lie in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CropMetres {
    /// Easting of the western edge, metres.
    pub west: f64,
    /// Northing of the southern edge, metres.
    pub south: f64,
    /// Extent to the east, metres, above 0.
    pub width: f64,
    /// Extent to the north, metres, above 0.
    pub height: f64,
}

/// Where the ground is sand: wherever at least one of these rules applies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SandRules {
    /// Rectangles of sand, at most 1000.
    #[serde(default)]
    pub rectangles: Vec<SandRectangle>,
    /// Wherever the height above the datum is less than this, metres.
    pub below_height_m: Option<f64>,
    /// Wherever this raster is neither 0 nor nodata: a GeoTIFF or ESRI ASCII grid of the same columns
    /// and rows as the generated terrain or the elevation file, with which it is cropped and resampled.
    pub mask_file: Option<PathBuf>,
}

/// A rectangle of cells, its edges included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SandRectangle {
    /// First and last column.
    #[serde(deserialize_with = "exact::array")]
    pub x: [i32; 2],
    /// First and last row.
    #[serde(deserialize_with = "exact::array")]
    pub y: [i32; 2],
}

fn nothing() -> Layer {
    Layer::Everywhere(0.0)
}

fn one() -> f64 {
    1.0
}
