//! What a session promises: sharing, undo, cameras.

use super::camera::{approach, frame, look_around, orbit, walk};
use super::*;
use glam::Vec3;
use gridlight::settings::{KnobSetting, LookAt};

fn session() -> Session {
    Session::new(RenderSettings { scene: "cornell".into(), ..Default::default() })
}

fn look() -> LookAt {
    LookAt { eye: [1.0, 2.0, 3.0], target: [1.0, 2.0, -1.0], up: [0.0, 1.0, 0.0], vfov: 0.8 }
}

fn near(a: [f32; 3], b: [f32; 3]) {
    // A few roundings of numbers below 10.
    assert!((Vec3::from(a) - Vec3::from(b)).length() < 1e-5, "{a:?} {b:?}");
}

#[test]
fn sides_differ_in_their_stages_and_share_the_world() {
    let mut session = session();
    session.compare_as(Compare::Split);
    session.edited = Side::B;
    session.edit(|b| b.tracer = "bvh_cwbvh".into());
    session.edit(|b| set_knob(b, "tracer", "next_event", Some("off".into())));
    session.edit(|b| set_knob(b, "gather", "mips", Some("off".into())));
    session.edit(|b| b.grid = 64);
    let Asked { a, b: Some(b) } = &session.asked else { unreachable!("it is split") };
    assert_eq!((a.tracer.as_str(), b.tracer.as_str()), ("voxel", "bvh_cwbvh"));
    assert_eq!((a.grid, b.grid), (64, 64));
    let gather = KnobSetting { id: "gather".into(), knob: "mips".into(), value: "off".into() };
    assert_eq!(a.sets, [gather]);
    assert_eq!(b.sets.len(), 2);
    session.edited = Side::A;
    session.edit(|a| set_knob(a, "gather", "mips", None));
    assert_eq!(session.asked.b.as_ref().map(|b| b.sets.len()), Some(1));
}

#[test]
fn undo_goes_back_step_by_step_and_forth_again() {
    let mut session = session();
    for spp in [2, 8] {
        session.edit(|a| a.spp = spp);
        session.history.note(&session.asked);
        session.history.note(&session.asked);
    }
    session.undo();
    assert_eq!(session.asked.a.spp, 2);
    session.undo();
    session.undo();
    assert_eq!(session.asked.a.spp, RenderSettings::default().spp);
    session.redo();
    assert_eq!(session.asked.a.spp, 2);
    session.edit(|a| a.spp = 3);
    session.history.note(&session.asked);
    session.redo();
    assert_eq!(session.asked.a.spp, 3, "what was undone is gone after another edit");
}

#[test]
fn ending_a_comparison_can_be_undone() {
    let mut session = session();
    session.compare_as(Compare::Flicker);
    session.edited = Side::B;
    session.edit(|b| b.spp = 1);
    session.history.note(&session.asked);
    session.compare_as(Compare::Off);
    session.history.note(&session.asked);
    assert_eq!(session.order().sides.len(), 1);
    session.undo();
    assert_eq!((session.compare, session.order().sides[1].spp), (Compare::Split, 1));
}

#[test]
fn walking_keeps_the_view_and_turning_keeps_the_place() {
    near(walk(&look(), Vec3::new(1.0, 2.0, 3.0)).eye, [2.0, 4.0, 0.0]);
    near(walk(&look(), Vec3::new(1.0, 2.0, 3.0)).target, [2.0, 4.0, -4.0]);
    let right = look_around(&look(), std::f32::consts::FRAC_PI_2, 0.0);
    near(right.eye, look().eye);
    near(right.target, [5.0, 2.0, 3.0]);
    let up = look_around(&look(), 0.0, 10.0);
    assert!(Vec3::from(up.target).y > 5.9 && Vec3::from(up.target).z < 3.0, "not over the pole: {up:?}");
}

#[test]
fn orbits_keep_their_target_and_distance() {
    let around = orbit(&look(), 1.0, -0.3);
    near(around.target, look().target);
    let distance = (Vec3::from(around.eye) - Vec3::from(around.target)).length();
    assert!((distance - 4.0).abs() < 1e-5, "{distance}");
    let nearer = approach(&look(), 1.0);
    assert!(nearer.eye[2] < look().eye[2] && nearer.eye[2] > look().target[2]);
}

#[test]
fn a_framed_box_fits() {
    let bounds = scene::Aabb { min: Vec3::ZERO, max: Vec3::splat(2.0) };
    let framed = frame(&look(), bounds);
    near(framed.target, [1.0, 1.0, 1.0]);
    let distance = (Vec3::from(framed.eye) - Vec3::ONE).length();
    // Its sphere touches the frustum: sin(vfov / 2) = radius / distance.
    assert!((distance * 0.4f32.sin() - 3f32.sqrt()).abs() < 1e-4, "{distance}");
}
