//! Which extensions are read, and small departures from the schema that are no reason to refuse a file.

use super::Fault;
use crate::budget::Meter;
use gltf::json::Root;
use serde_json::{self, Value};

/// Read, wherever they are used. Textures of specular-glossiness are left out, its numbers are converted.
const READ: [&str; 12] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Refuses what is required and not read; warns of what is used and not read.
pub(super) fn check(root: &Root, warnings: &mut Vec<String>) -> Result<(), Fault> {
    let missing = |names: &[String]| -> Vec<String> {
        names.iter().filter(|name| !READ.contains(&name.as_str())).cloned().collect()
    };
    let required = missing(&root.extensions_required);
    if !required.is_empty() {
        return Err(format!("requires {}, which is not supported", required.join(", ")));
    }
    warnings.extend(missing(&root.extensions_used).into_iter().map(|name| format!("{name} is left out")));
    Ok(())
}

/// Counts what the parsed JSON may take: an empty object of two bytes becomes a struct, or a map, of hundreds.
pub(super) fn afford(json: &[u8], meter: &Meter) -> Result<(), Fault> {
    let count = |byte: u8| json.iter().filter(|b| **b == byte).count() as u64;
    let (objects, lists, commas) = (count(b'{'), count(b'['), count(b','));
    // A map of one entry takes 0.7 KB, most structs less; an element of a list of numbers takes 4 to 72 bytes.
    let taken = meter
        .take(json.len() as u64, 2)
        .and_then(|()| meter.take(objects, 1024))
        .and_then(|()| meter.take(lists + commas, 72));
    taken.map_err(|over| format!("JSON: {objects} objects, {lists} lists, {commas} commas: {over}"))
}

/// The JSON as plain structs.
pub(super) fn parse(json: &[u8], warnings: &mut Vec<String>) -> Result<Root, Fault> {
    Root::from_slice(json).or_else(|fault| {
        // The structs ask for three things that glTF leaves free; only then is the slower way worth its time.
        let refuse = || format!("JSON: {fault}");
        let mut value: Value = serde_json::from_slice(json).map_err(|_| refuse())?;
        write_integers_as_such(&mut value);
        for scene in value.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten() {
            if let Some(scene) = scene.as_object_mut() {
                scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
            }
        }
        let mut aimless = 0;
        for animation in value.get_mut("animations").and_then(Value::as_array_mut).into_iter().flatten() {
            if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
                let before = channels.len();
                channels.retain(|channel| {
                    channel.get("target").is_none_or(|target| target.get("node").is_some())
                });
                aimless += before - channels.len();
            }
        }
        let root = serde_json::from_value(value).map_err(|_| refuse())?;
        if aimless > 0 {
            warnings.push(format!("{aimless} animation channels that aim at no node are left out"));
        }
        Ok(root)
    })
}

/// `1.0` is as good an integer as `1`. Nesting is limited by the parser.
fn write_integers_as_such(value: &mut Value) {
    match value {
        Value::Number(number) => {
            // Beyond 2^53 floats no longer hold every integer.
            let whole =
                number.as_f64().filter(|x| number.is_f64() && x.fract() == 0.0 && (0.0..9e15).contains(x));
            if let Some(x) = whole {
                *value = Value::from(x as u64);
            }
        }
        Value::Array(list) => list.iter_mut().for_each(write_integers_as_such),
        Value::Object(map) => map.values_mut().for_each(write_integers_as_such),
        _ => {}
    }
}
