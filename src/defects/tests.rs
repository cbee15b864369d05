//! Figures with a known answer.
#![allow(clippy::unwrap_used)]

use super::rays::*;
use super::run;
use crate::pipeline::Pipeline;
use crate::settings::View;
use crate::{Progress, RenderSettings};
use frame::Gpu;

fn pair(triangle: Option<f32>, voxel: Option<f32>) -> Pair {
    Pair { triangle, voxel, cosine: 1.0 }
}

#[test]
fn silhouettes_count_rays_that_meet_something_else() {
    let pairs = [
        pair(Some(10.0), Some(11.5)),
        pair(None, None),
        pair(Some(10.0), None),
        pair(None, Some(3.0)),
        pair(Some(10.0), Some(7.5)),
    ];
    assert_eq!(silhouette_error(&pairs), 3.0 / 5.0);
}

#[test]
fn distance_is_judged_along_the_normal() {
    let grazing = Pair { cosine: 0.1, ..pair(Some(50.0), Some(65.0)) };
    assert_eq!((silhouette_error(&[grazing]), missed_per_million(&[grazing])), (0.0, 0.0));
    let straight = Pair { cosine: 0.2, ..grazing };
    assert_eq!((silhouette_error(&[straight]), missed_per_million(&[straight])), (1.0, 1e6));
}

#[test]
fn a_voxel_is_missed_only_behind_its_triangle() {
    let pairs = [
        pair(Some(10.0), Some(9.0)),
        // Met too early: a silhouette, but no hole.
        pair(Some(10.0), Some(2.0)),
        pair(Some(10.0), Some(12.5)),
        pair(Some(10.0), None),
        pair(None, None),
    ];
    assert_eq!(missed_per_million(&pairs), 500_000.0);
    assert_eq!(missed_per_million(&[]), 0.0);
}

#[test]
fn flicker_is_what_voxels_change_beyond_triangles() {
    let before = [pair(Some(10.0), Some(9.0)); 5];
    let after = [
        pair(Some(10.5), Some(9.5)),
        pair(Some(10.5), Some(10.5)),
        // A jump counts as two voxels.
        pair(Some(10.0), None),
        // A silhouette of the triangles themselves.
        pair(Some(40.0), Some(9.0)),
        pair(None, Some(9.0)),
    ];
    assert_eq!(flicker_voxels(&before, &after), (0.0 + 1.0 + 2.0) / 3.0);
}

/// A room whose walls fill whole layers of cells: rays agree everywhere but within a voxel of the surface, nothing is
/// missed, and light is the same in every direction.
#[test]
fn a_closed_room_of_planes_has_no_defects() {
    let settings = RenderSettings {
        scene: "furnace".into(),
        view: View::Camera(0),
        trace_size: [48; 2],
        display_size: [48; 2],
        grid: 64,
        bounces: None,
        ..Default::default()
    };
    let gpu = Gpu::new(None).expect("this test needs an adapter; a software one will do");
    let mut pipeline = Pipeline::new(gpu, &settings, Progress::default()).unwrap();
    let defects = run(&mut pipeline).unwrap();
    println!("{defects:?}");
    assert_eq!((defects.grid, pipeline.settings()), (64, &settings));
    assert_eq!((defects.silhouette_error, defects.missed_per_million), (0.0, 0.0));
    // Seen face on, a voxel's face changes its distance by the slope of the wall only.
    assert!(defects.flicker_voxels < 0.1, "{defects:?}");
    // Two paths in each of 2,304 pixels that add up 1/2 per scattering: their mean is off by about 0.01.
    assert!(defects.brightness.iter().all(|b| (b - 1.0).abs() < 0.05), "{defects:?}");
    // Walls of two voxels and more are tight but for one path in some hundred thousand, that goes on into a voxel of a
    // layer and out at its back. A wall of one is a single layer: 1e-3 was measured.
    assert!(defects.leaked[1] < 1e-4 && defects.leaked[2] < 1e-4, "{defects:?}");
    assert!(defects.leaked[0] < 0.01, "{defects:?}");
}
