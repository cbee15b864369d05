//! Is the mask blue? And how it is made.

use super::super::{MASK, MASK_SIDE};
use super::*;
use std::f64::consts::TAU;

const PLACES: usize = MASK_SIDE * MASK_SIDE;

fn ranks(channel: usize) -> Vec<f64> {
    let rank = |at: usize| u16::from_le_bytes([MASK[4 * at + 2 * channel], MASK[4 * at + 2 * channel + 1]]);
    (0..PLACES).map(|at| f64::from(rank(at)) / 65536.0).collect()
}

#[test]
fn the_masks_are_even_and_blue() {
    for channel in 0..2 {
        let mut ranks = ranks(channel);
        // Power at the lowest frequencies, where white noise has its variance, 1/12 per place.
        let mut low = 0.0;
        for (x, y) in [(1, 0), (0, 1), (1, 1), (2, 1), (3, 2), (5, 0)] {
            let (mut re, mut im) = (0.0, 0.0);
            for (at, value) in ranks.iter().enumerate() {
                let turn = (x * (at % MASK_SIDE) + y * (at / MASK_SIDE)) as f64 / MASK_SIDE as f64;
                re += value * (TAU * turn).cos();
                im += value * (TAU * turn).sin();
            }
            low += (re * re + im * im) / PLACES as f64 * 12.0 / 6.0;
        }
        println!("mask {channel}: {low:.4} of white noise's power at the lowest frequencies");
        // Void and cluster leaves a few thousandths; white noise would give 1 +- 0.4.
        assert!(low < 0.05, "{low}");
        ranks.sort_by(f64::total_cmp);
        let is_even = ranks.iter().enumerate().all(|(i, r)| *r == i as f64 / PLACES as f64);
        assert!(is_even, "every rank once");
    }
}

/// How much a minority place weighs upon each place: a Gaussian of 1.5 texels on the torus.
fn add(energy: &mut [f64], at: usize, sign: f64) {
    for (other, energy) in energy.iter_mut().enumerate() {
        let apart = |a: usize, b: usize| a.abs_diff(b).min(MASK_SIDE - a.abs_diff(b)) as f64;
        let x = apart(at % MASK_SIDE, other % MASK_SIDE);
        let y = apart(at / MASK_SIDE, other / MASK_SIDE);
        *energy += sign * (-(x * x + y * y) / (2.0 * 1.5 * 1.5)).exp();
    }
}

/// Places in the order they are filled: the largest void next, after a start without clusters.
fn void_and_cluster(seed: u32) -> Vec<u16> {
    let mut taken = vec![false; PLACES];
    let mut energy = vec![0.0; PLACES];
    let best = |energy: &[f64], taken: &[bool], wanted: bool| {
        let of = |at: &usize| if wanted { energy[*at] } else { -energy[*at] };
        (0..PLACES).filter(|at| taken[*at] == wanted).max_by(|a, b| of(a).total_cmp(&of(b))).unwrap()
    };
    let start = PLACES / 10;
    let mut count = 0;
    for i in 0.. {
        let at = pcg4d([i, seed, 0, 0])[0] as usize % PLACES;
        if !taken[at] {
            taken[at] = true;
            add(&mut energy, at, 1.0);
            count += 1;
        }
        if count == start {
            break;
        }
    }
    for _ in 0..PLACES {
        let cluster = best(&energy, &taken, true);
        taken[cluster] = false;
        add(&mut energy, cluster, -1.0);
        let void = best(&energy, &taken, false);
        taken[void] = true;
        add(&mut energy, void, 1.0);
        if void == cluster {
            break;
        }
    }
    let mut rank = vec![0; PLACES];
    let (mut rest, mut rest_energy) = (taken.clone(), energy.clone());
    for number in (0..start).rev() {
        let cluster = best(&rest_energy, &rest, true);
        rest[cluster] = false;
        add(&mut rest_energy, cluster, -1.0);
        rank[cluster] = number as u16;
    }
    for number in start..PLACES {
        let void = best(&energy, &taken, false);
        taken[void] = true;
        add(&mut energy, void, 1.0);
        rank[void] = number as u16;
    }
    rank
}

#[test]
#[ignore = "writes the masks that the program carries"]
fn make_masks() {
    let masks = [1, 2].map(void_and_cluster);
    let step = 65536 / PLACES as u32;
    let bytes: Vec<u8> = (0..PLACES)
        .flat_map(|at| {
            masks
                .iter()
                .flat_map(move |m| ((u32::from(m[at]) * step) as u16).to_le_bytes())
                .collect::<Vec<_>>()
        })
        .collect();
    std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/src/noise/mask.bin"), bytes).unwrap();
}
