//! See `hostile::wire::brief`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::brief(bytes));
