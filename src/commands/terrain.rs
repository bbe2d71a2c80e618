//! `hopper terrain`: checks an elevation model.

use std::path::PathBuf;

use ::terrain::{RasterFile, TerrainCheck, Window};
use hopper_sim::elevation_args::ElevationArgs;
use node::{Exit, Failure};
use report::Format;

use crate::stdout::{print, print_json};

/// Subcommands of `hopper terrain`.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Print size, resolution, coordinate system, elevations, slopes, gaps, and what Hopper does with each.
    #[command(
        after_help = "Examples:\n  hopper terrain check dem.tif\n  hopper terrain check dem.tif --crop 100,100,256,256 --slope-limit 25"
    )]
    Check(Args),
}

/// Arguments of `hopper terrain check`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// A GeoTIFF or an ESRI ASCII grid.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    elevation: ElevationArgs,
    /// Check only this part, in cells from the south-western corner.
    #[arg(long, value_parser = window, value_name = "X,Y,WIDTH,HEIGHT")]
    crop: Option<Window>,
    /// Slope above which ground is impassable, degrees.
    #[arg(long, default_value_t = 30.0, value_parser = slope, value_name = "DEGREES")]
    slope_limit: f64,
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// Runs the command.
///
/// # Errors
/// Exit code 2 if the file is not a usable elevation model.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    let Command::Check(args) = command;
    let file = args.elevation.model(&args.file)?;
    let nodata = args.elevation.nodata().map(<[f64]>::to_vec);
    let raster = RasterFile::open(&file).map_err(Failure::usage)?.with_nodata(nodata);
    let survey = TerrainCheck::of(raster, &file.display().to_string(), args.crop, args.slope_limit)
        .map_err(|error| Failure::usage(error.of(&file)))?;
    match args.format {
        Format::Text => print(&format!(
            "{survey}  first mission: `hopper run --dem {}` fits hop, crop, start and goal to it\n",
            file.display()
        ))?,
        Format::Json => print_json(&survey)?,
    }
    Ok(Exit::Done)
}

fn window(text: &str) -> Result<Window, String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, width, height]) => Ok(Window { x, y, width, height }),
        _ => Err(format!("a crop is X,Y,WIDTH,HEIGHT in cells, got {text:?}")),
    }
}

fn slope(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|degrees| (1.0..90.0).contains(degrees))
        .ok_or_else(|| format!("a slope limit is 1 to 90 degrees, got {text:?}"))
}
