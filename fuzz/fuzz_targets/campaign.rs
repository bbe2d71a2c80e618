//! See `hostile::campaign::read`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::campaign::read(bytes));
