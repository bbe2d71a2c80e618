//! See `hostile::wire::route`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::route(bytes));
