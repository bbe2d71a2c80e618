//! See `hostile::wire::table_page`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::table_page(bytes));
