//! Radiance `.hdr` skies.
#![no_main]

mod sky;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| sky::sky("fuzz.hdr", bytes));
