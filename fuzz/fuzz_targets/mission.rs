//! See `hostile::mission::read`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::mission::read(bytes));
