//! See `hostile::wire::past_page`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::past_page(bytes));
