//! OpenEXR skies; layered files for measuring go through the same decoder.
#![no_main]

mod sky;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| sky::sky("fuzz.exr", bytes));
