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

/// P-DEM-MASK: cells that a mask inside of the file leaves out have no height, whatever its layout.
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

/// P-DEM-MASK: a mask in a file of its own counts for rasters of either format, and needs their shape.
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

/// P-DEM-UNITS: heights in another unit than metres are converted, and it is said.
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

/// P-DEM-UNITS: coordinates in another unit are converted where the unit of heights is stated, and refused where it is not.
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

/// P-DEM-CRS: a `.prj` file of any dialect and spelling says that cells are in degrees; one that is not understood does not hide
/// what the numbers look like.
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

/// P-DEM-CRS: without a coordinate system, cells that lie where longitudes and latitudes may are in degrees, at any size.
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

/// P-DEM-AUX: scale, offset, nodata, unit, place and coordinate system of an `.aux.xml` file count.
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

/// P-DEM-UNITS: with a vertical system, pixel scale and tie point scale heights too, as GDAL reads them.
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

/// P-DEM-FILL: what looks like nodata is taken for it and said; `with_nodata` settles it.
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
        let [Remark::SuspectedNodata(found)] = survey.remarks[..] else { panic!("{:?}", survey.remarks) };
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
    // Stored values are tested before scale and offset.
    let mut stored: Vec<f64> = (0..SIDE * SIDE).map(|index| (index % 90) as f64).collect();
    stored[7] = -32767.0;
    let metadata = Some("<GDALMetadata><Item sample=\"0\" role=\"scale\">0.01</Item></GDALMetadata>");
    let file = GeoTiff { sample: Sample::I16, metadata, ..GeoTiff::new(SIDE, SIDE, stored) };
    let survey = Folder::new("dem.tif", &file.bytes()).survey().unwrap();
    assert!(matches!(survey.remarks[..], [Remark::SuspectedNodata(fill)] if fill.value == -32767.0));
}

/// P-DEM-FILL: declared nodata is recognised though float32 rounded it.
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

/// P-DEM-LAYERS: layers are masked, lose what looks like nodata, and are refused where they lie elsewhere.
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
            .map(|(mask, fills)| (mask.iter().filter(|sand| **sand).count(), fills.len()))
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

/// P-DEM-LATTICE: what differs by rounding alone is square and straight.
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

/// P-DEM-RADII: distances from the centre of a body are called by their name.
#[test]
fn radii_are_called_radii() {
    for (radius_m, metadata, datum) in [
        (1_737_400.0, None, "A-1737400"),
        (3_396_190.0, None, "A-3396190"),
        (1737.4, Some(metadata_unit("km")), "A-1737400"),
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

/// P-DEM-TEXT: numbers and encodings of other programs are named as the cause.
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
