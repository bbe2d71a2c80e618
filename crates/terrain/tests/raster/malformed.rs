//! Damaged files: an error or heights, never a panic, and never more memory than the limits allow.

use proptest::prelude::*;

use crate::tiff_writer::{GeoTiff, Packing, Sample};
use crate::{elevation, meter, values};

/// A few hundred bytes cannot hold more than 4096 times as many, with eight bytes to a sample of one.
const MEMORY_PER_BYTE_MAX: usize = 8 * 4096;

fn geotiff() -> impl Strategy<Value = GeoTiff> {
    (0..6usize, 0..3usize, 1..=3u16, any::<[bool; 3]>()).prop_map(|(sample, packing, predictor, flags)| {
        let sample = [Sample::U8, Sample::I16, Sample::U16, Sample::I32, Sample::F32, Sample::F64][sample];
        let packing = [Packing::None, Packing::Lzw, Packing::Deflate][packing];
        let float = matches!(sample, Sample::F32 | Sample::F64);
        let predictor = if packing == Packing::None || predictor == 3 && !float { 1 } else { predictor };
        let [tiled, big_endian, big_tiff] = flags;
        GeoTiff {
            sample,
            packing,
            predictor,
            tiled,
            big_endian,
            big_tiff,
            chunk: if tiled { (16, 16) } else { (0, 7) },
            nodata: Some("-9999"),
            ..GeoTiff::new(20, 18, (0..360).map(f64::from).collect())
        }
    })
}

/// Both ways of reading; what they return is not the point.
fn read(bytes: &[u8]) {
    let (_, largest) = meter::largest_allocation(|| (values(bytes).is_ok(), elevation(bytes).is_ok()));
    let bound = MEMORY_PER_BYTE_MAX * bytes.len().max(1) + 65_536;
    assert!(largest <= bound, "{largest} bytes at once for a file of {} bytes", bytes.len());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, ..ProptestConfig::default() })]

    /// P-DAMAGED-DEM: A damaged elevation model is read or refused, without a panic or a large
    /// allocation.
    #[test]
    fn a_geotiff_with_flipped_bits_is_read_or_refused(
        file in geotiff(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0..8u8), 1..6),
    ) {
        let mut bytes = file.bytes();
        for (at, bit) in flips {
            let at = at.index(bytes.len());
            bytes[at] ^= 1 << bit;
        }
        read(&bytes);
    }

    /// The directory lies at the end of the file: most of the damage that matters is there.
    #[test]
    fn a_geotiff_with_foreign_bytes_in_its_directory_is_read_or_refused(
        file in geotiff(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = file.bytes();
        let tail = bytes.len().min(600);
        for (at, byte) in changes {
            let at = bytes.len() - 1 - at.index(tail);
            bytes[at] = byte;
        }
        read(&bytes);
    }

    /// P-DAMAGED-DEM.
    #[test]
    fn a_geotiff_cut_short_is_read_or_refused(file in geotiff(), at in any::<prop::sample::Index>()) {
        let bytes = file.bytes();
        read(&bytes[..at.index(bytes.len())]);
    }

    #[test]
    fn an_ascii_grid_with_foreign_bytes_is_read_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        length in any::<prop::sample::Index>(),
    ) {
        let mut bytes = b"ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -1\n\
                          1 2 3 4\n5 6 7 8\n9 10 11 12\n".to_vec();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        read(&bytes);
        read(&bytes[..length.index(bytes.len())]);
    }

    #[test]
    fn noise_is_refused(noise in prop::collection::vec(any::<u8>(), 0..400), kind in 0..4usize) {
        let mut bytes: Vec<u8> = [b"II*\0".to_vec(), b"MM\0*".to_vec(), b"II+\0\x08\0\0\0".to_vec(), b"ncols ".to_vec()][kind].clone();
        bytes.extend(noise);
        prop_assert!(elevation(&bytes).is_err());
    }
}

fn refusal(file: &GeoTiff) -> String {
    let bytes = file.bytes();
    let (error, largest) = meter::largest_allocation(|| elevation(&bytes).unwrap_err().to_string());
    assert!(largest <= 1 << 20, "{largest} bytes at once for {error}");
    error
}

/// P-DEM-LIMITS: Elevation models that declare or unpack to more than the limit are refused, and
/// the error names the limit.
#[test]
fn a_geotiff_beyond_a_limit_is_refused_by_the_limits_name() {
    let plain = GeoTiff::new(5, 4, (0..20).map(f64::from).collect());
    let with = |extra: &[(u16, &[u32])]| GeoTiff {
        extra: extra.iter().map(|(tag, values)| (*tag, values.to_vec())).collect(),
        ..plain.clone()
    };
    // 4096 tiles of 16 million cells in a row: 33 kilobytes that would unpack to 256 gigabytes.
    let (offsets, lengths) = (vec![8; 4096], vec![10; 4096]);
    let tall: [(u16, &[u32]); 7] = [
        (256, &[4096]),
        (257, &[1]),
        (259, &[8]),
        (322, &[1]),
        (323, &[1 << 24]),
        (324, &offsets),
        (325, &lengths),
    ];
    for (file, says) in [
        (
            with(&[(256, &[1 << 30]), (257, &[1 << 30])]),
            "cells in a strip or tile: need at most 16777216, got 4294967296; rewrite",
        ),
        (with(&[(256, &[4097]), (257, &[4096]), (278, &[1])]), "got the end of the file"),
        (with(&[(256, &[u32::MAX])]), "image width: need 1 to 2147483647"),
        (with(&[(322, &[1 << 16]), (323, &[1 << 16])]), "cells in a strip or tile: need at most 16777216"),
        (
            with(&tall),
            "cells in the strips or tiles to be unpacked: need at most 1073741824, got 68719476736; rewrite",
        ),
        (with(&[(279, &[1 << 20])]), "length of a strip or tile"),
        (with(&[(273, &[8; 7])]), "offsets of strips or tiles: need 1, got 7"),
        (with(&[(278, &[0])]), "strip or tile: need cells"),
    ] {
        let text = refusal(&file);
        assert!(text.contains(says), "{says:?} in {text}");
    }
}

/// The GeoTIFFs that fuzzing begins from; `HOPPER_BLESS=1 cargo test -p hopper-terrain corpus` writes them anew.
#[test]
fn the_corpus_of_geotiffs_is_what_the_writer_makes() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/geotiff");
    let plain = GeoTiff::new(5, 4, (0..20).map(f64::from).collect());
    let packed = |packing, predictor| GeoTiff { packing, predictor, chunk: (5, 2), ..plain.clone() };
    for (name, file) in [
        ("plain", GeoTiff { nodata: Some("3"), ..plain.clone() }),
        ("lzw", packed(Packing::Lzw, 2)),
        ("deflate", packed(Packing::Deflate, 3)),
        (
            "tiled",
            GeoTiff { tiled: true, chunk: (16, 16), sample: Sample::I16, ..packed(Packing::Deflate, 2) },
        ),
        ("big", GeoTiff { big_tiff: true, big_endian: true, sample: Sample::F64, ..plain.clone() }),
    ] {
        let path = folder.join(name);
        if std::env::var_os("HOPPER_BLESS").is_some() {
            std::fs::write(&path, file.bytes()).unwrap();
        }
        assert!(std::fs::read(&path).unwrap() == file.bytes(), "{} is out of date", path.display());
    }
}
