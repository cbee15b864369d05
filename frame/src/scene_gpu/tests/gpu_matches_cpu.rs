//! Snippets against their CPU halves, on random input.

use super::*;
use crate::scene_gpu::texels::Plane;
use crate::{Kernel, KernelDesc, Recorder};
use glam::{Vec3, Vec4};
use scene::{Alpha, Sky, SkyMap, Volume};

const OUT: Bind = Bind::storage(3, 0, "out_values");
const QUERIES: Bind = Bind::storage_read(2, 0, "queries");
const DECLARATIONS: &str = "
@group(2) @binding(0) var<storage, read> queries: array<vec4f>;
@group(3) @binding(0) var<storage, read_write> out_values: array<vec4f>;
";

/// Runs `body` for each query (`id`, `query`); it writes `per_query` values of four numbers.
fn run(
    gpu: &Gpu,
    snippets: &[&str],
    binds: &[Bind],
    resources: &[BindingResource<'_>],
    constants: &[(&str, f64)],
    queries: &[Vec4],
    per_query: usize,
    body: &str,
) -> Vec<Vec4> {
    let entry = format!(
        "@compute @workgroup_size(64) fn run(@builtin(global_invocation_id) at: vec3u) {{
            let id = at.x;
            if (id >= arrayLength(&queries)) {{ return; }}
            let query = queries[id];
            {body}
        }}"
    );
    let sources: Vec<_> = snippets.iter().copied().chain([DECLARATIONS, &entry]).collect();
    let bindings: Vec<_> = binds.iter().copied().chain([QUERIES, OUT]).collect();
    let kernel = Kernel::new(
        gpu,
        &KernelDesc {
            name: "test",
            sources: &sources,
            entry: "run",
            workgroup: [64, 1, 1],
            bindings: &bindings,
            constants,
        },
    )
    .unwrap();
    let out = vec![Vec4::ZERO; queries.len() * per_query];
    let out = gpu.storage(Room::Scene, "out", &out).unwrap();
    let queries_buffer = gpu.storage(Room::Scene, "queries", queries).unwrap();
    let mut all = resources.to_vec();
    all.extend([queries_buffer.as_entire_binding(), out.as_entire_binding()]);
    let mut recorder = Recorder::new(gpu);
    recorder.compute("test", &kernel, &all, [(queries.len() as u32).div_ceil(64), 1, 1]);
    recorder.finish().unwrap();
    gpu.read_buffer(&out).unwrap()
}

const MATERIAL_SOURCES: [&str; 4] = [surface::WGSL, crate::brdf::WGSL, MESH_WGSL, MATERIAL_WGSL];

/// A scene whose material i has one texture in slot 0 (sRGB) and another in slot 2 (linear), in all ways to wrap.
fn textured() -> Scene {
    let mut scene = scene("cornell");
    scene.images = [(7, 5), (128, 64), (300, 200), (1, 1)]
        .map(|(width, height)| random_image("noise", width, height))
        .to_vec();
    scene.materials.truncate(1);
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    let plain = scene::Material::lambert("", Vec3::ONE);
    for (i, (u, v)) in wraps.iter().flat_map(|&u| wraps.map(|v| (u, v))).enumerate() {
        for linear in [true, false] {
            let mut m = plain.clone();
            m.base_color_texture = Some(slot(i as u32 % 4, [u, v], linear));
            m.normal_texture = Some(slot((i as u32 + 1) % 4, [v, u], linear));
            scene.materials.push(m);
        }
    }
    scene
}

const LOOKUP: &str = "
var point: MeshPoint;
point.uv0 = query.xy;
point.uv1 = query.yx;
point.uv_density = vec2f(1.0);
let material = u32(query.z);
out_values[2u * id] = material_lookup(materials[material].slots[0], point, query.w, false);
out_values[2u * id + 1u] = material_lookup(materials[material].slots[2], point, query.w, false);
";

#[test]
fn textures_are_read_alike() {
    let (gpu, scene) = (gpu(), textured());
    let uploaded = uploaded(&gpu, &scene);
    let mut random = Random(1);
    let queries: Vec<_> = (0..4000)
        .map(|i| {
            let spread = if i % 2 == 0 { 1.0 } else { 20.0 };
            let [u, v] = [(); 2].map(|_| spread * (random.next() - 0.5));
            Vec4::new(u, v, (1 + random.below(scene.materials.len() as u32 - 1)) as f32, 0.0)
        })
        .collect();
    let resources = uploaded.material_resources();
    let values = run(&gpu, &MATERIAL_SOURCES, &MATERIAL_BINDS, &resources, &[], &queries, 2, LOOKUP);
    let mut on_an_edge = 0;
    for (query, pair) in queries.iter().zip(values.chunks_exact(2)) {
        let m = &scene.materials[query.z as usize];
        let uv = [Vec2::new(query.x, query.y), Vec2::new(query.y, query.x)];
        let slots = [(m.base_color_texture, Encoding::Srgb), (m.normal_texture, Encoding::Linear)];
        for ((slot, encoding), gpu_value) in slots.into_iter().zip(pair) {
            let slot = slot.unwrap();
            let image = &scene.images[slot.image as usize];
            let value = reference::lookup(image, &slot, encoding, uv, false);
            // Coordinates of up to 34 in f32 are good to 2e-6, times 300 texels of random neighbours: 6e-4 of a step
            // of 1. The driver's sRGB decoding is allowed half a code of 255.
            let alike = gpu_value.abs_diff_eq(value, 3e-3);
            if !alike && !slot.linear {
                // A nearest texel jumps where the coordinate rounds to the other side.
                let at = slot.uv_transform.transform_point2(uv[slot.uv_set as usize]);
                let texels = at * Vec2::new(image.width as f32, image.height as f32);
                let to_edge = (texels - texels.round()).abs().min_element();
                assert!(
                    to_edge < 2e-3,
                    "{query}: {gpu_value} against {value}, {to_edge} texels from an edge"
                );
                on_an_edge += 1;
                continue;
            }
            assert!(alike, "{query}, {slot:?}: {gpu_value} against {value}");
        }
    }
    // An edge is that near with a probability of 4 * 2e-3.
    assert!(on_an_edge < 80, "{on_an_edge} of 4000 on an edge");
}

#[test]
fn a_footprint_chooses_the_mip_of_its_area() {
    let (gpu, scene) = (gpu(), textured());
    let uploaded = uploaded(&gpu, &scene);
    let mut random = Random(2);
    let mut expected = Vec::new();
    let mut queries = Vec::new();
    let linear =
        (1..scene.materials.len()).filter(|&i| scene.materials[i].base_color_texture.unwrap().linear);
    for material in linear {
        let slot = scene.materials[material].base_color_texture.unwrap();
        let image = &scene.images[slot.image as usize];
        let mut plane =
            Plane::decode([image.width as usize, image.height as usize], &image.rgba, Encoding::Srgb, None);
        for level in 0..=image.width.max(image.height).ilog2() {
            if level > 0 {
                plane = plane.mip();
            }
            // An area of 4^level texels, in square metres at a density of 1 uv^2 per m^2.
            let texels = slot.uv_transform.determinant() * (image.width * image.height) as f32;
            let area = 4f32.powi(level as i32) / texels;
            let [width, height] = plane.size.map(|n| n as u32);
            let mip = Image { name: String::new(), width, height, rgba: plane.encode(Encoding::Srgb) };
            for _ in 0..20 {
                let uv = Vec2::new(random.next(), random.next());
                queries.push(Vec4::new(uv.x, uv.y, material as f32, area));
                let value =
                    reference::lookup(&mip, &slot, Encoding::Srgb, [uv, Vec2::new(uv.y, uv.x)], false);
                expected.push(value);
            }
        }
    }
    let resources = uploaded.material_resources();
    let values = run(&gpu, &MATERIAL_SOURCES, &MATERIAL_BINDS, &resources, &[], &queries, 2, LOOKUP);
    for ((query, value), gpu_value) in queries.iter().zip(expected).zip(values.chunks_exact(2)) {
        // As above; coordinates are small here.
        assert!(gpu_value[0].abs_diff_eq(value, 2e-3), "{query}: {} against {value}", gpu_value[0]);
    }
}

/// Every feature a material can have, each in several, textured in turns.
fn varied() -> Scene {
    let mut scene = scene("spheres");
    scene.images = [(16, 16), (40, 30)].map(|(width, height)| random_image("noise", width, height)).to_vec();
    let count = scene.materials.len();
    let mut random = Random(3);
    scene.materials = (0..count)
        .map(|i| {
            let mut texture = |every: usize, at: usize| {
                (i % every == at).then(|| slot(random.below(2), [Wrap::Repeat, Wrap::Mirror], true))
            };
            scene::Material {
                base_color_texture: texture(2, 0),
                metallic_roughness_texture: texture(3, 1),
                normal_texture: texture(2, 1),
                emission_texture: texture(3, 0),
                specular_texture: texture(4, 1),
                specular_color_texture: texture(5, 1),
                transmission_texture: texture(4, 3),
                anisotropy_texture: texture(2, 1),
                base_color: Vec4::new(random.next(), random.next(), random.next(), random.next()),
                metallic: random.next(),
                roughness: random.next(),
                normal_scale: 2.0 * random.next(),
                emission: if i % 3 == 0 { Vec3::new(random.next(), 9.0, 0.1) } else { Vec3::ZERO },
                alpha: [Alpha::Opaque, Alpha::Blend, Alpha::Mask(0.3)][i % 3],
                double_sided: i % 2 == 0,
                ior: 1.0 + random.next(),
                specular: random.next(),
                specular_color: Vec3::new(1.0, random.next(), 0.5),
                transmission: if i % 4 == 3 { random.next() } else { 0.0 },
                volume: (i % 8 == 3).then_some(Volume {
                    attenuation_distance: 0.5,
                    attenuation_color: Vec3::new(0.9, 0.2, 0.5),
                }),
                anisotropy: if i % 2 == 1 { random.next() } else { 0.0 },
                anisotropy_rotation: random.next(),
                unlit: i % 7 == 6,
                ..scene::Material::default()
            }
        })
        .collect();
    scene
}

const SURFACE: &str = "
let point = mesh_point(u32(query.x), query.yz);
let material = mesh_material(u32(query.x));
let s = material_surface(material, point, 0.0);
let opacity = material_opacity(material, point, 0.0);
out_values[7u * id] = vec4f(s.normal, s.handedness);
out_values[7u * id + 1u] = vec4f(s.tangent, s.metalness);
out_values[7u * id + 2u] = vec4f(s.base, s.f0);
out_values[7u * id + 3u] = vec4f(s.emission, s.transmission);
out_values[7u * id + 4u] = vec4f(s.absorption, opacity);
out_values[7u * id + 5u] = vec4f(s.roughness, select(0.0, 1.0, s.two_sided), select(0.0, 1.0, s.thin));
out_values[7u * id + 6u] = vec4f(point.position, s.coverage);
";

#[test]
fn materials_become_the_same_surfaces() {
    let (gpu, scene) = (gpu(), varied());
    let uploaded = uploaded(&gpu, &scene);
    let mut random = Random(4);
    let count = scene.rest().triangles.len() as u32;
    let queries: Vec<_> = (0..4000)
        .map(|_| {
            let (a, b) = (random.next(), random.next());
            let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
            Vec4::new(random.below(count) as f32, a, b, 0.0)
        })
        .collect();
    let binds: Vec<_> = MESH_BINDS.into_iter().chain(MATERIAL_BINDS).collect();
    let resources: Vec<_> =
        uploaded.mesh.resources().into_iter().chain(uploaded.material_resources()).collect();
    let constants = uploaded.mesh.layout.constants();
    let values = run(&gpu, &MATERIAL_SOURCES, &binds, &resources, &constants, &queries, 7, SURFACE);
    let mut unlike_masks = 0;
    for (query, gpu_values) in queries.iter().zip(values.chunks_exact(7)) {
        let triangle = query.x as usize;
        let material = scene.rest().triangles[triangle].material as usize;
        let point = reference::mesh_point(scene.rest(), triangle, Vec2::new(query.y, query.z));
        let s = reference::surface(&scene, material, &point, uploaded.radiance_scale);
        let opacity = reference::opacity(&scene, material, &point);
        let flag = |on: bool| f32::from(u8::from(on));
        let m = &scene.materials[material];
        let expected = [
            // Vertex normals are packed to 16 + 16 bits (5e-5 rad), tangents to 16 + 15 (1e-4); a normal map of noise
            // multiplies the error of a coordinate, and its mean direction can be short, by ten or so.
            (s.normal.extend(s.handedness), 5e-3),
            // The same, across a normal that may lie near the tangent.
            (s.tangent.extend(s.metalness), 3e-2),
            // Textures: half a code of 255 for the driver's sRGB.
            (s.base.extend(s.f0), 3e-3),
            (
                s.emission.extend(s.transmission),
                3e-3 * uploaded.radiance_scale * (1.0 + m.emission.max_element()),
            ),
            (s.absorption.extend(opacity), 3e-3),
            (Vec4::new(s.roughness.x, s.roughness.y, flag(s.two_sided), flag(s.thin)), 5e-3),
        ];
        if matches!(m.alpha, Alpha::Mask(_)) && (gpu_values[4].w - opacity).abs() > 0.5 {
            // The nearest texel jumps where the coordinate rounds to the other side.
            unlike_masks += 1;
            continue;
        }
        for (i, (value, tolerance)) in expected.into_iter().enumerate() {
            // An anisotropy texel may point nowhere, and then the tangent is any.
            let aimless = i == 1 && m.anisotropy_texture.is_some() && m.anisotropy > 0.0;
            let tolerance =
                if aimless { Vec4::new(2.0, 2.0, 2.0, tolerance) } else { Vec4::splat(tolerance) };
            let error = (gpu_values[i] - value).abs();
            assert!(
                error.cmple(tolerance).all(),
                "{query}, {m:?}: value {i}: {} against {value}",
                gpu_values[i]
            );
        }
        // f32 interpolation of coordinates of a few metres.
        assert!(gpu_values[6].truncate().abs_diff_eq(point.position, 1e-5), "{query}");
    }
    assert!(unlike_masks < 8, "{unlike_masks} of 4000 masks differ");
}

#[test]
fn the_sky_is_looked_up_alike() {
    let gpu = gpu();
    let mut scene = scene("cornell");
    scene.materials.iter_mut().for_each(|m| m.emission = Vec3::ZERO);
    let mut random = Random(5);
    let radiance = (0..32 * 16).map(|_| Vec3::new(random.next(), 40.0 * random.next(), 1e-3)).collect();
    let mut queries: Vec<_> = (0..3000)
        .map(|_| (Vec3::new(random.next(), random.next(), random.next()) - 0.5).normalize().extend(0.0))
        .collect();
    queries.extend(
        [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z, Vec3::new(-1e-7, 0.0, 1.0)].map(|d| d.extend(0.0)),
    );
    for sky in [Sky::Map(SkyMap { width: 32, height: 16, radiance }), Sky::Constant(Vec3::new(1.0, 2.0, 3.0))]
    {
        scene.sky = sky;
        let uploaded = uploaded(&gpu, &scene);
        let resources = [BindingResource::TextureView(uploaded.sky.view())];
        let body = "out_values[id] = vec4f(sky_radiance(query.xyz), 1.0);";
        let values = run(&gpu, &[SKY_WGSL], &[SKY_BIND], &resources, &[], &queries, 1, body);
        for (query, value) in queries.iter().zip(values) {
            let expected = scene.sky.radiance(query.truncate());
            let radiance = value.truncate() / uploaded.radiance_scale;
            // atan2 may err by 4096 ulp of pi (1e-3 rad is 5e-3 texels here) between texels that differ by up to 40.
            assert!(radiance.abs_diff_eq(expected, 0.2), "{query}: {radiance} against {expected}");
        }
        // Straight up there is no azimuth: any texel of the first row will do.
        let up = run(&gpu, &[SKY_WGSL], &[SKY_BIND], &resources, &[], &[Vec4::Y], 1, body);
        assert!(up[0].is_finite() && up[0].y > 0.0);
    }
}
