//! See `hostile::journal::read`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::journal::read(bytes));
