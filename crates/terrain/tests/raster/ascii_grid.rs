//! ESRI ASCII grid: header orders, corners and centres, nodata, broken files.

use std::io::Cursor;

use terrain::{PixelIs, RasterFile, Window};

use crate::{elevation, error, says, values};

const GRID: &str = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200.5\ncellsize 2\nNODATA_value -9999\n\
                    1 2 3\n4 -9999 6.5e0\n";

#[test]
fn rows_are_turned_south_first_and_nodata_is_none() {
    let read = values(GRID.as_bytes()).unwrap();
    assert_eq!(read[0], 4.0);
    assert!(read[1].is_nan());
    assert_eq!(read[2..], [6.5, 1.0, 2.0, 3.0]);
}

#[test]
fn corners_lie_half_a_cell_outside_of_centres() {
    let georeference = |text: &str| RasterFile::new(Cursor::new(text)).unwrap().georeference().unwrap();
    let corner = georeference(GRID);
    assert_eq!((corner.pixel_is, corner.west_m, corner.south_m), (PixelIs::Area, 101.0, 201.5));
    let centre = georeference(&GRID.replace("corner", "center"));
    assert_eq!((centre.pixel_is, centre.west_m, centre.south_m), (PixelIs::Point, 100.0, 200.5));
}

#[test]
fn the_header_may_come_in_any_order_and_case_and_without_nodata() {
    let other = "NROWS 2\r\nNCOLS 3\r\nNODATA_VALUE -9999\r\nCELLSIZE 2\r\nYLLCORNER 200.5\r\nXLLCORNER 100\r\n\
                 1 2 3\r\n4 -9999 6.5\r\n";
    let (a, b) = (values(GRID.as_bytes()).unwrap(), values(other.as_bytes()).unwrap());
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
    let without = values(GRID.replace("NODATA_value -9999\n", "").as_bytes()).unwrap();
    assert_eq!(without, [4.0, -9999.0, 6.5, 1.0, 2.0, 3.0], "the first row is not taken for nodata");
}

#[test]
fn rows_may_break_anywhere() {
    let wrapped = GRID.replace("1 2 3\n4 -9999 6.5e0", "1 2\n3 4\n-9999\t6.5");
    assert_eq!(values(wrapped.as_bytes()).unwrap()[3..], [1.0, 2.0, 3.0]);
}

#[test]
fn a_window_reads_its_cells_only() {
    let window = Window { x: 1, y: 1, width: 2, height: 1 };
    assert_eq!(RasterFile::new(Cursor::new(GRID)).unwrap().values(window).unwrap(), [2.0, 3.0]);
}

#[test]
fn broken_grids_are_refused_with_need_and_got() {
    let with = |from: &str, to: &str| error(GRID.replace(from, to).as_bytes());
    says(&with("4 -9999 6.5e0", "4 -9999"), &["2 rows of 3 values", "column 2 of row 1", "cut short"]);
    says(&with("1 2 3", "1 two 3"), &["a number in column 1 of row 0", "two"]);
    says(&with("6.5e0", "6.5 7"), &["nothing after 2 rows", "7"]);
    says(&with("nrows 2", "nrows 0"), &["nrows", "1 to", "0"]);
    says(&with("nrows 2", "nrows -2"), &["nrows"]);
    says(&with("cellsize 2\n", ""), &["cellsize", "none"]);
    says(&with("cellsize 2", "cellsize 0"), &["cell size", "above 0 m"]);
    says(&with("cellsize 2", "cellsize wide"), &["a number after", "wide"]);
    says(&with("cellsize 2", "dx 2\ndy 3"), &["square", "2 m x 3 m"]);
    says(&with("yllcorner", "yllcenter"), &["corners or centres for both"]);
    says(&with("xllcorner", "xyz"), &["ncols, nrows, xllcorner", "xyz"]);
    says(&with("1 2 3", &format!("1 2 {}", "3".repeat(1000))), &["at most 64 characters"]);
    says(&error(b"ncols"), &["a value after ncols"]);
    says(&with("1 2 3\n4 -9999 6.5e0", "-9999 -9999 nan\n-9999 inf -9999"), &["need heights", "all 6 cells"]);
}

#[test]
fn a_header_that_claims_too_many_cells_is_refused_without_their_memory() {
    let text = GRID.replace("ncols 3", "ncols 2000000000").replace("nrows 2", "nrows 2000000000");
    says(&error(text.as_bytes()), &["16777216", "crop"]);
    let text = GRID.replace("ncols 3", "ncols 4000").replace("nrows 2", "nrows 4000");
    says(&error(text.as_bytes()), &["cut short"]);
}

#[test]
fn degrees_are_told_from_their_size_and_from_a_prj_file() {
    let degrees = GRID.replace("cellsize 2", "cellsize 0.000833").replace("200.5", "-4.6");
    says(&error(degrees.as_bytes()), &["degrees", "reproject"]);
    assert!(elevation(GRID.as_bytes()).is_ok());

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dem.asc");
    std::fs::write(&path, GRID).unwrap();
    let system = || RasterFile::open(&path).unwrap().georeference();
    assert_eq!(system().unwrap().coordinate_system, "none named, taken for metres");
    std::fs::write(folder.path().join("dem.prj"), "PROJCS[\"Mars eqc\",GEOGCS[\"Mars 2000\"]]").unwrap();
    assert_eq!(system().unwrap().coordinate_system, "Mars eqc");
    std::fs::write(folder.path().join("dem.prj"), "GEOGCS[\"Mars 2000\"]").unwrap();
    says(&system().unwrap_err().to_string(), &["degrees", "Mars 2000", "+R=RADIUS"]);
    let text = "GEOGCS[\"Moon\",DATUM[\"D\",SPHEROID[\"Moon\",1737400.0,0.0]],UNIT[\"Degree\",0.017]]";
    std::fs::write(folder.path().join("dem.prj"), text).unwrap();
    says(&system().unwrap_err().to_string(), &["Moon", "+R=1737400 +units=m"]);
}

#[test]
fn a_missing_file_is_named() {
    let Err(refused) = RasterFile::open(std::path::Path::new("no/such/dem.tif")) else { panic!("it opened") };
    says(&refused.to_string(), &["no/such/dem.tif", "cannot be read"]);
}

#[test]
fn a_crop_in_metres_takes_the_cells_whose_middles_it_covers() {
    // Middles at eastings 101, 103, 105 and northings 201.5, 203.5.
    let georeference = RasterFile::new(Cursor::new(GRID)).unwrap().georeference().unwrap();
    let window = |crop: [f64; 4]| georeference.window((3, 2), crop);
    assert_eq!(window([101.5, 200.5, 4.0, 4.0]).unwrap(), Window { x: 1, y: 0, width: 2, height: 2 });
    assert_eq!(window([100.0, 202.0, 2.0, 2.0]).unwrap(), Window { x: 0, y: 1, width: 1, height: 1 });
    for crop in [[90.0, 200.5, 4.0, 4.0], [101.5, 200.5, 6.0, 4.0], [101.1, 200.5, 1.0, 4.0], [f64::NAN; 4]] {
        says(
            &window(crop).unwrap_err().to_string(),
            &["eastings 100 and 106 m", "northings 200.5 and 204.5 m"],
        );
    }
}
