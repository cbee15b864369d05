//! The shared scenes: all real ones load with the triangles their list promises, no malformed or cut one does harm.
#![allow(clippy::unwrap_used, clippy::panic)]

use scene::{LoadBudget, Scene, SceneError};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/scenes");

/// The folder, or nothing with a printed reason.
fn scenes() -> Option<&'static Path> {
    let folder = Path::new(SCENES);
    if !folder.is_dir() {
        println!("skipped: {SCENES} is missing");
        return None;
    }
    Some(folder)
}

fn load(path: &Path) -> Result<Scene, SceneError> {
    Scene::load(path.to_str().unwrap())
}

/// Path and triangle count of each row of the list.
fn listed(folder: &Path) -> Vec<(PathBuf, usize)> {
    let list = std::fs::read_to_string(folder.join("README.md")).unwrap();
    let rows = list.lines().filter_map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let file = cells.get(3).filter(|f| f.ends_with(".gltf") || f.ends_with(".glb"))?;
        let triangles = cells.get(8)?.replace(' ', "").parse().ok()?;
        Some((folder.join(cells[1]).join(file), triangles))
    });
    rows.collect()
}

#[test]
fn every_scene_loads_with_its_triangles_and_unit_frames() {
    let Some(folder) = scenes() else { return };
    let rows = listed(folder);
    assert_eq!(rows.len(), 43);
    for (path, triangles) in rows {
        let start = Instant::now();
        let scene = load(&path).unwrap_or_else(|fault| panic!("{fault}"));
        println!("{:7.1} ms {}: {:?}", start.elapsed().as_secs_f64() * 1e3, scene.name, scene.warnings);
        let g = scene.rest();
        assert_eq!(g.triangles.len(), triangles, "{}", path.display());
        let n = g.positions.len();
        assert_eq!([g.normals.len(), g.tangents.len(), g.uv0.len()], [n; 3], "{}", path.display());
        assert!([0, n].contains(&g.uv1.len()) && [0, n].contains(&g.colors.len()));
        assert!(g.positions.iter().all(|p| p.is_finite()), "{}", path.display());
        for (normal, tangent) in g.normals.iter().zip(&g.tangents) {
            let direction = tangent.truncate();
            // 1e-4: a few f32 roundings in the products and the square root.
            assert!((normal.length() - 1.0).abs() < 1e-4, "{}: normal {normal}", path.display());
            assert!((direction.length() - 1.0).abs() < 1e-4, "{}: tangent {tangent}", path.display());
            assert!(normal.dot(direction).abs() < 1e-3, "{}: {normal} and {tangent}", path.display());
            assert!(tangent.w.abs() == 1.0);
        }
        let objects = &g.objects;
        assert!(objects.windows(2).all(|o| o[0].moving <= o[1].moving), "static ones first");
        for (i, triangle) in g.triangles.iter().enumerate() {
            let object = &objects[triangle.object as usize];
            assert!(object.triangles.contains(&(i as u32)));
            assert!(triangle.vertices.iter().all(|v| object.vertices.contains(v)));
            assert!((triangle.material as usize) < scene.materials.len());
        }
        for slot in scene.materials.iter().flat_map(|m| m.textures()).filter_map(|(slot, _)| slot) {
            let image = &scene.images[slot.image as usize];
            assert_eq!(image.rgba.len(), image.width as usize * image.height as usize);
        }
        let bounds = scene.bounds();
        assert!(g.bounds().min.cmpge(bounds.min).all() && g.bounds().max.cmple(bounds.max).all());
    }
}

/// The share of triangles whose plane looks the same way as the mean of their normals.
fn share_facing_their_normals(scene: &Scene) -> f32 {
    let g = scene.rest();
    let agree = g.triangles.iter().filter(|t| {
        let [a, b, c] = g.corners(t);
        let normal = t.vertices.iter().map(|&v| g.normals[v as usize]).sum::<glam::Vec3>();
        (b - a).cross(c - a).dot(normal) >= 0.0
    });
    agree.count() as f32 / g.triangles.len() as f32
}

#[test]
fn negative_scale_keeps_fronts_in_front() {
    let Some(folder) = scenes() else { return };
    let scene = load(&folder.join("negative_scale_test/NegativeScaleTest.gltf")).unwrap();
    // A swapped winding in one of its mirrored parts would cost a third or more.
    assert!(share_facing_their_normals(&scene) > 0.99, "{}", share_facing_their_normals(&scene));
}

#[test]
fn animated_scenes_move_stay_finite_and_stay_inside_their_bounds() {
    let Some(folder) = scenes() else { return };
    for name in [
        "rigged_figure_skinned/RiggedFigure.gltf",
        "fox_skinned/Fox.gltf",
        "morph_stress_test/MorphStressTest.gltf",
        "box_animated/BoxAnimated.gltf",
        "interpolation_test/InterpolationTest.gltf",
        "blender_parent_inverse_animated/06_parent-inverse-anim.gltf",
    ] {
        let scene = load(&folder.join(name)).unwrap();
        let rest = scene.rest();
        assert!(scene.duration() > 0.0 && scene.needs().motion, "{name}");
        let (mut before, mut now) = (rest.clone(), rest.clone());
        scene.pose(0.0, &mut before);
        assert_eq!(before, *rest, "{name}: time 0 is the rest");
        let mut moved = 0;
        for step in 1..=7 {
            scene.pose(scene.duration() * step as f32 / 7.0, &mut now);
            let still = rest.static_vertex_count() as usize;
            assert_eq!(now.positions[..still], rest.positions[..still], "{name}");
            assert!(now.positions.iter().all(|p| p.is_finite()), "{name}");
            assert!(now.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-4), "{name}");
            moved += usize::from(now.positions != before.positions);
            // Keys and halves are exact; a turning part may bulge between them by a little.
            let (bounds, slack) = (scene.bounds(), 0.05 * scene.bounds().diagonal());
            let outside =
                now.positions.iter().filter(|p| p.clamp(bounds.min - slack, bounds.max + slack) != **p);
            assert_eq!(outside.count(), 0, "{name} at step {step}");
            std::mem::swap(&mut before, &mut now);
        }
        assert!(moved >= 3, "{name}: {moved} of 7 steps move");
        scene.pose(0.0, &mut before);
        assert_eq!(before, *rest, "{name}: back at time 0");
    }
}

/// The most memory that this process ever held, MiB, where the system says.
fn peak_mib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kib| kib / 1024)
}

/// A refusal is one line that begins with the file it is about.
#[track_caller]
fn is_clear(fault: &SceneError, path: &Path) {
    let message = fault.to_string();
    let rest = message.strip_prefix(&format!("{}: ", path.display()));
    assert!(rest.is_some_and(|rest| rest.len() > 8) && message.lines().count() == 1, "{message}");
}

#[test]
fn no_malformed_file_does_harm() {
    let Some(folder) = scenes().map(|f| f.join("malformed")) else { return };
    let expected = std::fs::read_to_string(folder.join("expected.tsv")).unwrap();
    let (mut read, mut refused) = (0, 0);
    for line in expected.lines().skip(1) {
        let cells: Vec<&str> = line.split('\t').collect();
        let path = folder.join(cells[0]);
        let start = Instant::now();
        let outcome = load(&path);
        // A liveness guard, not a budget: the largest of them draws 8 million triangles in about a second.
        assert!(start.elapsed() < Duration::from_secs(60), "{}: {:?}", cells[0], start.elapsed());
        match outcome {
            Ok(mut scene) => {
                read += 1;
                let mut geometry = scene.rest().clone();
                for time in [0.5, -1.0, f32::NAN, 1e30] {
                    scene.pose(time, &mut geometry);
                    assert!(geometry.positions.iter().all(|p| p.is_finite()), "{} at {time} s", cells[0]);
                }
                scene.set_moving(1.0);
                scene.pose(0.5, &mut geometry);
                assert!(scene.rest().normals.iter().all(|n| n.is_normalized()), "{}", cells[0]);
                assert!(!scene.materials.is_empty());
            }
            Err(fault) => {
                refused += 1;
                is_clear(&fault, &path);
            }
        }
    }
    println!("{read} read, {refused} refused, {:?} MiB at most", peak_mib());
    assert_eq!(read + refused, 572);
    assert!(read > 300 && refused > 50, "{read} read, {refused} refused");
    assert!(peak_mib().is_none_or(|mib| mib < 2048), "{:?} MiB", peak_mib());
}

/// A folder of one test, gone when dropped.
struct Scratch(PathBuf);

impl Scratch {
    /// Holds what `from` holds.
    fn like(from: &Path, name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("gridlight-cut-{}-{name}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        let scratch = Self(folder);
        scratch.copy(from, Path::new(""));
        scratch
    }

    fn copy(&self, from: &Path, below: &Path) {
        std::fs::create_dir_all(self.0.join(below)).unwrap();
        for entry in from.join(below).read_dir().unwrap().flatten() {
            let place = below.join(entry.file_name());
            if entry.path().is_dir() {
                self.copy(from, &place);
            } else {
                std::fs::copy(entry.path(), self.0.join(place)).unwrap();
            }
        }
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Bytes of a block of a file system.
const BLOCK: usize = 4096;

#[test]
fn a_scene_cut_short_at_any_block_is_refused_with_the_place() {
    let Some(folder) = scenes() else { return };
    let (mut cuts, mut files) = (0, 0);
    for (path, _) in listed(folder) {
        let whole = std::fs::read(&path).unwrap();
        files += 1;
        // Each block of what is small; of megabytes, 256 places evenly: what is read first is read each time.
        let step = BLOCK.max(whole.len() / 256);
        for length in (0..whole.len()).step_by(step) {
            let cut = whole.get(..length).unwrap();
            let fault = Scene::of_bytes(&path, cut, LoadBudget::default()).unwrap_err();
            is_clear(&fault, &path);
            let message = fault.to_string();
            let says_where = ["JSON", "GLB"].iter().any(|place| message.contains(place));
            assert!(says_where, "cut at byte {length}: {message}");
            cuts += 1;
        }
    }
    println!("{cuts} cuts of {files} files");
    assert!(files == 43 && cuts > 500, "{cuts} cuts of {files} files");
}

#[test]
fn buffers_and_pictures_cut_short_are_refused_or_read_as_far_as_they_go() {
    let Some(folder) = scenes() else { return };
    let (mut refused, mut read) = (0, 0);
    // Small ones with buffers, PNG and JPEG beside the scene.
    for (name, file) in [
        ("box_animated", "BoxAnimated.gltf"),
        ("water_bottle", "WaterBottle.gltf"),
        ("fox_skinned", "Fox.gltf"),
    ] {
        let scratch = Scratch::like(&folder.join(name), name);
        let mut beside: Vec<PathBuf> =
            scratch.0.read_dir().unwrap().flatten().map(|e| e.path()).filter(|p| p.is_file()).collect();
        let of_scene = |p: &PathBuf| {
            p.extension().is_some_and(|e| ["bin", "png", "jpg"].iter().any(|wanted| e == *wanted))
        };
        beside.retain(of_scene);
        beside.sort();
        assert!(!beside.is_empty(), "{name}");
        for part in beside {
            let whole = std::fs::read(&part).unwrap();
            for length in
                [0, 1, 7, BLOCK, whole.len() / 2, whole.len().saturating_sub(BLOCK), whole.len() - 1]
            {
                std::fs::write(&part, whole.get(..length).unwrap_or(&whole)).unwrap();
                match load(&scratch.0.join(file)) {
                    Ok(_) => read += 1,
                    Err(fault) => {
                        refused += 1;
                        is_clear(&fault, &scratch.0.join(file));
                        let message = fault.to_string();
                        let says_where = ["buffers[", "images["].iter().any(|place| message.contains(place));
                        assert!(says_where, "{} cut at byte {length}: {message}", part.display());
                    }
                }
            }
            std::fs::write(&part, &whole).unwrap();
        }
        assert!(load(&scratch.0.join(file)).is_ok(), "{name} is whole again");
    }
    println!("{refused} refused, {read} read");
    assert!(refused > 20, "{refused} refused, {read} read");
}
