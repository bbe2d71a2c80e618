//! Foreign files: masks, units, coordinate systems in any dialect, values that look like nodata, lattices but for rounding.

use std::path::{Path, PathBuf};

use terrain::{
    RasterFile, Remark, Sand, SourceCells, Survey, TerrainCheck, TerrainError, Window, read_layer,
};

use crate::tiff_writer::{GeoTiff, Mask, Packing, Sample};
use crate::{error, says, values};

const SIDE: usize = 20;

/// Gentle ground of 20 x 20 cells around 1000 m, northernmost row first.
fn ground() -> Vec<f64> {
    (0..SIDE * SIDE).map(|index| 1000.0 + 3.0 * (index as f64 / 17.0).sin()).collect()
}

fn plain() -> GeoTiff {
    GeoTiff { sample: Sample::F64, ..GeoTiff::new(SIDE, SIDE, ground()) }
}

/// A folder with one raster and what stands beside it.
struct Folder {
    folder: tempfile::TempDir,
    raster: PathBuf,
}

impl Folder {
    fn new(name: &str, raster: &[u8]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let raster_path = folder.path().join(name);
        std::fs::write(&raster_path, raster).unwrap();
        Self { folder, raster: raster_path }
    }

    fn with(self, name: &str, contents: impl AsRef<[u8]>) -> Self {
        std::fs::write(self.folder.path().join(name), contents).unwrap();
        self
    }

    fn survey(&self) -> Result<Survey, TerrainError> {
        survey(&self.raster, None)
    }

    fn refusal(&self) -> String {
        self.survey().expect_err("the file is refused").to_string()
    }
}

fn survey(path: &Path, nodata: Option<Vec<f64>>) -> Result<Survey, TerrainError> {
    let raster = RasterFile::open(path)?.with_nodata(nodata);
    let window = Window::all(raster.header().width, raster.header().height);
    raster.survey(window)
}

fn ascii(header: &str) -> Vec<u8> {
    let rows: Vec<String> = ground()
        .chunks(SIDE)
        .map(|row| row.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "))
        .collect();
    format!("ncols {SIDE}\nnrows {SIDE}\n{header}\n{}\n", rows.join("\n")).into_bytes()
}

fn metres() -> Vec<u8> {
    ascii("xllcorner 500000\nyllcorner 4000000\ncellsize 2")
}

fn degrees() -> Vec<u8> {
    ascii("xllcorner 10\nyllcorner 45\ncellsize 0.0078125")
}

fn gaps(survey: &Survey) -> usize {
    survey.elevation.heights_m.iter().filter(|height| height.is_nan()).count()
}

/// Every third cell is left out.
fn counts() -> Vec<bool> {
    (0..SIDE * SIDE).map(|index| index % 3 != 0).collect()
}

/// P-DEM-MASK: Cells that are left out by a mask, inside a raster or beside it, have no height,
/// whatever the layout.
#[test]
fn masked_cells_have_no_height_in_every_layout_of_the_mask() {
    let south_first: Vec<bool> = counts().chunks(SIDE).rev().flatten().copied().collect();
    let mut layouts = 0;
    for bits in [1, 8] {
        for packing in [Packing::None, Packing::Lzw, Packing::Deflate] {
            for rows in [SIDE, 7, 0] {
                for (after_overview, big_endian, big_tiff) in [
                    (false, false, false),
                    (true, false, false),
                    (true, true, false),
                    (false, true, true),
                    (true, false, true),
                ] {
                    let mask = Mask { counts: counts(), bits, packing, rows, after_overview };
                    let file = GeoTiff { mask: Some(mask), big_endian, big_tiff, ..plain() };
                    let read = values(&file.bytes()).unwrap_or_else(|error| panic!("{error}: {file:?}"));
                    let known: Vec<bool> = read.iter().map(|height| !height.is_nan()).collect();
                    assert_eq!(
                        known, south_first,
                        "{bits} bits, {packing:?}, {rows}, {after_overview}, {big_tiff}"
                    );
                    layouts += 1;
                }
            }
        }
    }
    assert_eq!(layouts, 90);
    // Of a part of the file, the part of the mask is taken.
    let mask = Mask { counts: counts(), bits: 1, packing: Packing::Deflate, rows: 3, after_overview: false };
    let file = GeoTiff { mask: Some(mask), ..plain() };
    let window = Window { x: 3, y: 5, width: 9, height: 4 };
    let part = RasterFile::new(std::io::Cursor::new(file.bytes())).unwrap().values(window).unwrap();
    for (index, height) in part.iter().enumerate() {
        let (x, y) = (3 + index % 9, 5 + index / 9);
        assert_eq!(!height.is_nan(), south_first[y * SIDE + x], "({x}, {y})");
    }
}

/// P-DEM-MASK. A mask in a separate file applies to rasters of either format, and must have their
/// shape.
#[test]
fn a_mask_beside_the_file_counts_as_one_inside() {
    let mask = GeoTiff::of_counts(SIDE, SIDE, &counts());
    let masked = counts().iter().filter(|counts| !**counts).count();
    let packed = GeoTiff { packing: Packing::Deflate, tiled: true, chunk: (16, 16), ..mask.clone() };
    for (name, raster, beside) in [
        ("dem.tif", plain().bytes(), "dem.tif.msk"),
        ("dem.asc", metres(), "dem.asc.msk"),
        ("DEM.TIF", plain().bytes(), "DEM.TIF.MSK"),
    ] {
        for mask in [&mask, &packed] {
            let survey = Folder::new(name, &raster).with(beside, mask.bytes()).survey().unwrap();
            assert_eq!(gaps(&survey), masked, "{name}");
        }
    }
    let other = GeoTiff::of_counts(3, 3, &[true; 9]);
    says(
        &Folder::new("dem.tif", &plain().bytes()).with("dem.tif.msk", other.bytes()).refusal(),
        &["dem.tif.msk", "20 x 20", "3 x 3"],
    );
    says(&Folder::new("dem.tif", &plain().bytes()).with("dem.tif.msk", "hello").refusal(), &["dem.tif.msk"]);
}

fn metadata_unit(unit: &str) -> &'static str {
    let text = format!(
        "<GDALMetadata><Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">{unit}</Item></GDALMetadata>"
    );
    Box::leak(text.into_boxed_str())
}

/// P-DEM-UNITS: Coordinates and heights in units other than metres are converted with a note;
/// unknown or contradictory units are refused.
#[test]
fn heights_in_other_units_are_converted_and_said() {
    for (unit, metres) in [
        ("m", 1.0),
        ("metre", 1.0),
        ("Meters", 1.0),
        ("ft", 0.3048),
        ("Foot", 0.3048),
        ("US survey foot", 1200.0 / 3937.0),
        ("us-ft", 1200.0 / 3937.0),
        ("km", 1000.0),
        ("KILOMETER", 1000.0),
        ("cm", 0.01),
        ("Centimetre", 0.01),
        ("yd", 0.9144),
    ] {
        let small: Vec<f64> = ground().iter().map(|height| height / 1000.0).collect();
        let file = GeoTiff {
            metadata: Some(metadata_unit(unit)),
            sample: Sample::F64,
            ..GeoTiff::new(SIDE, SIDE, small.clone())
        };
        let survey = Folder::new("dem.tif", &file.bytes()).survey().unwrap();
        assert!((survey.elevation.heights_m[SIDE * (SIDE - 1)] - small[0] * metres).abs() < 1e-9, "{unit}");
        assert_eq!(survey.remarks.is_empty(), metres == 1.0, "{unit}");
        let told =
            TerrainCheck::of_file(&Folder::new("dem.tif", &file.bytes()).with("x", "").keep(), None, 30.0)
                .unwrap()
                .to_string();
        assert_eq!(told.contains("converted to metres"), metres != 1.0, "{told}");
    }
    let nameless = GeoTiff { metadata: Some(metadata_unit("unspecified")), ..plain() };
    assert_eq!(Folder::new("dem.tif", &nameless.bytes()).survey().unwrap().remarks, []);
    let foreign = GeoTiff { metadata: Some(metadata_unit("degC")), ..plain() };
    says(&error(&foreign.bytes()), &["unit of heights", "degC", "gdal_edit.py -units"]);
    let both = GeoTiff {
        metadata: Some(metadata_unit("ft")),
        keys: Some(vec![(1024, 1), (3072, 32633), (4096, 5703)]),
        ..plain()
    };
    says(&error(&both.bytes()), &["unit of heights", "one unit", "foot of 0.3048 m", "metre"]);
    let depths = GeoTiff { keys: Some(vec![(1024, 1), (3072, 32633), (4096, 6357)]), ..plain() };
    says(&error(&depths.bytes()), &["depths", "positive upwards"]);
}

impl Folder {
    /// The raster's path, its folder kept.
    fn keep(self) -> PathBuf {
        let _ = self.folder.keep();
        self.raster
    }
}

/// P-DEM-UNITS. Coordinates in another unit are converted where the unit of heights is stated, and
/// refused where it is not.
#[test]
fn coordinates_in_other_units_are_converted_or_refused() {
    let foot = 1200.0 / 3937.0;
    let stated = GeoTiff { keys: Some(vec![(1024, 1), (3072, 2263), (4099, 9003)]), ..plain() };
    let survey = Folder::new("dem.tif", &stated.bytes()).survey().unwrap();
    assert!((survey.elevation.cell_size_m - 2.0 * foot).abs() < 1e-12);
    assert!((survey.georeference.west_m - 1001.0 * foot).abs() < 1e-9);
    assert!((survey.elevation.heights_m[SIDE * (SIDE - 1)] - 1000.0 * foot).abs() < 1e-9);
    assert!(matches!(survey.remarks[..], [Remark::CoordinatesConverted(_), Remark::HeightsConverted(_)]));
    // A unit of the band settles the heights as well.
    let band =
        GeoTiff { keys: Some(vec![(1024, 1), (3072, 2263)]), metadata: Some(metadata_unit("m")), ..plain() };
    let survey = Folder::new("dem.tif", &band.bytes()).survey().unwrap();
    assert_eq!(survey.elevation.heights_m[SIDE * (SIDE - 1)], 1000.0);
    for keys in [
        vec![(1024, 1), (3072, 2263)],
        vec![(1024, 1), (3072, 2222)],
        vec![(1024, 1), (3072, 32767), (3076, 9002)],
        vec![(1024, 1), (3072, 32767), (3076, 9036)],
        vec![(3076, 9003)],
    ] {
        let file = GeoTiff { keys: Some(keys.clone()), ..plain() };
        says(&error(&file.bytes()), &["unit of heights", "nothing said of heights", "gdal_edit.py"]);
    }
    for (prj, says_of) in [
        ("PROJCS[\"p\",GEOGCS[\"g\"],UNIT[\"Foot_US\",0.3048006096012192]]", "Foot_US"),
        ("Projection UTM\nZone 33\nUnits FEET\n", "US survey foot"),
        ("EPSG:2263", "US survey foot"),
        ("+proj=utm +zone=33 +units=ft", "foot"),
    ] {
        says(
            &Folder::new("dem.asc", &metres()).with("dem.prj", prj).refusal(),
            &["unit of heights", says_of],
        );
    }
    let both = Folder::new("dem.asc", &metres())
        .with("dem.prj", "Projection UTM\nZone 33\nUnits FEET\nZunits FEET\n");
    let survey = both.survey().unwrap();
    assert!((survey.elevation.cell_size_m - 2.0 * foot).abs() < 1e-12 && survey.remarks.len() == 2);
}

/// P-DEM-CRS: Degrees are refused in every dialect of `.prj` files, and by the extent of a raster
/// without a coordinate system.
#[test]
fn degrees_are_refused_whatever_the_prj_file_says_or_not() {
    let wkt = "GEOGCS[\"Moon\",DATUM[\"D\",SPHEROID[\"Moon\",1737400.0,0.0]],UNIT[\"Degree\",0.017]]";
    let utf16: Vec<u8> =
        [0xff, 0xfe].into_iter().chain(wkt.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let metres = metres();
    for prj in [
        wkt.as_bytes(),
        format!("\u{feff}{wkt}\r\n").as_bytes(),
        &utf16,
        b"EPSG:4326",
        b"+proj=longlat +a=1737400 +b=1737400",
        b"{\"type\":\"GeographicCRS\",\"name\":\"WGS 84\"}",
        b"Projection    GEOGRAPHIC\nUnits DD\n",
    ] {
        for raster in [&degrees(), &metres] {
            says(&Folder::new("dem.asc", raster).with("dem.prj", prj).refusal(), &["degrees", "gdalwarp"]);
        }
    }
    for prj in ["", "hello", "PROJCS[", "\u{feff}", "EPSG:99999"] {
        says(
            &Folder::new("dem.asc", &degrees()).with("dem.prj", prj).refusal(),
            &["degrees", "no coordinate system named"],
        );
    }
    assert!(Folder::new("dem.asc", &metres).with("dem.prj", "").survey().is_ok());
    says(
        &Folder::new("dem.asc", &metres).with("dem.prj", "hello").refusal(),
        &["dem.prj", "coordinate system", "hello", "remove it"],
    );
    for (raster, prj) in [("DEM.ASC", "DEM.PRJ"), ("dem.asc", "dem.PRJ"), ("dem.asc", "Dem.Prj")] {
        says(&Folder::new(raster, &metres).with(prj, wkt).refusal(), &["degrees", "+R=1737400"]);
    }
}

/// P-DEM-CRS. Without a coordinate system, cells that lie where longitudes and latitudes may are in
/// degrees, at any size.
#[test]
fn degrees_are_recognised_at_any_cell_size_by_their_extent() {
    for header in [
        "xllcorner 10\nyllcorner 45\ncellsize 0.0625",
        "xllcorner -120.5\nyllcorner 30\ncellsize 1",
        "xllcorner 340\nyllcorner -60\ncellsize 1",
        "xllcorner -180\nyllcorner -90\ncellsize 9",
        "xllcenter 0\nyllcenter -80\ncellsize 8",
        "xllcorner 0\nyllcorner 0\ncellsize 0.001",
        "xllcorner 0\nyllcorner 0\ndx 18\ndy 4.5",
    ] {
        says(
            &Folder::new("dem.asc", &ascii(header)).refusal(),
            &["degrees", "no coordinate system named", "LOCAL_CS"],
        );
    }
    for header in [
        "xllcorner 0\nyllcorner 0\ncellsize 1",
        "xllcenter 0\nyllcenter 0\ncellsize 2",
        "xllcorner 500\nyllcorner 20\ncellsize 1",
        "xllcorner 10\nyllcorner 80\ncellsize 2",
        "xllcorner 170\nyllcorner 45\ncellsize 12",
    ] {
        assert!(Folder::new("dem.asc", &ascii(header)).survey().is_ok(), "{header}");
    }
    let site = Folder::new("dem.asc", &ascii("xllcorner 10\nyllcorner 45\ncellsize 0.0625"));
    let survey = site.with("dem.prj", "LOCAL_CS[\"site\",UNIT[\"metre\",1]]").survey().unwrap();
    assert_eq!((survey.elevation.cell_size_m, survey.remarks), (0.0625, vec![]));
}

/// P-DEM-AUX: Scale, offset, nodata, unit, place and coordinate system of an `.aux.xml` file are
/// applied, or the file is refused.
#[test]
fn what_the_auxiliary_file_says_counts() {
    let stored: Vec<f64> = (0..SIDE * SIDE).map(|index| (index % 40) as f64).collect();
    let file = GeoTiff { sample: Sample::I16, ..GeoTiff::new(SIDE, SIDE, stored) };
    let with = |band: &str| {
        let xml = format!("<PAMDataset><PAMRasterBand band=\"1\">{band}</PAMRasterBand></PAMDataset>");
        Folder::new("dem.tif", &file.bytes()).with("dem.tif.aux.xml", xml)
    };
    let survey = with("<Offset>100</Offset><Scale>0.01</Scale>").survey().unwrap();
    let height_m = |x: usize| survey.elevation.heights_m[SIDE * (SIDE - 1) + x];
    assert_eq!((height_m(0), height_m(5)), (100.0, 100.05));
    assert_eq!(gaps(&with("<NoDataValue>7</NoDataValue>").survey().unwrap()), 10);
    let feet = with("<UnitType>ft</UnitType>").survey().unwrap();
    assert!(matches!(feet.remarks[..], [Remark::HeightsConverted(_)]));
    says(&with("<Scale>half</Scale>").refusal(), &["dem.tif.aux.xml", "Scale", "half"]);
    says(&with("<Unit").refusal(), &["dem.tif.aux.xml", "XML"]);
    let xml = "<PAMDataset><SRS>EPSG:4326</SRS></PAMDataset>";
    says(
        &Folder::new("dem.tif", &file.bytes()).with("dem.tif.aux.xml", xml).refusal(),
        &["degrees", "EPSG:4326"],
    );
    let xml = "<PAMDataset><GeoTransform>7, 3, 0, 900, 0, -3</GeoTransform></PAMDataset>";
    let moved = Folder::new("dem.tif", &file.bytes()).with("DEM.TIF.AUX.XML", xml).survey().unwrap();
    assert_eq!((moved.elevation.cell_size_m, moved.georeference.west_m), (3.0, 8.5));
}

/// P-DEM-UNITS. With a vertical system, pixel scale and tie point apply to heights too, as in GDAL.
#[test]
fn a_vertical_system_makes_the_third_numbers_scale_heights() {
    let with = |keys: Vec<(u16, u16)>, scale: f64, tiepoint: [f64; 2]| GeoTiff {
        keys: Some(keys),
        scale: Some(vec![2.0, 2.0, scale]),
        tiepoint: Some(vec![0.0, 0.0, tiepoint[0], 1000.0, 5000.0, tiepoint[1]]),
        ..plain()
    };
    let vertical = vec![(1024, 1), (3072, 32633), (4096, 5703)];
    let first = |file: &GeoTiff| {
        Folder::new("a.tif", &file.bytes())
            .survey()
            .map(|survey| survey.elevation.heights_m[SIDE * (SIDE - 1)])
    };
    assert_eq!(first(&with(vertical.clone(), 2.0, [3.0, 100.0])).unwrap(), 2094.0);
    assert_eq!(first(&with(vertical.clone(), 0.0, [0.0, 0.0])).unwrap(), 1000.0);
    assert_eq!(first(&with(vec![(1024, 1), (3072, 32633)], 2.0, [3.0, 100.0])).unwrap(), 1000.0);
    says(&error(&with(vertical, 0.0, [0.0, 100.0]).bytes()), &["scale of heights", "other than 0"]);
}

/// P-DEM-FILL. What looks like nodata is left out with a warning; `with_nodata` settles it.
#[test]
fn values_that_look_like_nodata_are_left_out_until_it_is_settled() {
    for (fill, nodata) in
        [(-9999.0, None), (-32768.0, Some("-9999")), (0.0, None), (-10000.0, None), (1e5, Some("-9999"))]
    {
        let mut heights = ground();
        heights[40..90].fill(fill);
        let file = GeoTiff { sample: Sample::F64, nodata, ..GeoTiff::new(SIDE, SIDE, heights) };
        let folder = Folder::new("dem.tif", &file.bytes());
        let survey = folder.survey().unwrap();
        assert_eq!(gaps(&survey), 50, "{fill}");
        let [Remark::SuspectedNodata { fill: found, .. }] = &survey.remarks[..] else {
            panic!("{:?}", survey.remarks)
        };
        assert_eq!((found.value, found.cells), (fill, 50));
        let told = survey.remarks[0].to_string();
        says(&told, &[&format!("--nodata {fill}"), "--nodata none", "50 cells"]);
        for (settled, gaps) in [(vec![fill], 50), (vec![], 0)] {
            let survey = self::survey(&folder.raster, Some(settled)).unwrap();
            assert_eq!((self::gaps(&survey), survey.remarks.len()), (gaps, 0), "{fill}");
        }
        let check = TerrainCheck::of_file(&folder.raster, None, 30.0).unwrap();
        assert_eq!(check.nodata_cells, 50);
        assert!((check.elevation_mean_m - 1000.0).abs() < 3.0);
        assert!(
            check
                .treatment
                .iter()
                .any(|told| told.starts_with("warning: ") && told.contains("looks like nodata"))
        );
    }
    // The remedy for one is that for all.
    let mut heights = ground();
    (heights[3], heights[4]) = (-32768.0, -32767.0);
    let file = GeoTiff { sample: Sample::F64, ..GeoTiff::new(SIDE, SIDE, heights) };
    let survey = Folder::new("dem.tif", &file.bytes()).survey().unwrap();
    for remark in &survey.remarks {
        says(&remark.to_string(), &["--nodata -32768,-32767, or with --nodata none"]);
    }
    assert_eq!(survey.remarks.len(), 2);
    // Stored values are tested before scale and offset.
    let mut stored: Vec<f64> = (0..SIDE * SIDE).map(|index| (index % 90) as f64).collect();
    stored[7] = -32767.0;
    let metadata = Some("<GDALMetadata><Item sample=\"0\" role=\"scale\">0.01</Item></GDALMetadata>");
    let file = GeoTiff { sample: Sample::I16, metadata, ..GeoTiff::new(SIDE, SIDE, stored) };
    let survey = Folder::new("dem.tif", &file.bytes()).survey().unwrap();
    assert!(matches!(survey.remarks[..], [Remark::SuspectedNodata { fill, .. }] if fill.value == -32767.0));
}

/// P-DEM-FILL. Declared nodata is recognised though float32 rounded it.
#[test]
fn declared_nodata_is_recognised_after_a_passage_through_float32() {
    let mut heights = ground();
    heights[3] = f64::from(-9999.99f32);
    let file = GeoTiff { sample: Sample::F64, nodata: Some("-9999.99"), ..GeoTiff::new(SIDE, SIDE, heights) };
    let survey = Folder::new("dem.tif", &file.bytes()).survey().unwrap();
    assert_eq!((gaps(&survey), survey.remarks.len()), (1, 0));
    let text = "ncols 3\nnrows 1\nxllcorner 500\nyllcorner 500\ncellsize 1\nNODATA_value -9999.99\n1 -9999.990234375 2\n";
    assert!(values(text.as_bytes()).unwrap()[1].is_nan());
}

fn source(georeference: bool) -> SourceCells {
    let raster = RasterFile::new(std::io::Cursor::new(plain().bytes())).unwrap();
    SourceCells {
        shape: (SIDE as u32, SIDE as u32),
        window: Window::all(SIDE as u32, SIDE as u32),
        ratio: None,
        georeference: georeference.then(|| raster.georeference().unwrap()),
    }
}

/// P-DEM-LAYERS: Layers are masked and lose values that look like nodata; layers that lie elsewhere
/// are refused.
#[test]
fn layers_are_masked_and_lie_where_the_ground_does() {
    let shares: Vec<f64> = (0..SIDE * SIDE).map(|index| if index % 3 == 0 { 1.0 } else { 0.0 }).collect();
    let layer = GeoTiff { sample: Sample::U8, ..GeoTiff::new(SIDE, SIDE, shares.clone()) };
    let mask = Mask {
        counts: vec![false; SIDE * SIDE],
        bits: 1,
        packing: Packing::None,
        rows: SIDE,
        after_overview: false,
    };
    let masked = GeoTiff { mask: Some(mask), ..layer.clone() };
    let read = |file: &GeoTiff| {
        let folder = Folder::new("sand.tif", &file.bytes());
        Sand::read_mask(&folder.raster, &source(true))
            .map(|(mask, notes)| (mask.iter().filter(|sand| **sand).count(), notes.fills.len()))
    };
    let sand = shares.iter().filter(|share| **share == 1.0).count();
    assert_eq!(read(&layer).unwrap(), (sand, 0));
    assert_eq!(read(&masked).unwrap(), (0, 0));
    for (sample, fill) in
        [(Sample::U8, 255.0), (Sample::F32, -9999.0), (Sample::I16, -1.0), (Sample::U16, 65535.0)]
    {
        let mut filled = shares.clone();
        filled[1..3].fill(fill);
        assert_eq!(
            read(&GeoTiff { sample, ..GeoTiff::new(SIDE, SIDE, filled.clone()) }).unwrap(),
            (sand, 1),
            "{fill}"
        );
        let declared = if fill == 255.0 { Some("255") } else { None };
        if declared.is_some() {
            assert_eq!(
                read(&GeoTiff { sample, nodata: declared, ..GeoTiff::new(SIDE, SIDE, filled) }).unwrap(),
                (sand, 0)
            );
        }
    }
    let all = shares.iter().map(|share| 255.0 * share).collect();
    let unclear =
        read(&GeoTiff { sample: Sample::U8, ..GeoTiff::new(SIDE, SIDE, all) }).unwrap_err().to_string();
    says(&unclear, &["sand mask", "255 and 0", "write 1 for sand"]);

    for (what, elsewhere) in [
        (
            "to the east",
            GeoTiff { tiepoint: Some(vec![0.0, 0.0, 0.0, 1002.0, 5000.0, 0.0]), ..layer.clone() },
        ),
        (
            "to the south",
            GeoTiff { tiepoint: Some(vec![0.0, 0.0, 0.0, 1000.0, 4000.0, 0.0]), ..layer.clone() },
        ),
        ("larger", GeoTiff { scale: Some(vec![3.0, 3.0, 0.0]), ..layer.clone() }),
        ("in feet", GeoTiff { keys: Some(vec![(1024, 1), (3076, 9002)]), ..layer.clone() }),
        ("in degrees", GeoTiff { keys: Some(vec![(1024, 2), (2048, 4326)]), ..layer.clone() }),
        ("not square", GeoTiff { scale: Some(vec![2.0, 3.0, 0.0]), ..layer.clone() }),
    ] {
        let folder = Folder::new("layer.tif", &elsewhere.bytes());
        let refused = read_layer(&folder.raster, &source(true)).expect_err(what).to_string();
        says(&refused, &["layer.tif"]);
        assert!(Sand::read_mask(&folder.raster, &source(true)).is_err(), "{what}");
        assert!(read_layer(&folder.raster, &source(false)).is_ok(), "{what}: generated ground lies nowhere");
    }
    for nowhere in [
        GeoTiff { scale: None, tiepoint: None, keys: None, ..layer.clone() },
        GeoTiff { keys: None, ..layer.clone() },
        GeoTiff { tiepoint: Some(vec![0.0, 0.0, 0.0, 1000.0 + 1e-6, 5000.0, 0.0]), ..layer },
    ] {
        assert!(read_layer(&Folder::new("layer.tif", &nowhere.bytes()).raster, &source(true)).is_ok());
    }
}

/// P-DEM-LATTICE: A lattice that is square to 1e-4 and straight to 1e-9 of a cell is accepted.
#[test]
fn a_lattice_is_square_and_straight_but_for_rounding() {
    let with = |scale: [f64; 3]| GeoTiff { scale: Some(scale.to_vec()), ..plain() };
    assert!(values(&with([2.0, 2.000_02, 0.0]).bytes()).is_ok());
    assert_eq!(
        Folder::new("a.tif", &with([2.0, 2.000_1, 0.0]).bytes()).survey().unwrap().elevation.cell_size_m,
        2.0
    );
    says(&error(&with([2.0, 2.001, 0.0]).bytes()), &["square", "gdalwarp -tr"]);
    let turned = |b: f64, e: f64| {
        let matrix = vec![2.0, b, 0.0, 1000.0, e, -2.0, 0.0, 5000.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        GeoTiff { scale: None, tiepoint: None, transformation: Some(matrix), ..plain() }
    };
    let straight = Folder::new("a.tif", &plain().bytes()).survey().unwrap();
    for (b, e) in [(1e-17, 1e-17), (-1e-17, 0.0), (1.9e-9, -1.9e-9)] {
        assert_eq!(Folder::new("a.tif", &turned(b, e).bytes()).survey().unwrap(), straight);
    }
    says(&error(&turned(1e-6, 0.0).bytes()), &["rotated"]);
}

/// P-DEM-RADII: Distances from the centre of a body are refused as radii.
#[test]
fn radii_are_called_radii() {
    for (radius_m, metadata, datum) in [
        (1_737_400.0, None, "A-1737400"),
        (3_396_190.0, None, "A-3396190"),
        (1737.4, Some(metadata_unit("km")), "gdal_edit.py -offset -1737.4 "),
    ] {
        let radii = ground().iter().map(|height| radius_m + (height - 1000.0) * radius_m / 1e6).collect();
        let file = GeoTiff { sample: Sample::F64, metadata, ..GeoTiff::new(SIDE, SIDE, radii) };
        says(&error(&file.bytes()), &["radii", "distances from the centre", datum]);
    }
    // A few of them are what they were: unbelievable heights.
    let mut few = ground();
    few[0..4].fill(1e7);
    assert_eq!(gaps(&Folder::new("a.tif", &GeoTiff::new(SIDE, SIDE, few).bytes()).survey().unwrap()), 4);
}

/// P-DEM-TEXT: Decimal commas, other separators and other encodings in ESRI ASCII grids are named
/// as the cause of the refusal.
#[test]
fn what_is_foreign_in_an_ascii_grid_is_named() {
    let text = String::from_utf8(metres()).unwrap();
    let commas = text.replace('.', ",");
    let semicolons = text.replace(' ', ";").replacen(';', " ", 5);
    let utf16 = |mark: &[u8], bytes: fn(u16) -> [u8; 2]| {
        [mark, &text.encode_utf16().flat_map(bytes).collect::<Vec<_>>()].concat()
    };
    for (grid, words) in [
        (commas.into_bytes(), &["decimal commas", "tr ',' '.'"][..]),
        (
            b"ncols 2\nnrows 1\nxllcorner 500\nyllcorner 500\ncellsize 1,5\n1 2\n".to_vec(),
            &["decimal commas", "1,5"],
        ),
        (
            b"ncols 3\nnrows 1\nxllcorner 500\nyllcorner 500\ncellsize 1\n1.5,2.5,3.5\n".to_vec(),
            &["commas between numbers"],
        ),
        (semicolons.into_bytes(), &["semicolons"]),
        (utf16(&[0xff, 0xfe], u16::to_le_bytes), &["UTF-16", "iconv"]),
        (utf16(&[0xfe, 0xff], u16::to_be_bytes), &["UTF-16"]),
        (utf16(&[], u16::to_le_bytes), &["UTF-16"]),
        (utf16(&[], u16::to_be_bytes), &["UTF-16"]),
    ] {
        says(&error(&grid), words);
    }
    let marked = ["\u{feff}".as_bytes(), text.as_bytes()].concat();
    let survey = Folder::new("dem.asc", &marked).survey().unwrap();
    assert_eq!(survey.remarks, [Remark::ByteOrderMark]);
    says(&survey.remarks[0].to_string(), &["byte order mark (BOM)"]);
    let decimal = text.replace("ncols 20", "ncols 20.0").replace("nrows 20", "nrows 2e1");
    assert!(values(decimal.as_bytes()).is_ok());
    says(&error(text.replace("ncols 20", "ncols 20.5").as_bytes()), &["ncols", "20.5"]);
}

/// A raster of 60 x 60 cells whose northern quarter is ground, and all else `fill`.
fn mostly(fill: f64) -> GeoTiff {
    let height = |index: usize| if index < 900 { 100.0 + 3.0 * (index as f64 / 17.0).sin() } else { fill };
    GeoTiff { sample: Sample::F64, ..GeoTiff::new(60, 60, (0..3600).map(height).collect()) }
}

/// P-DEM-FILL. A part of a file that is nothing but fill is judged by the whole file.
#[test]
fn a_window_of_nothing_but_fill_has_no_heights() {
    let middle = Window { x: 20, y: 20, width: 10, height: 10 };
    for fill in [-9999.0, 0.0, -32768.0] {
        let folder = Folder::new("dem.tif", &mostly(fill).bytes());
        assert_eq!(gaps(&folder.survey().unwrap()), 2700, "{fill}");
        let refused = RasterFile::open(&folder.raster).unwrap().survey(middle).unwrap_err().to_string();
        says(
            &refused,
            &["nodata or NaN in all 100 cells", &format!("{fill} looks like nodata"), "--nodata none"],
        );
        let kept =
            RasterFile::open(&folder.raster).unwrap().with_nodata(Some(vec![])).survey(middle).unwrap();
        assert_eq!((kept.elevation.heights_m[0], kept.remarks), (fill, vec![]));
        // Text is read but once.
        let rows: Vec<String> = mostly(fill)
            .values
            .chunks(60)
            .map(|row| format!("{row:?}").replace(['[', ']', ','], " "))
            .collect();
        let text =
            format!("ncols 60\nnrows 60\nxllcorner 500000\nyllcorner 4e6\ncellsize 2\n{}\n", rows.join("\n"));
        let ascii = Folder::new("dem.asc", text.as_bytes());
        says(
            &RasterFile::open(&ascii.raster).unwrap().survey(middle).unwrap_err().to_string(),
            &["looks like nodata"],
        );
    }
    for values in [vec![-9999.0; 400], vec![-32768.0; 400]] {
        let file = GeoTiff { sample: Sample::I16, ..GeoTiff::new(SIDE, SIDE, values) };
        says(&error(&file.bytes()), &["all 400 cells", "looks like nodata", "there are no others"]);
    }
    let level = GeoTiff::new(SIDE, SIDE, vec![0.0; 400]);
    assert_eq!(Folder::new("dem.tif", &level.bytes()).survey().unwrap().remarks, []);
}

/// P-DEM-LAYERS. A crop of a layer is judged by the whole layer; values that may be sand or nodata
/// are refused.
#[test]
fn a_sand_mask_of_nothing_but_nodata_is_refused_or_no_sand() {
    let part = SourceCells { window: Window { x: 1, y: 1, width: 6, height: 6 }, ..source(true) };
    let layer = |at: &dyn Fn(usize) -> f64, sample| GeoTiff {
        sample,
        ..GeoTiff::new(SIDE, SIDE, (0..SIDE * SIDE).map(|index| at(index % SIDE)).collect())
    };
    for (file, words) in [
        (layer(&|x| if x < 12 { 255.0 } else { 0.0 }, Sample::U8), "255 and 0"),
        (layer(&|_| 255.0, Sample::U8), "nothing but 255;"),
        (layer(&|_| -9999.0, Sample::F32), "nothing but -9999;"),
    ] {
        for source in [&part, &source(true)] {
            let folder = Folder::new("sand.tif", &file.bytes());
            let refused = Sand::read_mask(&folder.raster, source).unwrap_err().to_string();
            says(&refused, &["sand mask", words, "write 1 for sand"]);
        }
    }
    for (fills, sample) in
        [(&[-9999.0][..], Sample::F32), (&[1e20], Sample::F32), (&[254.0, 255.0], Sample::U8)]
    {
        let file = layer(&|x| if x < 12 { fills[x % fills.len()] } else { (x % 2) as f64 }, sample);
        let folder = Folder::new("sand.tif", &file.bytes());
        let (mask, notes) = Sand::read_mask(&folder.raster, &part).unwrap();
        assert_eq!((mask.contains(&true), notes.fills.len()), (false, fills.len()), "{notes:?}");
    }
    let all = layer(&|_| 1.0, Sample::U8);
    let (mask, notes) = Sand::read_mask(&Folder::new("sand.tif", &all.bytes()).raster, &part).unwrap();
    assert!(!mask.contains(&false) && notes.fills.is_empty());
}

/// P-DEM-LAYERS. Equal coordinates in another coordinate system are another place.
#[test]
fn a_layer_in_another_coordinate_system_is_refused_or_warned_of() {
    let shares = vec![1.0; SIDE * SIDE];
    let with = |keys: Vec<(u16, u16)>, citation| GeoTiff {
        sample: Sample::U8,
        keys: Some(keys),
        citation,
        ..GeoTiff::new(SIDE, SIDE, shares.clone())
    };
    let read = |file: &GeoTiff| read_layer(&Folder::new("layer.tif", &file.bytes()).raster, &source(true));
    for code in [32634, 3857] {
        let refused = read(&with(vec![(1024, 1), (3072, code)], None)).unwrap_err().to_string();
        says(&refused, &["layer.tif", "EPSG:32633", &format!("EPSG:{code}"), "gdalwarp -t_srs"]);
    }
    let named = |text| with(vec![(1024, 1), (3072, 32767), (3076, 9001)], Some((1026, text)));
    let model = GeoTiff { citation: Some((1026, "WGS 84 / UTM zone 33N|")), ..plain() };
    let of_model = SourceCells {
        georeference: Some(
            RasterFile::new(std::io::Cursor::new(model.bytes())).unwrap().georeference().unwrap(),
        ),
        ..source(true)
    };
    for (file, is_other) in [(named("Mars_Equirectangular|"), true), (named("WGS_1984_UTM_Zone_33N|"), false)]
    {
        let folder = Folder::new("layer.tif", &file.bytes());
        let notes = read_layer(&folder.raster, &of_model).unwrap().notes;
        assert_eq!(notes.other_system.is_some(), is_other, "{notes:?}");
    }
    // A code and a name cannot be compared.
    let text =
        format!("ncols 20\nnrows 20\nxllcorner 1000\nyllcorner 4960\ncellsize 2\n{}", "1 ".repeat(400));
    let coded = Folder::new("layer.asc", text.as_bytes()).with("layer.prj", "EPSG:32634");
    let by_name = GeoTiff { keys: Some(vec![(1024, 1), (3072, 32767), (3076, 9001)]), ..model.clone() };
    let raster = RasterFile::new(std::io::Cursor::new(by_name.bytes())).unwrap();
    let named_alone = SourceCells { georeference: Some(raster.georeference().unwrap()), ..source(true) };
    assert!(read_layer(&coded.raster, &named_alone).unwrap().notes.other_system.is_some());
    assert!(read_layer(&coded.raster, &source(true)).is_err());
    // A raster without a system has the numbers of the model's own unit.
    let feet = GeoTiff { keys: Some(vec![(1024, 1), (3072, 2263), (4099, 9003)]), ..plain() };
    let raster = RasterFile::new(std::io::Cursor::new(feet.bytes())).unwrap();
    let in_feet = SourceCells { georeference: Some(raster.georeference().unwrap()), ..source(true) };
    let bare = GeoTiff { sample: Sample::U8, keys: None, ..GeoTiff::new(SIDE, SIDE, shares.clone()) };
    assert!(read_layer(&Folder::new("layer.tif", &bare.bytes()).raster, &in_feet).is_ok());
    let moved = GeoTiff { tiepoint: Some(vec![0.0, 0.0, 0.0, 1002.0, 5000.0, 0.0]), ..bare };
    assert!(read_layer(&Folder::new("layer.tif", &moved.bytes()).raster, &in_feet).is_err());
}

/// P-DEM-FILL. A value that no cell holds settles nothing; scaled values are accepted.
#[test]
fn a_value_that_no_cell_holds_settles_nothing() {
    let mut stored: Vec<f64> = (0..SIDE * SIDE).map(|index| (index % 90) as f64).collect();
    stored[7] = -32768.0;
    let metadata = Some("<GDALMetadata><Item sample=\"0\" role=\"scale\">0.1</Item></GDALMetadata>");
    let folder = Folder::new(
        "dem.tif",
        &GeoTiff { sample: Sample::I16, metadata, ..GeoTiff::new(SIDE, SIDE, stored) }.bytes(),
    );
    for settled in [-32768.0, -3276.8] {
        let survey = self::survey(&folder.raster, Some(vec![settled])).unwrap();
        assert_eq!((gaps(&survey), survey.remarks.len()), (1, 0), "{settled}");
    }
    let mistaken = self::survey(&folder.raster, Some(vec![-9999.0])).unwrap();
    assert_eq!(gaps(&mistaken), 1);
    assert!(matches!(mistaken.remarks[..], [Remark::NoCellHolds(-9999.0), Remark::SuspectedNodata { .. }]));
    says(&mistaken.remarks[0].to_string(), &["no cell that was read holds -9999"]);
    // A stored value stands before a scaled one.
    assert_eq!(gaps(&self::survey(&folder.raster, Some(vec![8.0])).unwrap()), 5);
}

/// P-DEM-FILL. Impossible heights are reported, and so are cells that resampling has left between
/// ground and nodata.
#[test]
fn what_is_dropped_is_said() {
    for value in [1e7, -1e7, 1e20, f64::from(f32::MAX), -2_147_483_648.0, 4_294_967_295.0] {
        let mut heights = ground();
        heights[3..6].fill(value);
        let file = GeoTiff { sample: Sample::F64, ..GeoTiff::new(SIDE, SIDE, heights) };
        for settled in [None, Some(vec![])] {
            let survey = survey(&Folder::new("dem.tif", &file.bytes()).keep(), settled).unwrap();
            assert_eq!(gaps(&survey), 3, "{value}");
            let [remark] = &survey.remarks[..] else { panic!("{:?} of {value}", survey.remarks) };
            says(&remark.to_string(), &["3 cells hold"]);
        }
    }
    let all = GeoTiff::new(SIDE, SIDE, vec![1e20; SIDE * SIDE]);
    says(&error(&all.bytes()), &["all 400 cells", "400 cells hold 1e20 m, beyond 1e6 m"]);

    let mut heights = ground();
    for (y, row) in heights.chunks_mut(SIDE).enumerate() {
        row[..4].copy_from_slice(&[-9999.0, -9999.0, -6333.0 + y as f64, -2666.0 + y as f64]);
    }
    let file = |nodata| GeoTiff { sample: Sample::F64, nodata, ..GeoTiff::new(SIDE, SIDE, heights.clone()) };
    for (nodata, settled, remarks) in
        [(None, None, 2), (Some("-9999"), None, 1), (None, Some(vec![-9999.0]), 1)]
    {
        let survey = survey(&Folder::new("dem.tif", &file(nodata).bytes()).keep(), settled).unwrap();
        assert_eq!((gaps(&survey), survey.remarks.len()), (80, remarks), "{nodata:?}");
        assert_eq!(survey.remarks[remarks - 1], Remark::InterpolatedNodata { cells: 40 });
    }
}

/// P-DEM-RADII. The remedy fits scale, offset and unit; a stated body distinguishes radii from
/// heights.
#[test]
fn radii_are_known_by_the_body_and_refused_with_a_remedy_that_helps() {
    let moon = "PROJCS[\"p\",GEOGCS[\"g\",DATUM[\"d\",SPHEROID[\"Moon\",1737400,0]]],UNIT[\"metre\",1]]";
    let ceres = "+proj=eqc +R=470000";
    let grid = |base: f64, factor: f64| {
        let text: Vec<String> =
            ground().iter().map(|height| (base + (height - 1000.0) * factor).to_string()).collect();
        format!("ncols 20\nnrows 20\nxllcorner 500000\nyllcorner 4e6\ncellsize 2\n{}\n", text.join(" "))
    };
    for (prj, base, factor, remedy) in [
        (moon, 1_737_400.0, 1.0, "--calc=A-1737400 "),
        (moon, 1737.4, 0.001, "gdal_edit.py -units km -offset -1737.4 "),
        (ceres, 470_000.0, 1.0, "--calc=A-470000 "),
        (ceres, 420_000.0, 1.0, "radii"),
    ] {
        let folder = Folder::new("dem.asc", grid(base, factor).as_bytes()).with("dem.prj", prj);
        says(&folder.refusal(), &["radii", remedy]);
    }
    // Mountains on the Moon may be 1737 m high.
    for (prj, base, factor) in
        [(moon, 1737.4, 1.0), (moon, 1737.4, 0.0), ("", 1737.4, 0.001), (ceres, 470.0, 0.5)]
    {
        assert!(Folder::new("dem.asc", grid(base, factor).as_bytes()).with("dem.prj", prj).survey().is_ok());
    }
    let survey = Folder::new("dem.asc", grid(252_700.0, 1.0).as_bytes()).survey().unwrap();
    let [remark] = &survey.remarks[..] else { panic!("{:?}", survey.remarks) };
    says(&remark.to_string(), &["no height is below 252", "distances from the centre"]);
    // An offset makes radii of heights: without it they are heights again.
    let metadata = Some(
        "<GDALMetadata><Item sample=\"0\" role=\"scale\">0.5</Item><Item sample=\"0\" role=\"offset\">1737400</Item></GDALMetadata>",
    );
    let few = GeoTiff {
        sample: Sample::I16,
        metadata,
        ..GeoTiff::new(SIDE, SIDE, (0..400).map(|at| (at % 90) as f64).collect())
    };
    says(&error(&few.bytes()), &["radii", "gdal_edit.py -offset 0 "]);
    // Radii in a few cells, beside a fill in all others.
    for fill in [-9999.0, 0.0] {
        let mixed = (0..400).map(|at| if at < 384 { fill } else { 1_737_400.0 + (at % 9) as f64 }).collect();
        let file = GeoTiff { sample: Sample::F64, ..GeoTiff::new(SIDE, SIDE, mixed) };
        says(&error(&file.bytes()), &["radii"]);
    }
}

/// P-DEM-UNITS. If a GeoTIFF has only the name of a vertical system, the unit is taken from the
/// name.
#[test]
fn the_name_of_a_vertical_system_says_its_unit() {
    let first = |citation: &'static str| {
        let keys = Some(vec![(1024, 1), (3072, 32633)]);
        let file = GeoTiff { keys, citation: Some((4097, citation)), ..plain() };
        Folder::new("dem.tif", &file.bytes()).survey()
    };
    for (citation, metres) in [
        ("NAVD88 height (ftUS)|", 1200.0 / 3937.0),
        ("NAVD88 height (ft)|", 0.3048),
        ("NAVD88 height (m)|", 1.0),
        ("NAVD88 height|", 1.0),
    ] {
        let survey = first(citation).unwrap();
        assert!((survey.elevation.heights_m[SIDE * (SIDE - 1)] - 1000.0 * metres).abs() < 1e-9, "{citation}");
        assert_eq!(survey.remarks.is_empty(), metres == 1.0);
    }
    let survey = first("height in feet|").unwrap();
    assert_eq!(survey.remarks, [Remark::MaybeFeet("height in feet".into())]);
    says(&survey.remarks[0].to_string(), &["taken for metres", "gdal_edit.py -units ft"]);
    let keys = Some(vec![(1024, 1), (3072, 32633)]);
    let metadata = Some(metadata_unit("m"));
    let settled = GeoTiff { keys, metadata, citation: Some((4097, "height in feet|")), ..plain() };
    assert_eq!(Folder::new("dem.tif", &settled.bytes()).survey().unwrap().remarks, []);
    says(&first("NAVD88 depth (ft)|").unwrap_err().to_string(), &["depths"]);
}

/// P-DEM-CRS. Statements about one raster in several places are combined, and must not contradict
/// each other.
#[test]
fn several_places_describe_one_coordinate_system_together() {
    let foot = 1200.0 / 3937.0;
    let utm = "EPSG:32633";
    let aux = |text: &str| format!("<PAMDataset><SRS>{text}</SRS></PAMDataset>");
    let height = |folder: &Folder| folder.survey().unwrap().elevation.heights_m[SIDE * (SIDE - 1)];
    let both = Folder::new("dem.asc", &metres())
        .with("dem.asc.aux.xml", aux(utm))
        .with("dem.prj", "EPSG:32633+6360");
    assert!((height(&both) - 1000.0 * foot).abs() < 1e-9);
    let keys = |keys| GeoTiff { keys: Some(keys), ..plain() }.bytes();
    let projected =
        Folder::new("dem.tif", &keys(vec![(1024, 1), (3072, 32633)])).with("dem.prj", "EPSG:32633+6360");
    assert!((height(&projected) - 1000.0 * foot).abs() < 1e-9);
    let of_heights = Folder::new("dem.tif", &keys(vec![(4099, 9002)])).with("dem.prj", "EPSG:2263");
    let survey = of_heights.survey().unwrap();
    assert!((survey.elevation.cell_size_m - 2.0 * foot).abs() < 1e-9);
    assert!((survey.elevation.heights_m[SIDE * (SIDE - 1)] - 304.8).abs() < 1e-9);
    for (keys_of, prj, says_of) in [
        (vec![(1024, 1), (3072, 32633)], "EPSG:2263+6360", "unit of coordinates"),
        (vec![(1024, 1), (3072, 32633), (4099, 9001)], "EPSG:32633+6360", "unit of heights"),
        (vec![(1024, 1), (3072, 32633)], "EPSG:4326", "in one place and"),
    ] {
        says(&Folder::new("dem.tif", &keys(keys_of)).with("dem.prj", prj).refusal(), &[says_of]);
    }
    // A text that is not understood says nothing against keys.
    assert!(Folder::new("dem.tif", &plain().bytes()).with("dem.prj", "hello").survey().is_ok());
}

/// P-DEM-CRS. Degrees with a corner at (0, 0), or across a meridian, are not taken for metres.
#[test]
fn degrees_at_the_origin_and_across_meridians_are_recognised() {
    let with = |side: [usize; 2], corner: [f64; 2], cell: f64| {
        let heights = vec!["7"; side[0] * side[1]].join(" ");
        let [[columns, rows], [west, south]] = [side.map(|side| side as f64), corner];
        let text = format!(
            "ncols {columns}\nnrows {rows}\nxllcorner {west}\nyllcorner {south}\ncellsize {cell}\n{heights}\n"
        );
        Folder::new("dem.asc", text.as_bytes())
    };
    for (side, corner, cell) in [
        ([720, 360], [0.0, 0.0], 0.25),
        ([288, 144], [0.0, 0.0], 0.0625),
        ([100, 100], [0.0, 0.0], 0.1),
        ([180, 90], [0.0, 0.0], 1.0),
        ([180, 90], [0.0, -90.0], 1.0),
        ([60, 30], [0.0, 0.0], 3.0),
        ([200, 100], [-190.0, 10.0], 0.1),
        ([360, 180], [-30.0, -90.0], 1.0),
    ] {
        says(&with(side, corner, cell).refusal(), &["degrees", "LOCAL_CS"]);
        let site = with(side, corner, cell).with("dem.prj", "LOCAL_CS[\"site\",UNIT[\"metre\",1]]");
        assert!(site.survey().unwrap().remarks.is_empty(), "{side:?} {corner:?} {cell}");
    }
    for (side, cell) in [([64, 64], 1.0), ([40, 30], 2.0), ([60, 60], 1.0), ([20, 10], 4.98), ([30, 30], 0.3)]
    {
        let survey = with(side, [0.0, 0.0], cell).survey().unwrap();
        assert_eq!(survey.remarks, [Remark::TakenForLocal], "{side:?} {cell}");
        says(&survey.remarks[0].to_string(), &["taken for metres", "LOCAL_CS"]);
    }
    assert_eq!(with([200, 100], [0.0, 0.0], 1.0).survey().unwrap().remarks, []);
    assert_eq!(with([200, 100], [0.0, 100.0], 2.0).survey().unwrap().remarks, []);
}

/// P-DEM-CONVERT. Files beside a model apply to the GeoTIFF that the model was converted to.
#[test]
fn what_stands_beside_a_converted_file_counts() {
    let foot = 1200.0 / 3937.0;
    let bare = GeoTiff { keys: None, ..plain() };
    let converted = |source: &str, contents: &str| {
        Folder::new(&format!("{source}.converted.tif"), &bare.bytes()).with(source, contents)
    };
    let height = |folder: &Folder| folder.survey().unwrap().elevation.heights_m[SIDE * (SIDE - 1)];
    let prj = converted("dem.bil", "cells").with("dem.prj", "EPSG:2263+6360");
    assert!((height(&prj) - 1000.0 * foot).abs() < 1e-9);
    let mask = GeoTiff::of_counts(SIDE, SIDE, &counts());
    let masked = converted("dem.bil", "cells").with("dem.bil.msk", mask.bytes());
    assert_eq!(gaps(&masked.survey().unwrap()), counts().iter().filter(|counts| !**counts).count());
    let label =
        |unit: &str| format!("PDS_VERSION_ID = PDS3\nOBJECT = IMAGE\n{unit}\nEND_OBJECT = IMAGE\nEND\n");
    let unit = |unit: &str| converted("dem.lbl", &label(unit)).survey();
    assert_eq!(unit("UNIT = METER").unwrap().elevation.heights_m[SIDE * (SIDE - 1)], 1000.0);
    says(&unit("UNIT = KILOMETER").unwrap_err().to_string(), &["radii"]);
    assert!(matches!(unit("UNIT = FOOT").unwrap().remarks[..], [Remark::HeightsConverted(_)]));
    says(&unit("UNIT = KELVIN").unwrap_err().to_string(), &["unit of heights", "KELVIN"]);
    assert_eq!(unit("").unwrap().remarks, []);
}

/// P-DEM-MASK. Sparse files leave out strips and tiles without being cut short.
#[test]
fn a_sparse_file_is_not_cut_short() {
    let side = 20_000_u32;
    let tiles = (side.div_ceil(256) * side.div_ceil(256)) as usize;
    let tile: Vec<f64> = (0..256 * 256).map(|index| 100.0 + (index % 7) as f64).collect();
    let packed = GeoTiff {
        packing: Packing::Deflate,
        tiled: true,
        chunk: (256, 256),
        sample: Sample::F32,
        ..GeoTiff::new(256, 256, tile)
    };
    let bytes = |held: usize| {
        // The directory is written anew: the first tile is held by so many others.
        let offset = 8;
        let length = GeoTiff { tiled: true, ..packed.clone() }.packed_bytes();
        let extra = vec![
            (256, vec![side]),
            (257, vec![side]),
            (324, (0..tiles).map(|tile| if tile < held { offset } else { 0 }).collect()),
            (325, (0..tiles).map(|tile| if tile < held { length } else { 0 }).collect()),
        ];
        GeoTiff { extra, ..packed.clone() }.bytes()
    };
    let mut raster = RasterFile::new(std::io::Cursor::new(bytes(1))).unwrap();
    let north = Window { x: 0, y: side - 256, width: 256, height: 256 };
    assert_eq!(raster.values(north).unwrap()[5], 100.0 + ((255 * 256 + 5) % 7) as f64);
    assert!(raster.values(Window { x: 9000, y: 0, width: 9, height: 9 }).unwrap()[3].is_nan());
    let survey = RasterFile::new(std::io::Cursor::new(bytes(1))).unwrap().survey(north).unwrap();
    assert_eq!(gaps(&survey), 0);
    assert!(matches!(
        RasterFile::new(std::io::Cursor::new(bytes(tiles))),
        Err(TerrainError::Truncated { .. })
    ));
}

/// P-DEM-TEXT. Text that is not a number is named; what the C runtime of Windows writes for NaN has
/// no height.
#[test]
fn numbers_that_other_programs_write_are_read_or_named() {
    let grid = |first: &str, header: &str| {
        let values = ["7"; 8].join(" ");
        format!("ncols 3\nnrows 3\nxllcorner 500000\nyllcorner 4e6\ncellsize 2\n{header}{first} {values}\n")
    };
    for (first, words) in [
        ("1.0D+02", "exponents of Fortran"),
        ("100.00m", "first value"),
        ("\"100\"", "quotes"),
        ("500.000,5", "separators of thousands"),
        ("1,000.5", "separators of thousands"),
        ("100.000,", "commas between numbers"),
    ] {
        says(&error(grid(first, "").as_bytes()), &[words]);
    }
    says(&error(grid("7", "CellSize 3\n").as_bytes()), &["every keyword once", "CellSize"]);
    let two = grid("7", "").replace("cellsize 2", "cellsize 2 2").replace("ncols 3\n", "") + "ncols 3\n";
    says(&error(two.as_bytes()), &["ncols"]);
    let two = "ncols 1\nnrows 1\nxllcorner 9\ncellsize 2 2\nyllcorner 9\n7\n";
    says(&error(two.as_bytes()), &["header of the ASCII grid"]);
    let two = "ncols 2\nnrows 1\nxllcorner 900\nyllcorner 900\ncellsize 2 2\nNODATA_value 9\n7 7\n";
    says(&error(two.as_bytes()), &["one number after the keyword before \"NODATA_value\""]);
    for first in ["1.#QNAN", "-1.#IND", "nan", "-1.#INF"] {
        assert!(values(grid(first, "").as_bytes()).unwrap()[6].is_nan(), "{first}");
        assert_eq!(values(grid("7", &format!("NODATA_value {first}\n")).as_bytes()).unwrap()[6], 7.0);
    }
    let blank = "\n".repeat(40) + &grid("7", "");
    assert!(values(blank.as_bytes()).is_ok());
    let nan = GeoTiff { nodata: Some("-1.#QNAN"), ..plain() };
    assert_eq!(gaps(&Folder::new("dem.tif", &nan.bytes()).survey().unwrap()), 0);
    let listed = GeoTiff {
        metadata: Some("<GDALMetadata><Item name=\"NODATA_VALUES\">1000</Item></GDALMetadata>"),
        ..plain()
    };
    assert_eq!(gaps(&Folder::new("dem.tif", &listed.bytes()).survey().unwrap()), 1);
}

#[test]
fn tie_points_of_one_lattice_and_remedies_for_pictures_and_world_files() {
    let points = |off: f64| {
        let more = [
            [0.0, 0.0, 0.0, 1000.0, 5000.0, 0.0],
            [20.0, 0.0, 0.0, 1040.0 + off, 5000.0, 0.0],
            [0.0, 20.0, 0.0, 1000.0, 4960.0, 0.0],
        ];
        GeoTiff { tiepoint: Some(more.concat()), ..plain() }.bytes()
    };
    assert!(Folder::new("dem.tif", &points(0.0)).survey().is_ok());
    says(&error(&points(1.0)), &["tie points", "off its lattice"]);
    let white = GeoTiff { extra: vec![(262, vec![0])], ..plain() };
    says(&error(&white.bytes()), &["-colorinterp gray", "PHOTOMETRIC=MINISBLACK"]);
    let nowhere = GeoTiff { scale: None, tiepoint: None, ..plain() };
    says(
        &Folder::new("dem.tif", &nowhere.bytes()).with("dem.tfw", "2\n0\n0\n-2\n0\n0\n").refusal(),
        &["world file"],
    );
    says(
        &Folder::new("dem.tif", &plain().bytes()).with("dem.tif.msk", "hello").refusal(),
        &["mask", "a TIFF", "hello"],
    );
    let unit = GeoTiff { keys: Some(vec![(1024, 1), (3072, 32633), (4099, 32767)]), ..plain() };
    says(&error(&unit.bytes()), &["a user-defined one"]);
}
