//! GeoTIFF: layouts, sample types, nodata, georeference.

use std::io::Cursor;

use terrain::{ELEVATION_CELLS_MAX, PixelIs, RasterFile, TerrainError, Window};

use crate::tiff_writer::{GeoTiff, Packing, Sample};
use crate::{elevation, error, says, values};

const WIDTH: usize = 23;
const HEIGHT: usize = 17;

/// Heights that every sample type can hold, northernmost row first.
fn heights() -> Vec<f64> {
    (0..WIDTH * HEIGHT).map(|index| ((index * 37) % 211) as f64).collect()
}

fn south_first(values: &[f64]) -> Vec<f64> {
    values.chunks(WIDTH).rev().flatten().copied().collect()
}

/// P-GEOTIFF: Every layout, packing, predictor and sample type of GeoTIFF reads to the same
/// heights; half-cell shifts are kept.
#[test]
fn every_layout_packing_predictor_sample_and_byte_order_reads_the_same_heights() {
    let mut layouts = 0;
    for sample in [Sample::U8, Sample::I16, Sample::U16, Sample::I32, Sample::F32, Sample::F64] {
        for packing in [Packing::None, Packing::Lzw, Packing::Deflate] {
            for predictor in [1, 2, 3] {
                let float = matches!(sample, Sample::F32 | Sample::F64);
                if predictor > 1 && packing == Packing::None || predictor == 3 && !float {
                    continue;
                }
                for (tiled, chunk) in
                    [(false, (0, HEIGHT)), (false, (0, 5)), (false, (0, 1)), (true, (16, 16))]
                {
                    for (big_endian, big_tiff) in [(false, false), (true, false), (false, true), (true, true)]
                    {
                        let file = GeoTiff {
                            sample,
                            packing,
                            predictor,
                            tiled,
                            chunk,
                            big_endian,
                            big_tiff,
                            ..GeoTiff::new(WIDTH, HEIGHT, heights())
                        };
                        let read = values(&file.bytes()).unwrap_or_else(|error| panic!("{error}: {file:?}"));
                        let named = (sample, packing, predictor, tiled, chunk, big_endian, big_tiff);
                        assert_eq!(read, south_first(&heights()), "{named:?}");
                        layouts += 1;
                    }
                }
            }
        }
    }
    assert_eq!(layouts, (4 * 5 + 2 * 7) * 4 * 4);
}

#[test]
fn negative_and_broken_heights_survive_each_packing() {
    let heights: Vec<f64> = (0..64).map(|index| f64::from(index) * -65.25).collect();
    for (sample, predictor) in [(Sample::F32, 3), (Sample::F64, 3), (Sample::F32, 2)] {
        let file =
            GeoTiff { sample, packing: Packing::Deflate, predictor, ..GeoTiff::new(8, 8, heights.clone()) };
        let expected: Vec<f64> = heights.chunks(8).rev().flatten().copied().collect();
        assert_eq!(values(&file.bytes()).unwrap(), expected);
    }
    let whole: Vec<f64> = heights.iter().map(|height| height.trunc()).collect();
    let file =
        GeoTiff { sample: Sample::I16, packing: Packing::Lzw, predictor: 2, ..GeoTiff::new(8, 8, whole) };
    assert_eq!(values(&file.bytes()).unwrap()[56 + 7], -(7.0f64 * 65.25).trunc());
}

#[test]
fn a_window_reads_its_cells_only_from_strips_and_from_tiles() {
    let window = Window { x: 14, y: 2, width: 5, height: 9 };
    for (tiled, chunk) in [(false, (0, 4)), (true, (16, 16))] {
        let file = GeoTiff { tiled, chunk, ..GeoTiff::new(WIDTH, HEIGHT, heights()) };
        let read = RasterFile::new(Cursor::new(file.bytes())).unwrap().values(window).unwrap();
        let all = south_first(&heights());
        let expected: Vec<f64> = (2..11).flat_map(|y| all[y * WIDTH + 14..y * WIDTH + 19].to_vec()).collect();
        assert_eq!(read, expected, "tiled: {tiled}");
    }
}

#[test]
fn declared_nodata_is_compared_in_the_type_of_the_samples() {
    for (sample, nodata, hole) in [
        (Sample::I16, "-32768", -32768.0),
        (Sample::U8, "255", 255.0),
        (Sample::F64, "-9999", -9999.0),
        (Sample::F32, "-3.40282346638529e+38", f64::from(f32::MIN)),
        (Sample::F32, "1.1", 1.1),
        (Sample::F32, "nan", f64::NAN),
    ] {
        let mut heights = heights();
        heights[3] = hole;
        let file = GeoTiff { sample, nodata: Some(nodata), ..GeoTiff::new(WIDTH, HEIGHT, heights) };
        let read = values(&file.bytes()).unwrap();
        let holes: Vec<usize> = (0..read.len()).filter(|&index| read[index].is_nan()).collect();
        assert_eq!(holes, [(HEIGHT - 1) * WIDTH + 3], "{sample:?} {nodata}");
    }
}

#[test]
fn undeclared_infinities_and_absurd_heights_are_nodata() {
    let mut heights = heights();
    (heights[0], heights[1], heights[2]) = (f64::INFINITY, f64::NAN, -3.4e38);
    let read = values(&GeoTiff::new(WIDTH, HEIGHT, heights).bytes()).unwrap();
    assert_eq!(read.iter().filter(|height| height.is_nan()).count(), 3);
}

#[test]
fn scale_and_offset_of_the_gdal_metadata_give_metres() {
    let metadata = "<GDALMetadata>\n<Item name=\"OFFSET\" sample=\"0\" role=\"offset\">100</Item>\n\
                    <Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.5</Item>\n</GDALMetadata>";
    let mut file =
        GeoTiff { metadata: Some(metadata), sample: Sample::I16, ..GeoTiff::new(2, 1, vec![4.0, 6.0]) };
    assert_eq!(values(&file.bytes()).unwrap(), [102.0, 103.0]);
    file.metadata = Some("<Item role=\"scale\">twice</Item>");
    says(&error(&file.bytes()), &["scale or offset", "a finite number", "twice"]);
}

/// P-GEOTIFF.
#[test]
fn pixel_is_area_lies_half_a_cell_inside_of_pixel_is_point() {
    let georeference = |raster_type: u16| {
        let keys = Some(vec![(1024, 1), (1025, raster_type), (3072, 32633)]);
        let file = GeoTiff { keys, ..GeoTiff::new(10, 4, vec![0.0; 40]) };
        RasterFile::new(Cursor::new(file.bytes())).unwrap().georeference().unwrap()
    };
    // The tie point (1000, 5000) is the outer corner of the north-western cell of 2 m ...
    let area = georeference(1);
    assert_eq!((area.pixel_is, area.west_m, area.south_m), (PixelIs::Area, 1001.0, 4999.0 - 6.0));
    // ... or its middle.
    let point = georeference(2);
    assert_eq!((point.pixel_is, point.west_m, point.south_m), (PixelIs::Point, 1000.0, 5000.0 - 6.0));
    assert_eq!(area.coordinate_system, "projected, EPSG:32633");
}

#[test]
fn a_transformation_or_a_tie_point_elsewhere_place_the_raster_alike() {
    let plain = GeoTiff::new(10, 4, vec![0.0; 40]);
    let georeference =
        |file: &GeoTiff| RasterFile::new(Cursor::new(file.bytes())).unwrap().georeference().unwrap();
    let elsewhere = GeoTiff { tiepoint: Some(vec![3.0, 1.0, 0.0, 1006.0, 4998.0, 0.0]), ..plain.clone() };
    assert_eq!(georeference(&plain), georeference(&elsewhere));
    let matrix = [2.0, 0.0, 0.0, 1000.0, 0.0, -2.0, 0.0, 5000.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let transformed =
        GeoTiff { scale: None, tiepoint: None, transformation: Some(matrix.into()), ..plain.clone() };
    assert_eq!(georeference(&plain), georeference(&transformed));
}

#[test]
fn a_rotated_or_flipped_transform_is_refused() {
    let mut matrix =
        vec![2.0, 0.1, 0.0, 1000.0, 0.1, -2.0, 0.0, 5000.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let file = |matrix: &Vec<f64>| GeoTiff {
        transformation: Some(matrix.clone()),
        ..GeoTiff::new(2, 2, vec![0.0; 4])
    };
    says(&error(&file(&matrix).bytes()), &["north-up", "rotated", "gdalwarp"]);
    (matrix[1], matrix[4], matrix[5]) = (0.0, 0.0, 2.0);
    says(&error(&file(&matrix).bytes()), &["north-up", "flipped"]);
}

#[test]
fn degrees_are_refused_with_the_way_to_reproject() {
    let mut file = GeoTiff::new(4, 4, vec![1.0; 16]);
    file.keys = Some(vec![(1024, 2), (2048, 4326)]);
    let earth = "gdalwarp -t_srs '+proj=laea +lat_0=46.9996 +lon_0=11.0004 +ellps=WGS84 +units=m'";
    file.scale = Some(vec![0.000_2, 0.000_2, 0.0]);
    file.tiepoint = Some(vec![0.0, 0.0, 0.0, 11.0, 47.0, 0.0]);
    says(&error(&file.bytes()), &["metres", "degrees", "EPSG:4326", "reproject", earth]);
    // Without keys the numbers tell.
    file.keys = None;
    file.scale = Some(vec![0.000_277, 0.000_277, 0.0]);
    file.tiepoint = Some(vec![0.0, 0.0, 0.0, 137.4, -4.6, 0.0]);
    says(&error(&file.bytes()), &["degrees", "reproject"]);
    // Metres without keys are taken for what they are.
    file.scale = Some(vec![1.0, 1.0, 0.0]);
    file.tiepoint = Some(vec![0.0, 0.0, 0.0, 1137.4, -4.6, 0.0]);
    assert!(elevation(&file.bytes()).is_ok());
}

#[test]
fn cells_that_are_not_square_are_refused() {
    let file = GeoTiff { scale: Some(vec![2.0, 3.0, 0.0]), ..GeoTiff::new(2, 2, vec![0.0; 4]) };
    says(&error(&file.bytes()), &["square", "2 m x 3 m", "gdalwarp -tr"]);
}

#[test]
fn unknown_units_geocentric_and_missing_georeferences_are_refused() {
    let mut file = GeoTiff::new(2, 2, vec![0.0; 4]);
    file.keys = Some(vec![(1024, 1), (3072, 32767), (3076, 9102)]);
    says(&error(&file.bytes()), &["unit of coordinates", "a unit of length", "EPSG:9102"]);
    file.keys = Some(vec![(1024, 1), (3072, 32633), (4099, 9102)]);
    says(&error(&file.bytes()), &["unit of heights", "EPSG:9102"]);
    file.keys = Some(vec![(1024, 3)]);
    says(&error(&file.bytes()), &["geocentric"]);
    file.keys = None;
    file.scale = None;
    says(&error(&file.bytes()), &["ModelPixelScale", "none", "gdal_translate -a_ullr"]);
}

#[test]
fn several_bands_pictures_and_foreign_packings_are_refused_by_name() {
    let with = |tag: u16, value: u32| {
        error(&GeoTiff { extra: vec![(tag, vec![value])], ..GeoTiff::new(2, 2, vec![0.0; 4]) }.bytes())
    };
    says(&with(277, 3), &["bands", "one", "got 3", "gdal_translate -b 1"]);
    says(&with(262, 2), &["photometric", "pictures"]);
    says(&with(259, 50000), &["compression", "50000", "COMPRESS=DEFLATE"]);
    says(&with(258, 12), &["sample type", "12 bits", "Float32"]);
    says(&with(339, 5), &["sample type", "format 5"]);
    says(&with(317, 3), &["predictor"]);
}

#[test]
fn too_many_cells_are_refused_before_memory_is_taken_and_a_window_still_reads() {
    let side = 6000u32;
    // 36 million cells announced in one-row strips that are not there.
    let file =
        GeoTiff { extra: vec![(256, vec![side]), (257, vec![side])], ..GeoTiff::new(2, 2, vec![0.0; 4]) };
    says(&error(&file.bytes()), &["6000 x 6000", "cut short"]);

    let large = GeoTiff {
        packing: Packing::Deflate,
        sample: Sample::U8,
        chunk: (0, 16),
        ..GeoTiff::new(4200, 4200, vec![7.0; 4200 * 4200])
    };
    let bytes = large.bytes();
    let refused = elevation(&bytes).unwrap_err();
    assert!(
        matches!(refused, TerrainError::CellsMax { cells, .. } if cells > ELEVATION_CELLS_MAX),
        "{refused}"
    );
    says(&refused.to_string(), &["16777216", "17640000", "crop"]);
    let window = Window { x: 4000, y: 4100, width: 150, height: 90 };
    let part = RasterFile::new(Cursor::new(bytes)).unwrap().elevation(window).unwrap();
    assert_eq!(part.heights_m, vec![7.0; 150 * 90]);
}

#[test]
fn a_crop_beyond_the_edge_is_refused() {
    let file = GeoTiff::new(4, 3, vec![0.0; 12]).bytes();
    for window in [
        Window { x: 3, y: 0, width: 2, height: 1 },
        Window { x: 0, y: 0, width: 0, height: 1 },
        Window { x: u32::MAX, y: 0, width: 2, height: 1 },
    ] {
        let refused = RasterFile::new(Cursor::new(&file)).unwrap().values(window).unwrap_err();
        says(&refused.to_string(), &["within the file's 4 x 3 cells"]);
    }
}

#[test]
fn a_strip_that_the_file_leaves_out_is_nodata() {
    let mut file = GeoTiff { chunk: (0, 1), ..GeoTiff::new(2, 3, vec![5.0; 6]) };
    file.extra = vec![(279, vec![8, 0, 8])];
    let read = values(&file.bytes()).unwrap();
    assert_eq!(
        read.iter().map(|height| height.is_nan()).collect::<Vec<_>>(),
        [false, false, true, true, false, false]
    );
}

#[test]
fn a_file_of_nothing_but_nan_is_refused() {
    let file = GeoTiff::new(4, 3, vec![f64::NAN; 12]);
    says(&error(&file.bytes()), &["need heights", "all 12 cells"]);
}

#[test]
fn a_file_cut_short_anywhere_is_refused() {
    for packing in [Packing::None, Packing::Lzw, Packing::Deflate] {
        let bytes = GeoTiff { packing, chunk: (0, 3), ..GeoTiff::new(WIDTH, HEIGHT, heights()) }.bytes();
        for length in 0..bytes.len() - 4 {
            let text = error(&bytes[..length]);
            assert!(text.contains("need"), "{length}: {text}");
        }
    }
}

#[test]
fn another_type_of_file_is_refused_with_how_it_begins() {
    says(&error(b"\x89PNG\r\n\x1a\n"), &["GeoTIFF", "ESRI ASCII grid", "PNG"]);
    says(&error(b""), &["end of the file"]);
}
