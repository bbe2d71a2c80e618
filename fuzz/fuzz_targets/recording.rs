//! See `hostile::recording::read`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::recording::read(bytes));
