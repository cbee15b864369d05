//! GPU against CPU, and what the gradients are for: it lags less than [`crate::svgf`].
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Asvgf, reference};
use crate::Denoiser;
use crate::edge::{self, EdgeParams};
use crate::fixture::{Shot, gpu, noise};
use crate::svgf::Svgf;
use frame::{Gpu, set_knob};

#[test]
fn the_gpu_does_what_the_twin_does() {
    let (gpu, size) = (gpu(), [45, 33]);
    let mut denoiser = Asvgf::new(&gpu).unwrap();
    // Random normals and depths hardly ever agree: these let most of them count as one surface.
    let wide = [("sigma_n", "1"), ("sigma_z", "100"), ("history_plane", "1"), ("history_normal", "-1")];
    for (name, value) in wide.into_iter().chain([("lag_sigma", "0.5")]) {
        set_knob(&mut denoiser.knobs(), name, value).unwrap();
    }
    denoiser.resize(&gpu, size, true).unwrap();
    let mut first = Shot::random(size, 20);
    first.break_pixels(6);
    let mut second = first.sequel(1);
    second.frame.jitter = [-0.1, 0.4];
    second.frame.previous_jitter = first.frame.jitter;
    second.noisy = Shot::random(size, 120).noisy;
    // Half as bright, so that there is something to see beside the noise.
    second.noisy.diffuse = second.noisy.diffuse.map(|light| light.map(|v| 0.25 * v));
    first.next(&gpu, &mut denoiser);
    let log = second.next(&gpu, &mut denoiser).1;
    let found = crate::fixture::read::<[f32; 2]>(&gpu, &log, "denoise/asvgf/haste");

    let edges = |shot: &Shot| {
        let others = shot.others.map(|[face_normal, _, object]| [face_normal, object]);
        let params = EdgeParams::new(denoiser.settings.roughness_min, true, true);
        let frame = shot.frame.uniform();
        edge::reference::pack(&params, &frame, &shot.surface, &shot.distance, &others, &shot.noisy)
    };
    let (before, now) = (edges(&first), edges(&second));
    let (frame, motion) = (second.frame.uniform(), second.others.map(|[_, motion, _]| motion));
    let params = denoiser.settings.temporal.params(&second.frame);
    let mut hasty = 0;
    for lobe in 0..2 {
        let luminances = [
            reference::luminances(&now, &second.noisy, lobe),
            reference::luminances(&before, &first.noisy, lobe),
        ];
        let strata =
            reference::gradient(&params, &frame, [&now, &before], &motion, [&luminances[0], &luminances[1]]);
        let twin = reference::haste(&denoiser.haste_params(&denoiser.settings), &frame, &now, &strata);
        let pairs = found.iter().map(|h| h[lobe]).zip(twin.texels());
        // A pixel exactly between two, or as far off as is allowed, may count on one side only: it is one of 225.
        let far = pairs.filter(|(gpu, cpu)| (gpu - **cpu).abs() > 1e-3).count();
        assert!(far < 60, "lobe {lobe}: {far} shares");
        hasty += twin.texels().iter().filter(|share| **share > 0.1).count();
    }
    assert!(hasty > 500, "only {hasty} shares to compare at all");
}

/// Mean of the picture over frames that go from light to a quarter of it at frame 16.
fn switched(gpu: &Gpu, denoiser: &mut dyn Denoiser) -> Vec<f64> {
    let size = [48, 40];
    denoiser.resize(gpu, size, true).unwrap();
    let still = Shot::wall(size, 1.0);
    (0..20)
        .map(|index| {
            let mut shot = still.sequel(index);
            let dim = if index < 16 { 1.0 } else { 0.25 };
            shot.noisy.diffuse = noise(size, index).map(|light| light.map(|v| dim * v));
            let clean = shot.next(gpu, denoiser).0;
            clean.diffuse.iter().map(|t| t[0].to_f64()).sum::<f64>() / clean.diffuse.len() as f64
        })
        .collect()
}

#[test]
fn a_light_that_is_switched_is_followed_sooner_than_by_svgf() {
    let gpu = gpu();
    let slow = switched(&gpu, &mut Svgf::new(&gpu).unwrap());
    let quick = switched(&gpu, &mut Asvgf::new(&gpu).unwrap());
    // One frame's share of 0.2 leaves 80 % of the step in svgf; change by three quarters is three fifths of the brighter
    // less three standard errors (noise of 58 % over 225 pixels: 4 %).
    println!("svgf {:?}, asvgf {:?}", &slow[16..], &quick[16..]);
    assert!(slow[16] - 0.25 > 0.7 * 0.75, "svgf holds {}", slow[16]);
    assert!(quick[16] - 0.25 < 0.5 * (slow[16] - 0.25), "{} against {}", quick[16], slow[16]);
    assert!(quick[18] - 0.25 < 0.5 * (slow[18] - 0.25), "{} against {}", quick[18], slow[18]);
    // And nothing is forgotten for noise alone.
    assert!((quick[15] - 1.0).abs() < 0.02);
}
