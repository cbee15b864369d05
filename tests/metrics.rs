//! Do our error metrics say what other people's implementations say?

use crate::support::{Picture, read_exr, reference, shared};
use gridlight::metrics::Errors;
use gridlight::metrics::flip::Exposures;
use serde_json::{Value, json};

/// Fails where a figure is off by more than the other implementation's own arithmetic allows.
fn agrees(name: &str, r: &Picture, t: &Picture, expected: &Value) {
    let found = Errors::between(r, t).unwrap_or_else(|e| panic!("{name}: {e}"));
    let exposures = Exposures::of(r);
    let (bias, stops) = (&expected["bias_ratio_rgb"], &expected["hdr_flip_exposures"]);
    let figures = [
        // Sums in f64 there and here, of f32 pictures.
        ("rmse", Some(found.rmse), &expected["rmse"], 1e-9),
        ("rel_mse", Some(found.rel_mse), &expected["relmse"], 1e-9),
        ("smape", Some(found.smape), &expected["smape"], 1e-9),
        ("red", found.bias[0], &bias[0], 1e-9),
        ("green", found.bias[1], &bias[1], 1e-9),
        ("blue", found.bias[2], &bias[2], 1e-9),
        // Our sRGB curve is f32; their SSIM is f32 throughout.
        ("psnr", found.psnr, &expected["psnr"], 1e-5),
        ("ssim", found.ssim, &expected["ssim"], 1e-5),
        // f32 throughout here and there, and the square root of feature differences: the roundings of flat regions, 1e-7,
        // become 3e-4 in single pixels and, of either sign, 1e-5 in the mean.
        ("flip", Some(found.flip), &expected["ldr_flip"], 5e-5),
        ("hdr_flip", Some(found.hdr_flip), &expected["hdr_flip"], 5e-5),
        // Given with three decimals.
        ("start", Some(f64::from(exposures.start_stops)), &stops[0], 6e-4),
        ("stop", Some(f64::from(exposures.stop_stops)), &stops[1], 6e-4),
    ];
    for (metric, found, expected, most) in figures {
        let expected = expected.as_f64();
        match (found, expected) {
            // Equal pictures: infinite there, none here.
            (None, None) => {}
            (Some(f), Some(e)) if (f - e).abs() <= most * e.abs().max(1.0) => {
                println!("{name}: {metric} {f:.6}, off by {:.1e}", f - e);
            }
            _ => panic!("{name}: {metric} is {found:?}, theirs {expected:?}"),
        }
    }
}

#[test]
fn a_small_pair_agrees_with_others_implementations() {
    // numpy 2.4.6 (sums in f64), scikit-image 0.26.0, flip-evaluator 1.7, by the definitions of `gridlight::metrics`.
    let expected = json!({
        "rmse": 0.05176555609918538, "relmse": 0.08019699204097155, "smape": 0.5986486645844531,
        "psnr": 17.667076015688597, "ssim": 0.6912859082221985,
        "hdr_flip": 0.6673020720481873, "hdr_flip_exposures": [-2.778, 5.303], "ldr_flip": 0.3905511498451233,
        "bias_ratio_rgb": [0.7183612401185657, 0.8212266778284285, 0.8726606850924139],
    });
    let [four, one] = ["cornell_64_b4", "cornell_64_b1"].map(|name| reference(name).0);
    agrees("cornell_64", &four, &one, &expected);
}

#[test]
fn shared_pairs_agree_with_others_implementations() {
    let Some(truth) = shared("truth") else { return };
    let text = std::fs::read_to_string(truth.join("metrics.json")).expect("a readable file");
    // Python writes infinity as a word that is not JSON.
    let table: Value = serde_json::from_str(&text.replace("Infinity", "null")).expect("a table of pairs");
    let pairs = table["pairs"].as_array().expect("a list");
    assert!(!pairs.is_empty());
    for pair in pairs {
        let [reference, test] = ["reference", "test"].map(|side| pair[side].as_str().expect("a file"));
        let [r, t] = [reference, test].map(|name| read_exr(&truth.join(name)));
        agrees(test, &r, &t, pair);
    }
}

#[test]
fn every_shared_exr_is_read() {
    let Some(truth) = shared("truth") else { return };
    let mut count = 0;
    for folder in [truth.clone(), truth.join("noisy")] {
        for entry in folder.read_dir().expect("a folder").flatten() {
            let path = entry.path();
            let name = path.to_string_lossy().into_owned();
            if !name.ends_with(".exr") {
                continue;
            }
            count += 1;
            if name.ends_with(".aov.exr") {
                // Guides and no picture but the albedo, which is the only layer that has colour.
                let layers = gridlight::input::read_exr_layers(&path).expect("layers");
                assert!(layers.channel("depth.T").is_some() && layers.color("albedo").is_some(), "{name}");
            }
            let picture = read_exr(&path);
            assert!(picture.texels().iter().flatten().all(|v| v.is_finite()), "{name}");
        }
    }
    assert!(count > 0, "no .exr in {}", truth.display());
}
