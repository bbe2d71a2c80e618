//! The report of `hopper terrain check`: what an elevation file holds, and what Hopper does with it.

use std::fmt;
use std::path::Path;

use contract::Range;
use contract::limits::{GRID_CELLS_MAX, GRID_SIDE_MAX};
use serde::Serialize;

use crate::{Georeference, RasterFile, RasterHeader, Relief, Remark, Survey, TerrainError, Window};

/// Distribution of the slopes of the cells whose slope is known, degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SlopeDistribution {
    /// Median.
    pub p50_deg: f64,
    /// 75th percentile.
    pub p75_deg: f64,
    /// 90th percentile.
    pub p90_deg: f64,
    /// 95th percentile.
    pub p95_deg: f64,
    /// 99th percentile.
    pub p99_deg: f64,
    /// Steepest cell.
    pub max_deg: f64,
    /// Slope limit of the command line.
    pub limit_deg: f64,
    /// Share of cells steeper than the limit, 0 to 1.
    pub over_limit_share: f64,
}

/// Properties of one elevation file. Displayed, it is text for a terminal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TerrainCheck {
    /// Path of the model, as it was given.
    pub file: String,
    /// Size and encoding.
    #[serde(flatten)]
    pub header: RasterHeader,
    /// Position, cell size and coordinate system.
    #[serde(flatten)]
    pub georeference: Georeference,
    /// Columns of the part that was checked.
    pub surveyed_width: u32,
    /// Rows of the part that was checked.
    pub surveyed_height: u32,
    /// Lowest and highest elevation, metres.
    pub elevation_m: Range,
    /// Mean elevation, metres.
    pub elevation_mean_m: f64,
    /// Slopes against the limit.
    pub slope: SlopeDistribution,
    /// Cells without height in the part that was checked.
    pub nodata_cells: u64,
    /// Share of cells without height, 0 to 1.
    pub nodata_share: f64,
    /// Share of cells that a hopper cannot land on (no height, no slope, or too steep), 0 to 1.
    pub impassable_share: f64,
    /// What Hopper does with each property, one sentence each.
    pub treatment: Vec<String>,
}

impl TerrainCheck {
    /// Checks the file at `path`, all of it or `window`, against a slope limit.
    ///
    /// # Errors
    /// [`TerrainError::File`] with what is wrong.
    pub fn of_file(path: &Path, window: Option<Window>, slope_limit_deg: f64) -> Result<Self, TerrainError> {
        let raster = RasterFile::open(path)?;
        Self::of(raster, &path.display().to_string(), window, slope_limit_deg).map_err(|error| error.of(path))
    }

    /// Checks an open raster; `name` stands for the path.
    ///
    /// # Errors
    /// [`TerrainError`] with what is wrong with it.
    pub fn of<R: std::io::BufRead + std::io::Seek>(
        raster: RasterFile<R>,
        name: &str,
        window: Option<Window>,
        slope_limit_deg: f64,
    ) -> Result<Self, TerrainError> {
        let header = raster.header().clone();
        let window = window.unwrap_or(Window::all(header.width, header.height));
        let Survey { elevation, georeference, remarks } = raster.survey(window)?;

        let known: Vec<f64> = elevation.heights_m.iter().copied().filter(|height| !height.is_nan()).collect();
        let min = known.iter().copied().fold(f64::INFINITY, f64::min);
        let max = known.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let cells = window.cells() as f64;
        let nodata_cells = window.cells() - known.len() as u64;

        let mut slopes = slopes_rad(&elevation)?;
        slopes.sort_by(f64::total_cmp);
        let too_steep = slopes.iter().filter(|&&slope| slope.to_degrees() > slope_limit_deg).count() as f64;
        let unknown = cells - slopes.len() as f64;
        // The smallest slope that at least `share` of the cells do not exceed.
        let percentile_deg = |share: f64| {
            let rank = (share * slopes.len() as f64).ceil() as usize;
            slopes.get(rank.saturating_sub(1)).map_or(0.0, |slope| slope.to_degrees())
        };
        let slope = SlopeDistribution {
            p50_deg: percentile_deg(0.5),
            p75_deg: percentile_deg(0.75),
            p90_deg: percentile_deg(0.9),
            p95_deg: percentile_deg(0.95),
            p99_deg: percentile_deg(0.99),
            max_deg: percentile_deg(1.0),
            limit_deg: slope_limit_deg,
            over_limit_share: if slopes.is_empty() { 0.0 } else { too_steep / slopes.len() as f64 },
        };
        let mut check = Self {
            file: name.into(),
            header,
            georeference,
            surveyed_width: window.width,
            surveyed_height: window.height,
            elevation_m: Range { min, max },
            elevation_mean_m: known.iter().sum::<f64>() / known.len() as f64,
            slope,
            nodata_cells,
            nodata_share: nodata_cells as f64 / cells,
            impassable_share: (too_steep + unknown) / cells,
            treatment: Vec::new(),
        };
        check.treatment = check.plan(&remarks);
        Ok(check)
    }

    /// What Hopper does with each property, one sentence each.
    fn plan(&self, remarks: &[Remark]) -> Vec<String> {
        let Self { header, georeference, .. } = self;
        let cell_m = significant(georeference.cell_size_m);
        let mut plan = Vec::new();
        let fits = self.surveyed_width.max(self.surveyed_height) <= GRID_SIDE_MAX
            && u64::from(self.surveyed_width) * u64::from(self.surveyed_height) <= u64::from(GRID_CELLS_MAX);
        plan.push(if fits {
            "size: fits a mission as it is; crop_cells or crop_m choose a part".into()
        } else {
            format!(
                "size: too large for a mission (at most {GRID_SIDE_MAX} cells a side): \
                 choose a part with crop_cells or crop_m, or larger cells with cell_size_m"
            )
        });
        plan.push(format!(
            "resolution: a hop has to span whole cells: hop_distance_m = {cell_m} (or a multiple), \
             or resample bilinearly with cell_size_m"
        ));
        plan.push(
            match georeference.pixel_is {
                crate::PixelIs::Area => {
                    "coordinates: of corners (pixel is area); half a cell is added to find the middles"
                }
                crate::PixelIs::Point => {
                    "coordinates: of the middles of cells (pixel is point); taken as they are"
                }
            }
            .into(),
        );
        plan.push(format!(
            "elevation: heights become relative to the brief's datum_m; \"survey\" takes the mean, {:.2} m",
            self.elevation_mean_m
        ));
        if (header.scale, header.offset) != (1.0, 0.0) {
            let (scale, offset) = (significant(header.scale), significant(header.offset));
            plan.push(format!("stored values: times {scale} plus {offset} gives heights"));
        }
        plan.push(format!(
            "slope: by central differences; over {:.1} degrees is impassable, landing there loses the hopper",
            self.slope.limit_deg
        ));
        plan.push(match (self.nodata_cells, header.nodata) {
            (0, _) => "nodata: none".into(),
            (_, Some(value)) => {
                format!(
                    "nodata: {}, masked cells and unbelievable heights are impassable",
                    significant(value)
                )
            }
            (_, None) => {
                "nodata: none declared; NaN, masked cells and unbelievable heights are impassable".into()
            }
        });
        let warnings = remarks.iter().map(|remark| match remark {
            Remark::CoordinatesConverted(_) => format!("coordinates: {remark}"),
            Remark::HeightsConverted(_) => format!("elevation: {remark}"),
            _ => format!("warning: {remark}"),
        });
        plan.extend(warnings);
        plan
    }
}

/// A number with twelve significant digits, which hides the rounding of binary fractions: a hop of the printed
/// length still spans whole cells. Very large ones, such as the nodata of 32-bit files, get an exponent.
fn significant(value: f64) -> String {
    let rounded: f64 = format!("{value:.11e}").parse().unwrap_or(value);
    if rounded.abs() < 1e15 { rounded.to_string() } else { format!("{rounded:e}") }
}

/// A coordinate in metres, rounded to the micrometre: it may be the small difference of large numbers.
fn micrometres(metres: f64) -> String {
    let rounded: f64 = format!("{metres:.6}").parse().unwrap_or(metres);
    // No sign before a zero.
    (rounded + 0.0).to_string()
}

/// Slopes of all cells that have one, for rasters of any size.
fn slopes_rad(elevation: &crate::Elevation) -> Result<Vec<f64>, TerrainError> {
    // In tiles that overlap by one cell on each side, so that every tile is within the bounds of a grid.
    let (width, height) = (elevation.width, elevation.height);
    let side = GRID_SIDE_MAX - 2;
    let mut slopes = Vec::new();
    for y in (0..height).step_by(side as usize) {
        for x in (0..width).step_by(side as usize) {
            let inner = [x..(x + side).min(width), y..(y + side).min(height)];
            let (west, south) = (x.saturating_sub(1), y.saturating_sub(1));
            let window = Window {
                x: west,
                y: south,
                width: (inner[0].end + 1).min(width) - west,
                height: (inner[1].end + 1).min(height) - south,
            };
            let tile = crate::Elevation {
                width: window.width,
                height: window.height,
                cell_size_m: elevation.cell_size_m,
                heights_m: elevation.rows(window).flatten().copied().collect(),
            };
            let relief = Relief::of_elevation(&tile, 1.0, 1)?;
            for (cell, known) in relief.grid.iter().zip(&relief.cells) {
                let inside =
                    inner[0].contains(&(west + cell.x as u32)) && inner[1].contains(&(south + cell.y as u32));
                if let (true, Some((_, [gx, gy]))) = (inside, known) {
                    slopes.push(libm::atan((gx * gx + gy * gy).sqrt()));
                }
            }
        }
    }
    Ok(slopes)
}

impl fmt::Display for TerrainCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { header, georeference, slope, .. } = self;
        let cell_m = georeference.cell_size_m;
        let extent = |cells: u32| f64::from(cells) * cell_m;
        let mut line = |name: &str, value: String| writeln!(f, "{name:<18} {value}");
        line("file", self.file.clone())?;
        let format = match header.format {
            crate::RasterFormat::Geotiff => "GeoTIFF",
            crate::RasterFormat::AsciiGrid => "ESRI ASCII grid",
        };
        line("format", format!("{format}, {}", header.sample))?;
        let (width, height) = (header.width, header.height);
        line("size", format!("{width} x {height} cells, {:.1} x {:.1} m", extent(width), extent(height)))?;
        if (self.surveyed_width, self.surveyed_height) != (width, height) {
            line("surveyed", format!("{} x {} cells", self.surveyed_width, self.surveyed_height))?;
        }
        line("resolution", format!("{} m", significant(cell_m)))?;
        line("coordinate system", georeference.coordinate_system.clone())?;
        let [west, south] = [georeference.west_m, georeference.south_m].map(micrometres);
        line("south-west cell", format!("({west}, {south}) m at its middle"))?;
        let Range { min, max } = self.elevation_m;
        line("elevation", format!("{min:.2} to {max:.2} m, mean {:.2} m", self.elevation_mean_m))?;
        line(
            "slope",
            format!(
                "p50 {:.1}, p75 {:.1}, p90 {:.1}, p95 {:.1}, p99 {:.1}, max {:.1} degrees",
                slope.p50_deg, slope.p75_deg, slope.p90_deg, slope.p95_deg, slope.p99_deg, slope.max_deg
            ),
        )?;
        line(
            "over the limit",
            format!("{:.1} % over {:.1} degrees", 100.0 * slope.over_limit_share, slope.limit_deg),
        )?;
        let declared = header
            .nodata
            .map_or("none declared".into(), |value| format!("declared as {}", significant(value)));
        line(
            "nodata",
            format!("{} cells ({:.1} %), {declared}", self.nodata_cells, 100.0 * self.nodata_share),
        )?;
        line("impassable", format!("{:.1} %", 100.0 * self.impassable_share))?;
        writeln!(f, "what Hopper does")?;
        self.treatment.iter().try_for_each(|sentence| writeln!(f, "  {sentence}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_printed_without_binary_rounding() {
        for (value, need) in [
            (0.9960000000000001, "0.996"),
            (2.0, "2"),
            (4.98, "4.98"),
            (1.0 / 3.0, "0.333333333333"),
            (-9999.0, "-9999"),
            (f64::from(f32::MIN), "-3.40282346639e38"),
        ] {
            assert_eq!(significant(value), need);
        }
        for (metres, need) in
            [(1000.3 - 999.0, "1.3"), (-4.0e-9, "0"), (4_565_000.123_000_001, "4565000.123"), (-0.5, "-0.5")]
        {
            assert_eq!(micrometres(metres), need);
        }
    }

    #[test]
    fn the_printed_resolution_can_be_spanned_by_a_hop() {
        let text = "ncols 3\nnrows 2\nxllcorner 1000.1\nyllcorner 1999.502\ncellsize 0.9960000000000001\n\
                    0 0 0\n0 0.9 0\n";
        let raster = RasterFile::new(std::io::Cursor::new(text)).unwrap();
        let check = TerrainCheck::of(raster, "grid", None, 30.0).unwrap();
        let told = check.to_string();
        for line in [
            "resolution         0.996 m\n",
            "south-west cell    (1000.598, 2000) m at its middle\n",
            "hop_distance_m = 0.996 (or a multiple)",
        ] {
            assert!(told.contains(line), "{line:?} is not in {told}");
        }
        assert_eq!(crate::lattice::hop_cells(0.996, check.georeference.cell_size_m).unwrap(), 1);
    }
}
