//! See `hostile::wire::state`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::state(bytes));
