//! See `hostile::wire::cell`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::cell(bytes));
