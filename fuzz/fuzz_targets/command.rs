//! See `hostile::wire::command`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::command(bytes));
