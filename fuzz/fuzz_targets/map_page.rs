//! See `hostile::wire::map_page`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::map_page(bytes));
