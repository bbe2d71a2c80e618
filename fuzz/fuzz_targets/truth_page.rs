//! See `hostile::wire::truth_page`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::truth_page(bytes));
