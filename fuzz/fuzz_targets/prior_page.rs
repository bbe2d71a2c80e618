//! See `hostile::wire::prior_page`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::prior_page(bytes));
