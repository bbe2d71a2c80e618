//! See `hostile::wire::detail_page`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::detail_page(bytes));
