//! What every built-in scene keeps, and what each one promises.

#![allow(clippy::unwrap_used, clippy::panic)]

use super::{all, by_name, furnace};
use crate::{Alpha, Geometry, Image, Scene, Sky, Triangle};
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::path::Path;

fn each(check: impl Fn(&str, &Scene)) {
    for (name, _, build) in all() {
        check(name, &build());
    }
}

fn named(name: &str) -> Scene {
    by_name(name).unwrap()()
}

/// Twice the area times the unit normal that the winding gives.
fn wound(geometry: &Geometry, triangle: &Triangle) -> Vec3 {
    let [a, b, c] = geometry.corners(triangle);
    (b - a).cross(c - a)
}

fn object<'a>(scene: &'a Scene, name: &str) -> impl Iterator<Item = &'a Triangle> {
    let range = scene.rest().objects.iter().find(|o| o.name == name).unwrap().triangles.clone();
    scene.rest().triangles[range.start as usize..range.end as usize].iter()
}

/// How often each edge of these triangles is walked one way less the other way, by rounded position.
fn open_edges<'a>(geometry: &Geometry, triangles: impl Iterator<Item = &'a Triangle>) -> usize {
    let mut walks: HashMap<[[i32; 3]; 2], i32> = HashMap::new();
    for triangle in triangles {
        // A hundredth of a millimetre: far above f32 rounding of some metres, far below any edge.
        let corners = geometry.corners(triangle).map(|p| (p * 1e5).round().as_ivec3().to_array());
        for [from, to] in [[0, 1], [1, 2], [2, 0]].map(|edge| edge.map(|i| corners[i])) {
            *walks.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
        }
    }
    walks.values().filter(|sum| **sum != 0).count()
}

#[test]
fn names_are_unique_and_resolve_to_scenes_of_that_name() {
    for (i, (name, line, build)) in all().iter().enumerate() {
        assert_eq!(build().name, *name);
        assert_eq!(Scene::load(name).unwrap().name, *name);
        assert!(!line.is_empty() && all()[..i].iter().all(|(other, ..)| other != name));
    }
    assert!(by_name("no such scene").is_none());
}

#[test]
fn all_lists_agree_in_length_and_all_indices_are_in_range() {
    each(|name, scene| {
        let g = scene.rest();
        let vertices = g.positions.len();
        for (list, length) in
            [("normals", g.normals.len()), ("tangents", g.tangents.len()), ("uv0", g.uv0.len())]
        {
            assert_eq!(length, vertices, "{name}: {list}");
        }
        assert!(g.uv1.is_empty() && g.colors.is_empty());
        let (mut next_vertex, mut next_triangle) = (0, 0);
        for (number, object) in g.objects.iter().enumerate() {
            assert!(!object.name.is_empty() && !object.moving && !object.triangles.is_empty());
            assert_eq!((object.vertices.start, object.triangles.start), (next_vertex, next_triangle));
            (next_vertex, next_triangle) = (object.vertices.end, object.triangles.end);
            for triangle in &g.triangles[object.triangles.start as usize..object.triangles.end as usize] {
                assert_eq!(triangle.object as usize, number, "{name}");
                assert!((triangle.material as usize) < scene.materials.len(), "{name}");
                assert!(triangle.vertices.iter().all(|v| object.vertices.contains(v)), "{name}");
            }
        }
        assert_eq!((next_vertex as usize, next_triangle as usize), (vertices, g.triangles.len()), "{name}");
    });
}

#[test]
fn materials_have_distinct_names_and_slots_that_exist() {
    each(|name, scene| {
        for (i, material) in scene.materials.iter().enumerate() {
            assert!(!material.name.is_empty(), "{name}: material {i}");
            assert!(
                scene.materials[..i].iter().all(|other| other.name != material.name),
                "{name}: {}",
                material.name
            );
            assert_eq!(material.alpha, Alpha::Opaque);
            assert!(
                scene.rest().triangles.iter().any(|t| t.material as usize == i),
                "{name}: unused material"
            );
            let height = material.height.map(|h| h.texture);
            for slot in material.textures().into_iter().filter_map(|(slot, _)| slot).chain(height) {
                assert!(
                    (slot.image as usize) < scene.images.len() && slot.uv_set == 0,
                    "{name}: {}",
                    material.name
                );
            }
        }
        for Image { width, height, rgba, .. } in &scene.images {
            assert_eq!(rgba.len(), (width * height) as usize);
        }
    });
}

#[test]
fn frames_are_unit_perpendicular_and_finite() {
    each(|name, scene| {
        let g = scene.rest();
        for (i, ((p, n), t)) in g.positions.iter().zip(&g.normals).zip(&g.tangents).enumerate() {
            assert!(p.is_finite() && g.uv0[i].is_finite(), "{name}: vertex {i}");
            // Normalised in f32: a few ulp of 1.
            assert!(
                (n.length() - 1.0).abs() < 1e-6 && (t.truncate().length() - 1.0).abs() < 1e-6,
                "{name}: vertex {i}"
            );
            assert!(n.dot(t.truncate()).abs() < 1e-5, "{name}: vertex {i}: normal {n}, tangent {t}");
            assert_eq!(t.w.abs(), 1.0);
        }
    });
}

#[test]
fn winding_agrees_with_normals() {
    each(|name, scene| {
        let g = scene.rest();
        for (i, triangle) in g.triangles.iter().enumerate() {
            let face = wound(g, triangle);
            assert!(face.length() > 1e-7, "{name}: triangle {i} has no area");
            for v in triangle.vertices {
                // The coarsest ball turns by 7.5 degrees a cell; at its poles a face and a corner differ by less
                // than twice that: cos 15 degrees = 0.97. Cloth folds are the sharpest: 0.5 leaves room.
                let cos = face.normalize().dot(g.normals[v as usize]);
                assert!(
                    cos > 0.5,
                    "{name}: triangle {i} of {:?}: {cos}",
                    g.objects[triangle.object as usize].name
                );
            }
        }
    });
}

#[test]
fn tangents_point_along_growing_u_and_bitangents_against_growing_v() {
    each(|name, scene| {
        let g = scene.rest();
        for (i, triangle) in g.triangles.iter().enumerate() {
            let [a, b, c] = g.corners(triangle);
            let [ua, ub, uc] = triangle.vertices.map(|v| g.uv0[v as usize]);
            let (du, dv): (Vec2, Vec2) = (ub - ua, uc - ua);
            let area = du.perp_dot(dv);
            assert!(area.abs() > 1e-9, "{name}: triangle {i} has no area in its picture");
            let along_u = ((b - a) * dv.y - (c - a) * du.y) / area;
            let along_v = ((c - a) * du.x - (b - a) * dv.x) / area;
            for v in triangle.vertices {
                let (n, t) = (g.normals[v as usize], g.tangents[v as usize]);
                // A tangent of one corner against the whole triangle: cells turn by 15 degrees at most, but at
                // the poles of balls a picture is squeezed, so only the side counts.
                assert!(t.truncate().dot(along_u) > 0.0, "{name}: triangle {i}, u");
                assert!((n.cross(t.truncate()) * t.w).dot(along_v) < 0.0, "{name}: triangle {i}, v");
            }
        }
    });
}

#[test]
fn the_same_bits_every_time() {
    for (name, _, build) in all() {
        let (a, b) = (build(), build());
        assert_eq!(a.rest(), b.rest(), "{name}");
        assert_eq!(
            (a.materials, a.images, a.cameras, a.sky, a.sun),
            (b.materials, b.images, b.cameras, b.sky, b.sun)
        );
    }
}

#[test]
fn cameras_look_at_the_scene() {
    each(|name, scene| {
        assert!(!scene.cameras.is_empty(), "{name}");
        let bounds = scene.bounds();
        for camera in &scene.cameras {
            let (eye, forward) = (camera.eye, camera.forward());
            assert!(forward.cross(camera.up).length() > 0.5 && (0.3..2.0).contains(&camera.vfov), "{name}");
            // The nearest point of the view ray to the middle of the scene lies inside its bounds.
            let nearest = eye + forward * (bounds.center() - eye).dot(forward).max(0.0);
            assert!(
                nearest.cmpge(bounds.min).all() && nearest.cmple(bounds.max).all(),
                "{name}: {}",
                camera.name
            );
        }
    });
}

#[test]
fn scenes_need_what_they_promise() {
    let cornell = named("cornell").needs();
    assert!(cornell.emission && !cornell.specular && !cornell.transmission && !cornell.shadow_rays);
    let courtyard = named("courtyard").needs();
    assert!(courtyard.emission && courtyard.specular && courtyard.transmission && courtyard.absorption);
    assert!(courtyard.shadow_rays && !courtyard.normal_maps && !courtyard.coverage && !courtyard.motion);
    let spheres = named("spheres").needs();
    assert!(spheres.emission && spheres.specular && !spheres.transmission && !spheres.shadow_rays);
    let furnace = named("furnace").needs();
    assert!(furnace.emission && !furnace.specular);
    let glass = named("glass").needs();
    assert!(glass.transmission && glass.sky_map && !glass.absorption && !glass.emission);
    let relief = named("relief").needs();
    assert!(relief.height_maps && relief.shadow_rays && !relief.normal_maps && !relief.emission);
}

#[test]
fn solids_are_closed() {
    for (scene, objects) in [
        ("furnace", &["walls"][..]),
        ("glass", &["ball_1.33", "ball_1.5", "ball_2", "box"]),
        (
            "courtyard",
            &["glass ball", "metal ball", "light strip", "floor", "walls", "table", "screen posts"],
        ),
        ("spheres", &["metal_1_roughness_0.50", "glow_3"]),
    ] {
        let scene = named(scene);
        for name in objects {
            assert_eq!(open_edges(scene.rest(), object(&scene, name)), 0, "{}: {name}", scene.name);
        }
    }
}

#[test]
fn the_furnace_faces_inward_and_lies_on_its_bounds() {
    let scene = named("furnace");
    let g = scene.rest();
    assert_eq!(g.triangles.len(), 12);
    assert_eq!((scene.bounds().min, scene.bounds().max), (Vec3::splat(-0.5), Vec3::splat(0.5)));
    let mut area = 0.0;
    for triangle in &g.triangles {
        let face = wound(g, triangle);
        area += 0.5 * face.length();
        assert!(g.corners(triangle).iter().all(|p| face.normalize().dot(*p) == -0.5));
    }
    // Twelve halves of a square metre, exact in f32.
    assert_eq!(area, 6.0);
    assert!(!scene.materials[0].double_sided);
    let other = furnace(0.25, 3.0);
    assert_eq!((other.materials[0].base_color.x, other.materials[0].emission), (0.25, Vec3::splat(3.0)));
}

#[test]
fn spheres_vary_as_their_rows_and_columns_say() {
    let scene = named("spheres");
    assert_eq!(scene.materials.len(), 28);
    assert_eq!(scene.sky, Sky::Constant(Vec3::ONE));
    for object in &scene.rest().objects {
        let material =
            &scene.materials[scene.rest().triangles[object.triangles.start as usize].material as usize];
        let at = scene.rest().positions[object.vertices.start as usize];
        let (column, row) = (at.x.round(), (at.y + 0.42).round());
        assert_eq!(material.emits(), row == 0.0);
        if row > 0.0 {
            assert_eq!((material.roughness, material.metallic), (column / 6.0, (3.0 - row) / 2.0));
        }
    }
}

#[test]
fn the_courtyard_has_its_size_and_stays_small() {
    let scene = named("courtyard");
    let count = scene.rest().triangles.len();
    assert!((5_000..60_000).contains(&count), "{count} triangles");
    // 12 x 6 x 9 m inside, a quarter of a metre of stone around and below.
    assert!((scene.bounds().size() - Vec3::new(12.5, 6.25, 9.5)).abs().max_element() < 1e-5);
    assert!(scene.sun.is_some_and(|sun| sun.direction.is_normalized() && sun.direction.y < 0.0));
}

#[test]
fn cornell_is_the_file_of_the_reference_images() {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/truth/cornell.gltf"));
    if !path.exists() {
        return println!("skipped: no {}", path.display());
    }
    let (ours, file) = (named("cornell"), Scene::load(path.to_str().unwrap()).unwrap());
    assert_eq!((ours.rest().triangles.len(), file.rest().triangles.len()), (32, 32));
    for (a, b) in ours.rest().triangles.iter().zip(&file.rest().triangles) {
        // Both are the same doubles rounded once; the file's node transforms are identities.
        assert_eq!(ours.rest().corners(a), file.rest().corners(b));
        let (ours, file) = (&ours.materials[a.material as usize], &file.materials[b.material as usize]);
        assert_eq!(ours.name, file.name);
        assert_eq!(
            (ours.base_color, ours.metallic, ours.roughness, ours.specular, ours.double_sided),
            (file.base_color, file.metallic, file.roughness, file.specular, file.double_sided)
        );
        // The file stores emission as factor times strength: two roundings to f32.
        assert!(
            (ours.emission - file.emission).abs().max_element() <= 4e-6,
            "{} {}",
            ours.emission,
            file.emission
        );
    }
    for (a, b) in ours.rest().triangles.iter().zip(&file.rest().triangles) {
        for (v, w) in a.vertices.into_iter().zip(b.vertices) {
            let (n, m) = (ours.rest().normals[v as usize], file.rest().normals[w as usize]);
            // The loader may normalise once more in f32.
            assert!((n - m).abs().max_element() < 1e-6, "{n} {m}");
        }
    }
    let (a, b) = (ours.camera(0, 0.0).unwrap(), file.camera(0, 0.0).unwrap());
    assert_eq!((a.eye, a.vfov), (b.eye, b.vfov));
    assert!((a.forward() - b.forward()).length() < 1e-6);
}
