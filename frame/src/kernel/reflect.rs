//! naga's view of a shader, compared with the declaration.

use super::{Bind, BindKind, KernelError};
use naga::{AddressSpace, ImageClass, ScalarKind, StorageAccess, TypeInner};
use std::collections::BTreeMap;

/// Parses, validates and compares. `workgroup` is given for compute kernels only.
pub(super) fn check(
    kernel: &str,
    source: &str,
    entries: &[&str],
    workgroup: Option<[u32; 3]>,
    bindings: &[Bind],
) -> Result<(), KernelError> {
    let shader = |message: String| KernelError::Shader { kernel: kernel.into(), message };
    let module = naga::front::wgsl::parse_str(source).map_err(|e| shader(e.emit_to_string(source)))?;
    // Packed half floats (`pack2x16float`) are core WebGPU; naga asks for them because GLES 3.0 lacks them.
    let capabilities =
        naga::valid::Capabilities::default() | naga::valid::Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|e| shader(e.emit_to_string(source)))?;
    let mismatch = |what: String, rust: String, wgsl: String| {
        Err(KernelError::Mismatch { kernel: kernel.into(), what, rust, wgsl })
    };

    let mut used = BTreeMap::new();
    for entry in entries {
        let Some(index) = module.entry_points.iter().position(|e| e.name == *entry) else {
            let there: Vec<_> = module.entry_points.iter().map(|e| e.name.as_str()).collect();
            return mismatch("entry point".into(), (*entry).into(), there.join(", "));
        };
        if let Some(workgroup) = workgroup
            && module.entry_points[index].workgroup_size != workgroup
        {
            let there = module.entry_points[index].workgroup_size;
            return mismatch("workgroup size".into(), format!("{workgroup:?}"), format!("{there:?}"));
        }
        for (handle, global) in module.global_variables.iter() {
            if let Some(place) = &global.binding
                && !info.get_entry_point(index)[handle].is_empty()
            {
                used.insert((place.group, place.binding), global);
            }
        }
    }
    for bind in bindings {
        let what = format!("@group({}) @binding({})", bind.group, bind.binding);
        let Some(global) = used.remove(&(bind.group, bind.binding)) else {
            return mismatch(what, bind.name.into(), "nothing used there".into());
        };
        let name = global.name.as_deref().unwrap_or("");
        if name != bind.name {
            return mismatch(what, bind.name.into(), name.into());
        }
        let there = kind(&module, global);
        if there != Some(bind.kind) {
            let there = there.map_or_else(|| "a kind no kernel here binds".into(), |k| format!("{k:?}"));
            return mismatch(bind.name.into(), format!("{:?}", bind.kind), there);
        }
        if let Some((what, rust, wgsl)) = structure(&module, global, bind) {
            return mismatch(what, rust, wgsl);
        }
    }
    if let Some(((group, binding), global)) = used.first_key_value() {
        let name = global.name.clone().unwrap_or_default();
        return mismatch(format!("@group({group}) @binding({binding})"), "nothing declared".into(), name);
    }
    Ok(())
}

fn kind(module: &naga::Module, global: &naga::GlobalVariable) -> Option<BindKind> {
    match global.space {
        AddressSpace::Uniform => Some(BindKind::Uniform),
        AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Some(BindKind::Storage),
        AddressSpace::Storage { .. } => Some(BindKind::StorageRead),
        AddressSpace::Handle => match module.types[global.ty].inner {
            TypeInner::Image { dim: naga::ImageDimension::D2, arrayed, class } => match class {
                ImageClass::Sampled { kind: ScalarKind::Float, multi: false } => {
                    Some(BindKind::TextureFloat { array: arrayed })
                }
                ImageClass::Sampled { kind: ScalarKind::Uint, multi: false } if !arrayed => {
                    Some(BindKind::TextureUint)
                }
                ImageClass::Storage { format, access } if access == StorageAccess::STORE && !arrayed => {
                    storage_format(format).map(BindKind::StorageTexture)
                }
                _ => None,
            },
            _ => None,
        },
        _ => None,
    }
}

fn storage_format(format: naga::StorageFormat) -> Option<wgpu::TextureFormat> {
    use naga::StorageFormat as From;
    use wgpu::TextureFormat as To;
    Some(match format {
        From::R32Uint => To::R32Uint,
        From::R32Float => To::R32Float,
        From::Rg32Uint => To::Rg32Uint,
        From::Rgba16Float => To::Rgba16Float,
        From::Rgba32Uint => To::Rgba32Uint,
        From::Rgba32Float => To::Rgba32Float,
        From::Rgba8Unorm => To::Rgba8Unorm,
        _ => return None,
    })
}

/// The first field that differs, as (what, Rust's offset, WGSL's offset).
fn structure(
    module: &naga::Module,
    global: &naga::GlobalVariable,
    bind: &Bind,
) -> Option<(String, String, String)> {
    let declared = bind.structure?;
    let mut ty = global.ty;
    let mut stride = None;
    if let TypeInner::Array { base, stride: bytes, .. } = module.types[ty].inner {
        ty = base;
        stride = Some(bytes);
    }
    let TypeInner::Struct { members, span } = &module.types[ty].inner else {
        return Some((bind.name.into(), format!("struct {}", declared.name), "no struct".into()));
    };
    let name = module.types[ty].name.as_deref().unwrap_or("");
    if name != declared.name {
        return Some((bind.name.into(), format!("struct {}", declared.name), format!("struct {name}")));
    }
    let field = |field: &str| format!("{}.{field}", declared.name);
    let mut wgsl = members.iter();
    for (rust_name, offset) in declared.fields.iter().filter(|(name, _)| !name.starts_with('_')) {
        let Some(member) = wgsl.find(|m| !m.name.as_deref().unwrap_or("_").starts_with('_')) else {
            return Some((field(rust_name), format!("offset {offset}"), "no such field".into()));
        };
        let there = format!("{} at offset {}", member.name.as_deref().unwrap_or(""), member.offset);
        let here = format!("{rust_name} at offset {offset}");
        if there != here {
            return Some((field(rust_name), here, there));
        }
    }
    if let Some(extra) = wgsl.find(|m| !m.name.as_deref().unwrap_or("_").starts_with('_')) {
        let name = extra.name.as_deref().unwrap_or("");
        return Some((field(name), "no such field".into(), format!("offset {}", extra.offset)));
    }
    // Elements of an array must be as far apart; a lone struct is bound in units of 16 bytes.
    let (here, there) = match stride {
        Some(stride) => (declared.size, stride as usize),
        None => (declared.size.next_multiple_of(16), span.next_multiple_of(16) as usize),
    };
    (here != there).then(|| (declared.name.into(), format!("{here} bytes"), format!("{there} bytes")))
}
