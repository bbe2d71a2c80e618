//! `terrain check`: what it finds, and what it says of it.

use terrain::{TerrainCheck, Window};

use crate::says;
use crate::tiff_writer::{GeoTiff, Sample};

/// 40 x 30 cells of 2 m: a plane that rises 1 m a cell eastwards (26.6°), with a cliff and a hole.
fn check(change: impl FnOnce(&mut GeoTiff), window: Option<Window>) -> TerrainCheck {
    let mut heights: Vec<f64> = (0..40 * 30).map(|index| f64::from(index % 40)).collect();
    // In the middle row a step that makes three cells steep; one corner without height.
    heights[15 * 40 + 20] += 100.0;
    heights[0] = -9999.0;
    let mut file = GeoTiff { nodata: Some("-9999"), sample: Sample::F64, ..GeoTiff::new(40, 30, heights) };
    change(&mut file);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dem.tif");
    std::fs::write(&path, file.bytes()).unwrap();
    TerrainCheck::of_file(&path, window, 30.0).unwrap()
}

#[test]
fn size_slopes_nodata_and_shares_are_those_of_the_file() {
    let check = check(|_| (), None);
    assert_eq!((check.header.width, check.header.height), (40, 30));
    assert_eq!((check.elevation_m.min, check.elevation_m.max), (0.0, 120.0));
    assert_eq!(check.nodata_cells, 1);
    let plane = 0.5f64.atan().to_degrees();
    assert!((check.slope.p50_deg - plane).abs() < 1e-9 && (check.slope.p99_deg - plane).abs() < 1e-9);
    // The four neighbours of the step see it in their central difference, the step itself does not.
    assert!((check.slope.over_limit_share - 4.0 / 1199.0).abs() < 1e-12, "{check:?}");
    assert!((check.impassable_share - 5.0 / 1200.0).abs() < 1e-12);
}

#[test]
fn a_part_is_surveyed_alone() {
    let part = check(|_| (), Some(Window { x: 2, y: 2, width: 10, height: 8 }));
    assert_eq!((part.surveyed_width, part.nodata_cells, part.impassable_share), (10, 0, 0.0));
    says(&part.to_string(), &["surveyed", "10 x 8 cells"]);
}

#[test]
fn the_text_says_everything_and_what_hopper_does_with_it() {
    let check = check(|_| (), None);
    says(
        &check.to_string(),
        &[
            "40 x 30 cells, 80.0 x 60.0 m",
            "resolution         2 m",
            "projected, EPSG:32633",
            "0.00 to 120.00 m",
            "p50 26.6",
            "over 30.0 degrees",
            "1 cells (0.1 %), declared as -9999",
            "impassable         0.4 %",
            "half a cell is added",
            "hop_distance_m = 2",
            "datum_m",
        ],
    );
    let undeclared = self::check(|file| file.nodata = None, None);
    says(
        &undeclared.to_string(),
        &["none declared", "-9999 looks like nodata", "gdal_translate -a_nodata -9999"],
    );
}

#[test]
fn a_file_larger_than_a_mission_is_surveyed_all_the_same() {
    let heights: Vec<f64> = (0..2500 * 3).map(|index| f64::from(index % 2500)).collect();
    let check = check(|file| *file = GeoTiff { sample: Sample::F64, ..GeoTiff::new(2500, 3, heights) }, None);
    let plane = 0.5f64.atan().to_degrees();
    assert!((check.slope.max_deg - plane).abs() < 1e-9, "no seam between its bands: {check:?}");
    says(&check.to_string(), &["too large for a mission", "crop_cells"]);
}
