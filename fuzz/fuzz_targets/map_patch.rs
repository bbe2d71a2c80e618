//! See `hostile::wire::map_patch`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::map_patch(bytes));
