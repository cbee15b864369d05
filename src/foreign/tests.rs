//! Names of layers, what is divided out, and that it comes back.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Bench, Light, Picture, View, view};
use crate::input::Layers;
use denoise::{Guides, Need};
use frame::{FrameInfo, Gpu};
use std::path::Path;

const GUIDES: Guides = Guides {
    surface: Need::Required,
    distance: Need::Required,
    face_normal: Need::Required,
    motion_id: Need::Required,
};

fn picture(layers: &Layers, sequence: bool) -> Result<Picture, String> {
    Picture::of(Path::new("in.exr"), layers, "any", GUIDES, sequence).map_err(|e| e.to_string())
}

#[test]
fn layers_are_found_by_the_names_that_renderers_give() {
    let [one, two] = [[1.0f32], [2.0f32]];
    let color: [(&str, &[f32]); 3] = [("R", &one), ("G", &one), ("B", &one)];
    let ours: [(&str, &[f32]); 7] = [
        ("albedo.R", &two),
        ("albedo.G", &two),
        ("albedo.B", &two),
        ("normal.X", &one),
        ("normal.Y", &two),
        ("normal.Z", &one),
        ("depth.Z", &two),
    ];
    let blender: [(&str, &[f32]); 7] = [
        ("View Layer.Denoising Albedo.R", &two),
        ("View Layer.Denoising Albedo.G", &two),
        ("View Layer.Denoising Albedo.B", &two),
        ("View Layer.Denoising Normal.X", &one),
        ("View Layer.Denoising Normal.Y", &two),
        ("View Layer.Denoising Normal.Z", &one),
        ("View Layer.Denoising Depth.Z", &two),
    ];
    let arnold: [(&str, &[f32]); 7] = [
        ("diffuse_color.R", &two),
        ("diffuse_color.G", &two),
        ("diffuse_color.B", &two),
        ("N.X", &one),
        ("N.Y", &two),
        ("N.Z", &one),
        ("Z", &two),
    ];
    for guides in [ours, blender, arnold] {
        let all = [&color[..], &guides[..]].concat();
        let found = picture(&Layers::of([1, 1], &all), false).unwrap();
        assert_eq!(found.albedo.unwrap().texels(), [[2.0; 3]], "{guides:?}");
        assert_eq!(found.normal.unwrap().texels(), [[1.0, 2.0, 1.0]], "{guides:?}");
        assert_eq!(found.depth.unwrap().texels(), [2.0], "{guides:?}");
        // What is missing is named, with what was looked for and what there is.
        let without = Layers::of([1, 1], &[&color[..], &guides[..3], &guides[6..]].concat());
        let message = picture(&without, false).unwrap_err();
        assert!(
            ["needs normals", "shadingnormal", guides[0].0].iter().all(|part| message.contains(part)),
            "{message}"
        );
        let without = Layers::of([1, 1], &[&color[..], &guides[..6]].concat());
        assert!(picture(&without, false).unwrap_err().contains("needs depth"));
        assert!(picture(&Layers::of([1, 1], &all), true).unwrap_err().contains("needs motion"));
    }
    assert!(
        picture(&Layers::of([1, 1], &ours), false).is_ok_and(|p| p.color.texels() == [[2.0; 3]]),
        "the only colour"
    );
    let nameless: [(&str, &[f32]); 2] = [("depth.Z", &one), ("normal.X", &one)];
    assert!(picture(&Layers::of([1, 1], &nameless), false).unwrap_err().contains("needs the picture"));
}

#[test]
fn the_brightest_pixel_sets_the_scale() {
    let light = |brightest: f32| {
        let [bright, albedo] = [[brightest, 1.0], [0.5f32; 2]];
        let channels: [(&str, &[f32]); 8] = [
            ("R", &bright),
            ("G", &bright),
            ("B", &bright),
            ("albedo.R", &albedo),
            ("albedo.G", &albedo),
            ("albedo.B", &albedo),
            ("depth.Z", &albedo),
            ("N.X", &albedo),
        ];
        let plain = Guides::default();
        let layers = Layers::of([2, 1], &channels);
        Light::of(&Picture::of(Path::new("in.exr"), &layers, "any", plain, false).unwrap()).scale()
    };
    // Twice as bright once divided by the albedo; never scaled up, and not below ten bits of the mean.
    assert_eq!([light(1.0), light(16384.0), light(65536.0), light(1e30)], [1.0, 1.0, 0.25, 2f32.powi(-60)]);
}

#[test]
fn what_is_divided_out_comes_back() {
    let gpu = Gpu::new(None).expect("tests need an adapter, a software one will do");
    let size = [4, 3];
    let values = |scale: f32| (0..12).map(|i| scale * (1 + i) as f32).collect::<Vec<f32>>();
    let (red, albedo, emission) = (values(1.0), values(0.05), values(0.25));
    let depth: Vec<f32> = (0..12).map(|i| if i == 5 { 0.0 } else { 2.0 }).collect();
    let channels: [(&str, &[f32]); 13] = [
        ("R", &red),
        ("G", &red),
        ("B", &red),
        ("albedo.R", &albedo),
        ("albedo.G", &albedo),
        ("albedo.B", &albedo),
        ("emission.R", &emission),
        ("emission.G", &emission),
        ("emission.B", &emission),
        ("depth.Z", &depth),
        ("N.X", &depth),
        ("N.Y", &depth),
        ("N.Z", &depth),
    ];
    let picture = picture(&Layers::of(size, &channels), false).unwrap();
    let frame = FrameInfo::still(view::camera(1.0), size);
    let (light, view) = (Light::of(&picture), View::of(picture.depth.as_ref(), Default::default(), &frame));
    let denoiser = crate::pipeline::denoiser(&gpu, "identity").unwrap();
    let mut bench = Bench::new(gpu, denoiser, size, false).unwrap();
    bench.upload(&picture, &view, &light);
    let filtered = bench.run(&frame).unwrap();
    let [found, _] = bench.picture(&filtered, &picture, &view, &light).unwrap();
    for (i, (found, wanted)) in found.texels().iter().zip(&red).enumerate() {
        // Half floats: 2^-11 of what was divided; what was not hit is the same to the bit.
        let tolerance = if i == 5 { 0.0 } else { wanted * 2f32.powi(-11) };
        assert!(found.iter().all(|v| (v - wanted).abs() <= tolerance), "{i}: {found:?}, not {wanted}");
    }
    assert_eq!(picture.albedo_at(0, 0), [0.05; 3]);
}
