//! See `hostile::crew::read`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::crew::read(bytes));
