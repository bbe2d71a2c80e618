//! See `hostile::campaign::read_checkpoint`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hostile::campaign::read_checkpoint(bytes));
