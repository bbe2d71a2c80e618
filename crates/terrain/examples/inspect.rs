//! Prints what hopping over an elevation model would meet: `cargo run --release --example inspect -- FILE`.

#![allow(clippy::print_stdout, reason = "an example shows its result")]

use std::path::Path;
use std::process::ExitCode;

use terrain::{TerrainCheck, TerrainError};

/// Where slopes are too steep for the hopper of Sakamoto & Kunii 2023, degrees.
const SLOPE_LIMIT_DEG: f64 = 30.0;

fn main() -> Result<ExitCode, TerrainError> {
    let Some(file) = std::env::args_os().nth(1) else {
        println!("need a GeoTIFF or an ESRI ASCII grid");
        return Ok(ExitCode::from(2));
    };
    println!("{:#?}", TerrainCheck::of_file(Path::new(&file), None, SLOPE_LIMIT_DEG)?);
    Ok(ExitCode::SUCCESS)
}
