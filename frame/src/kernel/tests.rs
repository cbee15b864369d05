//! A wrong declaration is refused, and the message names what is wrong.
#![allow(clippy::unwrap_used)]

use super::{Bind, reflect};

crate::gpu_struct! {
    /// As the shader below has it.
    pub struct Params {
        /// First.
        pub size: [u32; 2],
        /// Second.
        pub scale: f32,
        /// Padding.
        pub _pad: u32,
    }
}

crate::gpu_struct! {
    /// Fields in the wrong order.
    pub struct Swapped {
        /// Second in WGSL.
        pub scale: f32,
        /// Padding.
        pub _pad: u32,
        /// First in WGSL.
        pub size: [u32; 2],
    }
}

const SOURCE: &str = "
struct Params { size: vec2u, scale: f32 }
@group(0) @binding(0) var<uniform> params: Params;
@group(3) @binding(0) var<storage, read_write> out_words: array<u32>;
@compute @workgroup_size(8, 8)
fn run(@builtin(global_invocation_id) id: vec3u) {
    out_words[id.x] = u32(f32(params.size.x) * params.scale);
}";

fn message(workgroup: [u32; 3], bindings: &[Bind]) -> String {
    match reflect::check("test", SOURCE, &["run"], Some(workgroup), bindings) {
        Ok(()) => "fits".into(),
        Err(e) => e.to_string(),
    }
}

#[test]
fn a_right_declaration_fits() {
    let bindings = [Bind::uniform::<Params>(0, 0, "params"), Bind::storage(3, 0, "out_words")];
    assert_eq!(message([8, 8, 1], &bindings), "fits");
}

#[test]
fn every_mismatch_is_named() {
    let params = Bind::uniform::<Params>(0, 0, "params");
    let out = Bind::storage(3, 0, "out_words");
    let cases: [(&str, [u32; 3], Vec<Bind>); 6] = [
        ("workgroup size", [8, 4, 1], vec![params, out]),
        ("out_words", [8, 8, 1], vec![params, Bind::storage_read(3, 0, "out_words")]),
        ("nothing declared", [8, 8, 1], vec![params]),
        ("nothing used there", [8, 8, 1], vec![params, out, Bind::storage(3, 1, "more")]),
        ("out_bytes", [8, 8, 1], vec![params, Bind::storage(3, 0, "out_bytes")]),
        ("Swapped", [8, 8, 1], vec![Bind::uniform::<Swapped>(0, 0, "params"), out]),
    ];
    for (named, workgroup, bindings) in cases {
        let message = message(workgroup, &bindings);
        assert!(message.contains(named), "{message} should name {named}");
    }
}

#[test]
fn a_moved_field_is_named() {
    let moved = SOURCE.replace("size: vec2u, scale: f32", "scale: f32, size: vec2u");
    let bindings = [Bind::uniform::<Params>(0, 0, "params"), Bind::storage(3, 0, "out_words")];
    let message =
        reflect::check("test", &moved, &["run"], Some([8, 8, 1]), &bindings).unwrap_err().to_string();
    assert!(
        message.contains("Params.size: Rust says size at offset 0, WGSL says scale at offset 0"),
        "{message}"
    );
}

#[test]
fn a_broken_shader_is_quoted() {
    let broken = SOURCE.replace("u32(f32", "u33(f32");
    let message = reflect::check("test", &broken, &["run"], None, &[]).unwrap_err().to_string();
    assert!(message.contains("u33"), "{message}");
}
