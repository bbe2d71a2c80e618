//! Elevation models: GeoTIFF or ESRI ASCII grid to a survey, ground, or one error.

use std::io::Cursor;

use terrain::{RasterFile, Relief, Sand, Terrain, TerrainCheck, Window};

use crate::told;

/// Largest window that is read here, cells along a side.
const SIDE_MAX: u32 = 256;

/// Surveys a part of the file, and makes ground of it.
pub fn read(bytes: &[u8]) {
    let open = || RasterFile::new(Cursor::new(bytes));
    let raster = match open() {
        Ok(raster) => raster,
        Err(error) => return told(&error),
    };
    let header = raster.header();
    let (width, height) = (header.width.min(SIDE_MAX), header.height.min(SIDE_MAX));
    let window = Window { x: header.width - width, y: header.height - height, width, height };
    // A whole file of a few bytes is read too: it says how many cells it has, and may lie.
    let whole = Window::all(header.width, header.height);
    let mut all = open().expect("what was opened once is opened again");
    match all.values(whole) {
        Ok(values) => assert_eq!(values.len() as u64, whole.cells()),
        Err(error) => told(&error),
    }
    match TerrainCheck::of(open().expect("as before"), "hostile", Some(window), 30.0) {
        Ok(survey) => told(&survey),
        Err(error) => told(&error),
    }
    let elevation = match raster.elevation(window) {
        Ok(elevation) => elevation,
        Err(error) => return told(&error),
    };
    assert_eq!(elevation.heights_m.len() as u64, window.cells());
    assert!(elevation.heights_m.iter().all(|height| height.is_nan() || height.abs() <= 1e6));
    if let Err(error) = elevation.resampled(elevation.cell_size_m * 1.5) {
        told(&error);
    }
    match Relief::of_elevation(&elevation, 1.0, 1) {
        Ok(relief) => {
            let terrain = Terrain::new(&relief, relief.mean_height_m(), 0.5, &Sand::default());
            assert_eq!(terrain.cells.len() as u64, window.cells());
        }
        Err(error) => told(&error),
    }
}

/// An ASCII grid with every keyword.
#[must_use]
pub fn ascii_grids() -> Vec<Vec<u8>> {
    vec![
        b"ncols 4\nnrows 3\nxllcorner 100.5\nyllcorner 200\ncellsize 2\nNODATA_value -9999\n\
          1 2 3.5 4\n5 -9999 7 8e0\n9 10 11 12\n"
            .to_vec(),
        b"NROWS 1\nNCOLS 2\nXLLCENTER 1e3\nYLLCENTER -3\nDX 1\nDY 1\n0 -0.5\n".to_vec(),
    ]
}
