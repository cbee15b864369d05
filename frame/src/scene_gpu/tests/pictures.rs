//! Averages keep their means, arrays hold what they should.

use super::*;
use crate::scene_gpu::texels::Plane;
use crate::scene_gpu::textures::Plan;
use glam::{DVec4, Vec4};

fn mean(plane: &Plane) -> DVec4 {
    plane.texels.iter().map(|t| t.as_dvec4()).sum::<DVec4>() / plane.texels.len() as f64
}

#[test]
fn codes_come_back_as_they_were() {
    let codes: Vec<_> = (0..=255u8).map(|c| [c, 255 - c, c / 2, c]).collect();
    for encoding in [Encoding::Srgb, Encoding::Linear] {
        let plane = Plane::decode([16, 16], &codes, encoding, None);
        assert_eq!(plane.encode(encoding), codes, "{encoding:?}");
    }
}

#[test]
fn every_mip_has_the_mean_of_the_whole_whatever_the_sides() {
    for (width, height) in [(64, 64), (37, 19), (1, 5), (300, 2)] {
        let image = random_image("noise", width, height);
        let mut plane = Plane::decode([width as usize, height as usize], &image.rgba, Encoding::Srgb, None);
        let whole = mean(&plane);
        let mut mips = 0;
        while plane.size != [1, 1] {
            plane = plane.mip();
            mips += 1;
            // f32 sums of numbers below 1, a few roundings per mip: 6e-8 each.
            assert!(mean(&plane).abs_diff_eq(whole, 2e-6), "{width} x {height}, {:?}", plane.size);
        }
        assert_eq!(mips, width.max(height).ilog2());
    }
}

#[test]
fn averages_are_of_light_and_not_of_codes() {
    let plane = Plane::decode([2, 1], &[[0, 0, 0, 255], [255, 255, 255, 255]], Encoding::Srgb, None);
    // Half the light is code 188 of the sRGB curve; the mean of the codes would be 128.
    assert_eq!(plane.mip().encode(Encoding::Srgb), [[188, 188, 188, 255]]);
}

#[test]
fn alpha_of_a_mask_becomes_the_share_it_leaves() {
    let rgba = [[0, 0, 0, 99], [0, 0, 0, 100], [0, 0, 0, 255], [0, 0, 0, 101]];
    let plane = Plane::decode([2, 2], &rgba, Encoding::Srgb, Some(100));
    assert_eq!(plane.mip().texels, [Vec4::new(0.0, 0.0, 0.0, 0.75)]);
}

fn uses(count: u32, encoding: Encoding) -> Vec<Use> {
    (0..count).map(|image| Use { image, encoding, threshold: None }).collect()
}

#[test]
fn a_full_class_spills_into_the_next_larger_one() {
    let uses = uses(5, Encoding::Linear);
    let plan = Plan::new(&uses, vec![[100, 100]; 5], u64::MAX, 2).unwrap();
    assert_eq!(plan.layers, [0, 0, 0, 0, 0, 2, 2, 1, 0, 0]);
    let mut places: Vec<_> = plan.places.iter().map(|p| (p.array, p.layer)).collect();
    places.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), 5, "two pictures in one place");
    assert!(plan.places.iter().all(|p| p.size == [100, 100]));
}

#[test]
fn more_pictures_than_layers_are_refused_with_both_numbers() {
    let uses = uses(11, Encoding::Srgb);
    let message = Plan::new(&uses, vec![[8, 8]; 11], u64::MAX, 2).err().unwrap().to_string();
    assert!(message.contains("11") && message.contains("10"), "{message}");
}

#[test]
fn a_budget_halves_the_largest_and_says_so() {
    let uses = uses(3, Encoding::Srgb);
    // 2048^2 with mips is 22.4 MB, 1024^2 5.6 MB, 512^2 1.4 MB.
    let plan = Plan::new(&uses, vec![[2048, 1000], [900, 900], [300, 300]], 10_000_000, 256).unwrap();
    assert_eq!(plan.layers[..5], [0, 0, 3, 0, 0]);
    assert_eq!(plan.places.iter().map(|p| p.size).collect::<Vec<_>>(), [[512, 250], [450, 450], [300, 300]]);
    assert_eq!(plan.warnings.len(), 1);
    assert!(plan.warnings[0].contains("29 MB") && plan.warnings[0].contains("10 MB"), "{}", plan.warnings[0]);
    let roomy = Plan::new(&uses, vec![[2048, 1000], [900, 900], [300, 300]], 30_000_000, 256).unwrap();
    assert!(roomy.warnings.is_empty() && roomy.places[0].size == [2048, 1000]);
}

#[test]
fn pictures_beyond_the_largest_class_are_averaged_down() {
    let plan = Plan::new(&uses(1, Encoding::Srgb), vec![[5000, 300]], u64::MAX, 256).unwrap();
    assert_eq!(plan.places[0].size, [1250, 75]);
    assert!(plan.warnings[0].contains("5000"), "{}", plan.warnings[0]);
}
