//! See `hostile::wire::control`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::control(bytes));
