//! See `hostile::scenario::read`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::scenario::read(bytes));
