//! See `hostile::wire::team`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::team(bytes));
