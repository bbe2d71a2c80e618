//! Reading elevation files: every layout that is promised, and one clear error for everything else.

#![allow(clippy::unwrap_used)]

mod ascii_grid;
mod check;
mod foreign_models;
mod geotiff;
mod malformed;
mod meter;
mod tiff_writer;

use std::io::Cursor;

use terrain::{RasterFile, TerrainError, Window};

/// All values of the file `bytes`, southernmost row first.
fn values(bytes: &[u8]) -> Result<Vec<f64>, TerrainError> {
    let mut raster = RasterFile::new(Cursor::new(bytes))?;
    let window = Window::all(raster.header().width, raster.header().height);
    raster.values(window)
}

/// The elevation in a file's bytes: the georeference counts too.
fn elevation(bytes: &[u8]) -> Result<terrain::Elevation, TerrainError> {
    let raster = RasterFile::new(Cursor::new(bytes))?;
    let window = Window::all(raster.header().width, raster.header().height);
    raster.elevation(window)
}

fn error(bytes: &[u8]) -> String {
    elevation(bytes).expect_err("the file is refused").to_string()
}

/// Asserts that `text` contains every one of `words`.
fn says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "{word:?} is missing in: {text}");
    }
}
