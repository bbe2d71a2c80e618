//! See `hostile::raster::read`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::raster::read(bytes));
