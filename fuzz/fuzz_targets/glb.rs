//! `.glb` files: as they are, and, so that mutations need not keep lengths in step, as a JSON text and the bytes after
//! its first zero, wrapped here.
#![no_main]

mod reading;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if bytes.len() > reading::LONGEST {
        return;
    }
    match bytes.starts_with(b"glTF") {
        true => reading::scene("no/such/folder/fuzz.glb", bytes),
        false => reading::scene("no/such/folder/fuzz.glb", &wrapped(bytes)),
    }
});

/// Header, JSON chunk, binary chunk.
fn wrapped(bytes: &[u8]) -> Vec<u8> {
    let mut parts = bytes.splitn(2, |byte| *byte == 0);
    let (json, binary) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut glb = b"glTF".to_vec();
    for word in [2, length, json.len()] {
        glb.extend((word as u32).to_le_bytes());
    }
    glb.extend(b"JSON");
    glb.extend(json);
    glb.extend((binary.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(binary);
    glb
}
