//! See `hostile::wire::policy`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::policy(bytes));
