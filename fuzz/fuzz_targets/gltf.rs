//! `.gltf` files whose buffers and pictures are data URIs.
#![no_main]

mod reading;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if bytes.len() <= reading::LONGEST {
        reading::scene("no/such/folder/fuzz.gltf", bytes);
    }
});
