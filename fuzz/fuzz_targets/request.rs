//! See `hostile::wire::request`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::request(bytes));
