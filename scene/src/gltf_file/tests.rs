//! Small files written here, each about one question.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::*;
use crate::{Alpha, PunctualKind};
use base64::Engine;
use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};

/// A file of one buffer; views and accessors are added as they come.
struct File {
    json: Value,
    bytes: Vec<u8>,
    budget: LoadBudget,
}

impl File {
    /// One node with one mesh of one primitive without attributes.
    fn new() -> Self {
        let primitive = json!({"attributes": {}});
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [primitive]}], "accessors": [], "bufferViews": []
        });
        Self { json, bytes: Vec::new(), budget: LoadBudget::default() }
    }

    /// A unit right triangle in the plane z = 0 facing +Z.
    fn triangle() -> Self {
        let mut file = Self::new();
        let corners = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = corners;
        file
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()}));
        self.bytes.extend(bytes);
        views.len() - 1
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> Value {
        let view = self.view(bytes);
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({"bufferView": view, "componentType": component, "count": count, "type": kind}));
        json!(accessors.len() - 1)
    }

    fn floats(&mut self, kind: &str, numbers: &[f32]) -> Value {
        let width = ["SCALAR", "", "VEC2", "VEC3", "VEC4"].iter().position(|k| *k == kind).unwrap().max(1);
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(kind, 5126, numbers.len() / width, &bytes)
    }

    fn load(&self) -> Result<Scene, Fault> {
        let mut json = self.json.clone();
        let body = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
        json["buffers"] = json!([{
            "byteLength": self.bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{body}")
        }]);
        scene(Path::new("test.gltf"), json.to_string().as_bytes(), Meter::new(self.budget))
    }
}

/// Normal of a triangle's plane from its winding.
fn facing(scene: &Scene, triangle: usize) -> Vec3 {
    let [a, b, c] = scene.rest().corners(&scene.rest().triangles[triangle]);
    (b - a).cross(c - a).normalize()
}

#[test]
fn a_triangle_without_normals_is_flat_and_faces_its_way() {
    let scene = File::triangle().load().unwrap();
    assert_eq!(scene.rest().normals, [Vec3::Z; 3]);
    assert_eq!(facing(&scene, 0), Vec3::Z);
    assert_eq!(scene.materials.len(), 1, "the default material");
    assert!(scene.rest().uv1.is_empty() && scene.rest().colors.is_empty());
}

#[test]
fn mirrored_nodes_turn_their_triangles_back() {
    for (scale, outside) in
        [([-1.0, 1.0, 1.0], Vec3::Z), ([1.0, 1.0, -1.0], Vec3::NEG_Z), ([-1.0, -1.0, 1.0], Vec3::Z)]
    {
        let mut file = File::triangle();
        file.json["nodes"][0]["scale"] = json!(scale);
        let scene = file.load().unwrap();
        assert_eq!(facing(&scene, 0), outside, "{scale:?}");
        assert_eq!(scene.rest().normals[0], outside, "{scale:?}");
    }
}

#[test]
fn strips_and_fans_are_wound_as_the_format_says() {
    for (mode, corners) in
        [(5, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]), (6, [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0])]
    {
        let mut file = File::new();
        let corners: Vec<f32> = corners.chunks(2).flat_map(|c| [c[0], c[1], 0.0]).collect();
        let positions = file.floats("VEC3", &corners);
        let primitive = &mut file.json["meshes"][0]["primitives"][0];
        primitive["attributes"]["POSITION"] = positions;
        primitive["mode"] = json!(mode);
        let scene = file.load().unwrap();
        assert_eq!((facing(&scene, 0), facing(&scene, 1)), (Vec3::Z, Vec3::Z), "mode {mode}");
        assert_eq!(scene.rest().triangles.len(), 2);
    }
}

#[test]
fn points_and_lines_are_left_out_with_one_warning() {
    let mut file = File::triangle();
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(1);
    let scene = file.load().unwrap();
    assert!(scene.rest().triangles.is_empty());
    assert_eq!(scene.warnings, ["1 primitives of points or lines are left out"]);
}

#[test]
fn sparse_accessors_replace_elements_of_zeros_and_of_bytes() {
    for with_base in [false, true] {
        let mut file = File::triangle();
        let indices = file.view(&[1, 2]);
        let values = file.view(&[2.0_f32, 0.0, 0.0, 0.0, 3.0, 0.0].map(f32::to_le_bytes).concat());
        let accessor = &mut file.json["accessors"][0];
        accessor["sparse"] = json!({
            "count": 2, "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": values}
        });
        if !with_base {
            accessor.as_object_mut().unwrap().remove("bufferView");
        }
        let scene = file.load().unwrap();
        assert_eq!(scene.rest().positions, [Vec3::ZERO, 2.0 * Vec3::X, 3.0 * Vec3::Y], "{with_base}");
    }
}

#[test]
fn every_component_type_is_read_normalized_or_not() {
    for (component, bytes, normalized, wanted) in [
        (5120, vec![127, 0, 0x81, 0x80], true, Vec4::new(1.0, 0.0, 0.0, 0.0)),
        (5121, vec![255, 51, 0, 102], true, Vec4::new(1.0, 0.2, 0.0, 0.4)),
        (
            5122,
            [0x7fff_u16, 0, 0x8000, 0].map(u16::to_le_bytes).concat(),
            true,
            Vec4::new(1.0, 0.0, 0.0, 0.0),
        ),
        (
            5123,
            [65_535_u16, 13_107, 0, 0].map(u16::to_le_bytes).concat(),
            true,
            Vec4::new(1.0, 0.2, 0.0, 0.0),
        ),
        (5125, [1_u32, 0, 0, 1].map(u32::to_le_bytes).concat(), false, Vec4::new(1.0, 0.0, 0.0, 1.0)),
        (
            5126,
            [0.5_f32, 0.25, 0.0, 1.0].map(f32::to_le_bytes).concat(),
            false,
            Vec4::new(0.5, 0.25, 0.0, 1.0),
        ),
    ] {
        let mut file = File::triangle();
        let colors = file.accessor("VEC4", component, 3, &bytes.repeat(3));
        file.json["accessors"][1]["normalized"] = json!(normalized);
        file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = colors;
        let scene = file.load().unwrap();
        // Negative colours are brought to 0; one rounding of the division.
        assert!(scene.rest().colors[0].abs_diff_eq(wanted, 1e-6), "{component}: {}", scene.rest().colors[0]);
    }
}

#[test]
fn every_index_type_is_read_and_bounds_are_kept() {
    for (component, bytes) in [
        (5121, vec![0, 2, 1]),
        (5123, [0_u16, 2, 1].map(u16::to_le_bytes).concat()),
        (5125, [0_u32, 2, 1].map(u32::to_le_bytes).concat()),
    ] {
        let mut file = File::triangle();
        let indices = file.accessor("SCALAR", component, 3, &bytes);
        file.json["meshes"][0]["primitives"][0]["indices"] = indices;
        assert_eq!(facing(&file.load().unwrap(), 0), Vec3::NEG_Z, "{component}");
    }
    let mut file = File::triangle();
    let indices = file.accessor("SCALAR", 5121, 3, &[0, 1, 3]);
    file.json["meshes"][0]["primitives"][0]["indices"] = indices;
    assert_eq!(file.load().unwrap_err(), "meshes[0].primitives[0]: index 3 of 3 vertices");
}

#[test]
fn absurd_numbers_are_refused_before_they_take_memory() {
    let refusal = |edit: &dyn Fn(&mut Value)| {
        let mut file = File::triangle();
        edit(&mut file.json);
        file.load().unwrap_err()
    };
    assert_eq!(
        refusal(&|j| j["accessors"][0]["count"] = json!(4)),
        "accessors[0]: 48 bytes needed, bufferViews[0] has 36"
    );
    for count in [u64::MAX, 1 << 62, 1 << 40] {
        refusal(&|j| j["accessors"][0]["count"] = json!(count));
        refusal(&|j| j["accessors"][0] = json!({"componentType": 5126, "count": count, "type": "VEC3"}));
        refusal(&|j| j["accessors"][0]["byteOffset"] = json!(count));
        refusal(&|j| j["bufferViews"][0]["byteLength"] = json!(count));
        refusal(&|j| j["bufferViews"][0]["byteOffset"] = json!(count));
        refusal(&|j| j["bufferViews"][0]["byteStride"] = json!(count));
        refusal(&|j| {
            j["accessors"][0]["sparse"] = json!({
                "count": count, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 0}
            })
        });
    }
    refusal(&|j| j["bufferViews"][0]["byteStride"] = json!(0));
    refusal(&|j| j["bufferViews"][0]["buffer"] = json!(7));
    refusal(&|j| j["nodes"][0]["children"] = json!([0]));
    refusal(&|j| j["nodes"][0]["children"] = json!([9]));
    refusal(&|j| j["scenes"][0]["nodes"] = json!([0, 0]));
    // Nodes times primitives times instances.
    let many = refusal(&|j| {
        j["meshes"][0]["primitives"] = json!(vec![j["meshes"][0]["primitives"][0].clone(); 3000]);
        j["nodes"] = json!(vec![json!({"mesh": 0}); 2000]);
        j["scenes"][0]["nodes"] = json!((0..2000).collect::<Vec<_>>());
    });
    assert!(many.starts_with("nodes[") && many.contains("the budget for loading is 2000 MB"), "{many}");
}

#[test]
fn deep_chains_do_not_overflow_the_stack() {
    let mut file = File::triangle();
    let chain = (0..200_000).map(|n| json!({"children": [n + 1], "translation": [1, 0, 0]}));
    file.json["nodes"] = chain.chain([json!({"mesh": 0})]).collect();
    let scene = file.load().unwrap();
    // So far away is brought near.
    assert_eq!(scene.origin() + scene.rest().positions[0], 200_000.0 * Vec3::X);
}

#[test]
fn triangles_that_are_not_finite_are_left_out_and_counted() {
    let mut file = File::new();
    let mut corners = [0.0; 18];
    (corners[4], corners[13], corners[15]) = (1.0, f32::NAN, f32::INFINITY);
    let positions = file.floats("VEC3", &corners);
    file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = positions;
    let scene = file.load().unwrap();
    assert_eq!(scene.rest().triangles.len(), 1);
    assert!(scene.rest().positions.iter().all(|p| p.is_finite()));
    assert_eq!(scene.warnings, ["1 triangles are left out: a corner is not finite"]);
    let mut far = File::triangle();
    far.json["nodes"][0]["scale"] = json!([3e38, 3e38, 3e38]);
    far.json["nodes"][0]["translation"] = json!([3e38, 0, 0]);
    assert!(far.load().unwrap().rest().positions.iter().all(|p| p.is_finite()));
}

#[test]
fn a_scene_far_away_is_brought_near_with_all_that_is_in_it() {
    let mut file = File::triangle();
    file.json["nodes"] = json!([{"mesh": 0, "translation": [10000, 0, -10000]},
        {"camera": 0, "translation": [10000, 0, -9996]}]);
    file.json["scenes"][0]["nodes"] = json!([0, 1]);
    file.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}]);
    let scene = file.load().unwrap();
    assert_eq!(scene.origin(), Vec3::new(10000.0, 0.0, -10000.0));
    assert_eq!(scene.rest().positions, [Vec3::ZERO, Vec3::X, Vec3::Y], "as exact as it was in the file");
    assert_eq!(scene.cameras[0].eye, 4.0 * Vec3::Z);
    // What is near stays where it is, to the bit.
    let mut near = File::triangle();
    near.json["nodes"][0]["translation"] = json!([100, 0, 0]);
    let near = near.load().unwrap();
    assert_eq!((near.origin(), near.rest().positions[0]), (Vec3::ZERO, Vec3::new(100.0, 0.0, 0.0)));
}

#[test]
fn extensions_required_but_not_read_are_named() {
    let mut file = File::triangle();
    file.json["extensionsUsed"] = json!(["KHR_materials_sheen", "KHR_draco_mesh_compression"]);
    assert_eq!(file.load().unwrap().warnings.len(), 2);
    file.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression", "KHR_materials_volume"]);
    assert_eq!(file.load().unwrap_err(), "requires KHR_draco_mesh_compression, which is not supported");
}

#[test]
fn materials_read_every_extension() {
    let mut file = File::triangle();
    let white = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8/5+hHgAHggJ/PchI7wAAAABJRU5ErkJggg==";
    file.json["images"] = json!([{"uri": white}]);
    file.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
    file.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    file.json["materials"] = json!([{
        "name": "all", "alphaMode": "MASK", "doubleSided": true, "emissiveFactor": [1, 0.5, 0],
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 7},
        "normalTexture": {"index": 0, "scale": 2, "texCoord": 1,
                          "extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "texCoord": 0}}},
        "extras": {"heightTexture": {"index": 0}, "heightScale": 0.05, "heightIsDepth": true},
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 4},
            "KHR_materials_ior": {"ior": 1.3},
            "KHR_materials_transmission": {"transmissionFactor": 0.75},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [0.5, 1, 1]},
            "KHR_materials_specular": {"specularFactor": 0.25, "specularColorFactor": [1, 0.5, 0.5]},
            "KHR_materials_anisotropy": {"anisotropyStrength": 0.6, "anisotropyRotation": 1.5,
                                         "anisotropyTexture": {"index": 0}},
            "KHR_materials_unlit": {}
        }
    }]);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let scene = file.load().unwrap();
    let m = &scene.materials[0];
    assert_eq!((m.name.as_str(), m.alpha, m.double_sided), ("all", Alpha::Mask(0.5), true));
    assert_eq!((m.base_color, m.metallic, m.roughness), (Vec4::new(0.1, 0.2, 0.3, 0.4), 0.5, 1.0));
    assert_eq!((m.emission, m.ior, m.transmission), (Vec3::new(4.0, 2.0, 0.0), 1.3, 0.75));
    assert_eq!((m.specular, m.specular_color), (0.25, Vec3::new(1.0, 0.5, 0.5)));
    assert_eq!((m.anisotropy, m.anisotropy_rotation, m.unlit), (0.6, 1.5, true));
    let volume = m.volume.unwrap();
    assert_eq!((volume.attenuation_distance, volume.attenuation_color), (2.0, Vec3::new(0.5, 1.0, 1.0)));
    let slot = m.normal_texture.unwrap();
    assert_eq!((m.normal_scale, slot.uv_set, slot.linear), (2.0, 0, false));
    assert_eq!(slot.wrap, [crate::Wrap::Clamp, crate::Wrap::Mirror]);
    assert_eq!(slot.uv_transform.transform_point2(Vec2::ZERO), Vec2::new(0.5, 0.0));
    let height = m.height.unwrap();
    assert_eq!((height.scale, height.is_depth, height.texture.image), (0.05, true, 0));
    assert_eq!((scene.images.len(), scene.images[0].width), (1, 1));
}

#[test]
fn uv1_is_kept_only_where_a_drawn_material_reads_it() {
    for (set, kept) in [(0, 0), (1, 3)] {
        let mut file = File::triangle();
        let uvs = file.floats("VEC2", &[0.5; 6]);
        file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = uvs;
        file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        file.json["images"] = json!([{"bufferView": 0}]);
        file.json["textures"] = json!([{"source": 0}]);
        file.json["materials"] = json!([{"emissiveTexture": {"index": 0, "texCoord": set}}]);
        let fault = file.load().unwrap_err();
        assert!(fault.contains("images[0]") && fault.contains("neither PNG nor JPEG"), "{fault}");
        let png = base64::engine::general_purpose::STANDARD
            .decode("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8/5+hHgAHggJ/PchI7wAAAABJRU5ErkJggg==");
        let view = file.view(&png.unwrap());
        file.json["images"][0]["bufferView"] = json!(view);
        assert_eq!(file.load().unwrap().rest().uv1.len(), kept, "set {set}");
    }
}

#[test]
fn instances_multiply_and_carry_their_own_places() {
    let mut file = File::triangle();
    let at = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 5.0]);
    let scale = file.floats("VEC3", &[1.0, 1.0, 1.0, -2.0, 2.0, 2.0]);
    file.json["nodes"][0]["translation"] = json!([10, 0, 0]);
    file.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": at, "SCALE": scale}}});
    let scene = file.load().unwrap();
    assert_eq!((scene.rest().objects.len(), scene.rest().triangles.len()), (2, 2));
    assert_eq!(scene.rest().positions[4], Vec3::new(8.0, 0.0, 5.0));
    assert_eq!((facing(&scene, 0), facing(&scene, 1)), (Vec3::Z, Vec3::Z), "the second is mirrored");
}

#[test]
fn cameras_and_lights_sit_at_their_nodes_and_follow_them() {
    let mut file = File::triangle();
    let times = file.floats("SCALAR", &[0.0, 2.0]);
    let places = file.floats("VEC3", &[1.0, 2.0, 3.0, 1.0, 2.0, 7.0]);
    file.json["nodes"] = json!([{
        "camera": 0, "translation": [1, 2, 3], "rotation": [0, 1, 0, 1],
        "extensions": {"KHR_lights_punctual": {"light": 0}}
    }]);
    file.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}]);
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "color": [1, 0.5, 0], "intensity": 4, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}}
    ]}});
    file.json["animations"] = json!([{
        "samplers": [{"input": times, "output": places}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]
    }]);
    let scene = file.load().unwrap();
    let light = scene.rest().lights[0];
    assert_eq!(light.kind, PunctualKind::Spot { inner: 0.1, outer: 0.2 });
    assert_eq!((light.intensity, light.position), (Vec3::new(4.0, 2.0, 0.0), Vec3::new(1.0, 2.0, 3.0)));
    // A quarter turn about +Y takes -Z to -X. 1e-6: the rounding of the quaternion.
    assert!(light.direction.abs_diff_eq(Vec3::NEG_X, 1e-6));
    assert!(scene.cameras[0].forward().abs_diff_eq(Vec3::NEG_X, 1e-6));
    assert_eq!(scene.camera(0, 1.0).unwrap().eye, Vec3::new(1.0, 2.0, 5.0));
    let mut later = scene.rest().clone();
    scene.pose(1.0, &mut later);
    assert_eq!(later.lights[0].position, Vec3::new(1.0, 2.0, 5.0));
    assert_eq!(scene.duration(), 2.0);
    assert!(scene.camera(1, 0.0).is_none());
}

#[test]
fn morph_weights_and_mirroring_scales_animate() {
    let mut file = File::triangle();
    let lift = file.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    let times = file.floats("SCALAR", &[0.0, 1.0]);
    let weights = file.floats("SCALAR", &[0.0, 1.0]);
    let scales = file.floats("VEC3", &[1.0, 1.0, 1.0, -1.0, 1.0, 1.0]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": lift}]);
    file.json["animations"] = json!([{
        "samplers": [{"input": times, "output": weights}, {"input": times, "output": scales, "interpolation": "STEP"}],
        "channels": [
            {"sampler": 0, "target": {"node": 0, "path": "weights"}},
            {"sampler": 1, "target": {"node": 0, "path": "scale"}}
        ]
    }]);
    let scene = file.load().unwrap();
    let mut geometry = scene.rest().clone();
    scene.pose(0.5, &mut geometry);
    assert_eq!(geometry.positions, [Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 1.0)]);
    scene.pose(1.0, &mut geometry);
    assert_eq!(geometry.positions[1], Vec3::new(-1.0, 0.0, 2.0));
    let [a, b, c] = geometry.corners(&geometry.triangles[0]);
    assert_eq!(((b - a).cross(c - a), geometry.normals[0]), (Vec3::Z, Vec3::Z), "still seen from the front");
    assert_eq!(
        (scene.bounds().min, scene.bounds().max),
        (Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 1.0, 2.0))
    );
    scene.pose(0.0, &mut geometry);
    assert_eq!(geometry, *scene.rest());
}

/// Our tangents against those of files that bring their own, made by other tools.
#[test]
fn made_tangents_agree_with_given_ones() {
    for file in ["normal_tangent_mirror_test/NormalTangentMirrorTest.gltf", "sponza/sponza.gltf"] {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/scenes")).join(file);
        let Ok(bytes) = std::fs::read(&path) else {
            println!("skipped: {} is missing", path.display());
            return;
        };
        let mut document = open(&bytes, path.parent().unwrap(), Meter::new(LoadBudget::default())).unwrap();
        let (materials, _) = materials::read(&mut document).unwrap();
        let (mut near, mut handed, mut all) = (0, 0, 0);
        for index in 0..document.root.meshes.len() as u32 {
            let read = |document: &Document| {
                let mut skipped = meshes::Skipped::default();
                meshes::read(document, Index::new(index), &materials, &mut skipped, "the test").unwrap()
            };
            let given = read(&document);
            for primitive in &mut document.root.meshes[index as usize].primitives {
                primitive.attributes.remove(&Checked::Valid(gltf::json::mesh::Semantic::Tangents));
            }
            let made = read(&document);
            for ((_, given), (_, made)) in given.iter().zip(&made) {
                let wanted = materials.get(given.material).and_then(tangents::uv_set);
                for (g, m) in given.triangles.as_flattened().iter().zip(made.triangles.as_flattened()) {
                    let (g, m) = (given.shape.tangents[*g as usize], made.shape.tangents[*m as usize]);
                    all += usize::from(wanted.is_some());
                    near += usize::from(wanted.is_some() && g.truncate().dot(m.truncate()) > 0.9);
                    handed += usize::from(wanted.is_some() && g.w == m.w);
                }
            }
        }
        // Tools differ at seams and where a texture has no area; a wrong sign or axis would fail nearly everywhere.
        assert!(all > 1000, "{file}: {all} corners compared");
        assert!(near as f32 > 0.95 * all as f32, "{file}: {near} of {all} within 26 degrees");
        assert!(handed as f32 > 0.97 * all as f32, "{file}: {handed} of {all} with the same sign");
    }
}
