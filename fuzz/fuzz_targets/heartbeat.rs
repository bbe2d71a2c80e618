//! See `hostile::wire::heartbeat`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::wire::heartbeat(bytes));
