// What a point of a triangle is made of, after surface, brdf and mesh. Units and formulas: materials.rs beside this file.

@group(1) @binding(2) var<storage, read> materials: array<Material>;
@group(1) @binding(3) var textures_srgb_128: texture_2d_array<f32>;
@group(1) @binding(4) var textures_srgb_256: texture_2d_array<f32>;
@group(1) @binding(5) var textures_srgb_512: texture_2d_array<f32>;
@group(1) @binding(6) var textures_srgb_1024: texture_2d_array<f32>;
@group(1) @binding(7) var textures_srgb_2048: texture_2d_array<f32>;
@group(1) @binding(8) var textures_linear_128: texture_2d_array<f32>;
@group(1) @binding(9) var textures_linear_256: texture_2d_array<f32>;
@group(1) @binding(10) var textures_linear_512: texture_2d_array<f32>;
@group(1) @binding(11) var textures_linear_1024: texture_2d_array<f32>;
@group(1) @binding(12) var textures_linear_2048: texture_2d_array<f32>;

struct MaterialSlot {
  to_u: vec3f,  // dot with (u, v, 1) gives the transformed u
  texture: u32, // bits: array 4, layer 8, last mip 4, uv set 1, linear 1, wrap of u 2, wrap of v 2
  to_v: vec3f,
  size: u32,    // texels of mip 0: width | height << 16
};

struct Material {
  base: vec4f,
  emission: vec3f,   // times radiance_scale
  cutoff: f32,       // of a mask
  absorption: vec3f, // 1/m
  metalness: f32,
  anisotropy: vec3f, // cosine and sine of the rotation, strength
  roughness: f32,
  f0: f32,
  transmission: f32,
  normal_scale: f32,
  flags: u32,        // MATERIAL_*, and from bit 8 on which slots are used
  f90: f32,
  glow: f32,         // mean luminance of the emission
  slots: array<MaterialSlot, 8>,
};

const MATERIAL_MASK = 1u;
const MATERIAL_BLEND = 2u;
const MATERIAL_TWO_SIDED = 4u;
const MATERIAL_THIN = 8u;
const MATERIAL_UNLIT = 16u;

// Bits of the slots in `flags`; the numbers are the order of `scene::Material::textures`.
const MATERIAL_SLOT_BASE = 0u;
const MATERIAL_SLOT_METALLIC_ROUGHNESS = 1u;
const MATERIAL_SLOT_NORMAL = 2u;
const MATERIAL_SLOT_EMISSION = 3u;
const MATERIAL_SLOT_TRANSMISSION = 4u;
const MATERIAL_SLOT_SPECULAR = 5u;
const MATERIAL_SLOT_SPECULAR_COLOR = 6u;
const MATERIAL_SLOT_ANISOTROPY = 7u;

fn material_has_slot(flags: u32, slot: u32) -> bool {
  return ((flags >> (8u + slot)) & 1u) == 1u;
}

// ---- textures ----

// Bit i: some material reads array i. Drivers that run all branches under a mask are spared the others.
override material_arrays: u32 = 0x3ffu;

fn material_reads(array: u32) -> bool {
  return ((material_arrays >> array) & 1u) == 1u;
}

fn material_texel(array: u32, at: vec2i, layer: u32, level: u32) -> vec4f {
  var texel = vec4f(1.0);
  switch (array) {
    case 0u: { if (material_reads(0u)) { texel = textureLoad(textures_srgb_128, at, layer, level); } }
    case 1u: { if (material_reads(1u)) { texel = textureLoad(textures_srgb_256, at, layer, level); } }
    case 2u: { if (material_reads(2u)) { texel = textureLoad(textures_srgb_512, at, layer, level); } }
    case 3u: { if (material_reads(3u)) { texel = textureLoad(textures_srgb_1024, at, layer, level); } }
    case 4u: { if (material_reads(4u)) { texel = textureLoad(textures_srgb_2048, at, layer, level); } }
    case 5u: { if (material_reads(5u)) { texel = textureLoad(textures_linear_128, at, layer, level); } }
    case 6u: { if (material_reads(6u)) { texel = textureLoad(textures_linear_256, at, layer, level); } }
    case 7u: { if (material_reads(7u)) { texel = textureLoad(textures_linear_512, at, layer, level); } }
    case 8u: { if (material_reads(8u)) { texel = textureLoad(textures_linear_1024, at, layer, level); } }
    default: { if (material_reads(9u)) { texel = textureLoad(textures_linear_2048, at, layer, level); } }
  }
  return texel;
}

// A texel index brought back into 0..size: 0 repeat, 1 mirror, 2 clamp. Repeat and mirror need i >= -2 size.
fn material_wrap(i: i32, size: i32, mode: u32) -> i32 {
  let clamped = clamp(i, 0, size - 1);
  let repeated = (i + 2 * size) % size;
  let folded = (i + 2 * size) % (2 * size);
  let mirrored = select(2 * size - 1 - folded, folded, folded < size);
  return select(select(clamped, mirrored, mode == 1u), repeated, mode == 0u);
}

// A slot's texture at a point, seen through a footprint of `area` m^2: bilinear in the mip whose texels come nearest to
// the footprint, or its nearest texel. An area of 0 reads mip 0.
fn material_lookup(slot: MaterialSlot, point: MeshPoint, area: f32, nearest: bool) -> vec4f {
  let second = ((slot.texture >> 16u) & 1u) == 1u;
  let uvw = vec3f(select(point.uv0, point.uv1, second), 1.0);
  var uv = vec2f(dot(slot.to_u, uvw), dot(slot.to_v, uvw));
  let modes = vec2u(slot.texture >> 18u, slot.texture >> 20u) & vec2u(3u);
  // Two is the period of repeat and mirror alike; it keeps integers small and leaves the fraction exact.
  uv = select(uv - 2.0 * floor(0.5 * uv), clamp(uv, vec2f(-1.0), vec2f(2.0)), modes == vec2u(2u));

  let size = vec2u(slot.size & 0xffffu, slot.size >> 16u);
  let density = select(point.uv_density.x, point.uv_density.y, second) * abs(slot.to_u.x * slot.to_v.y - slot.to_u.y * slot.to_v.x);
  let texels = clamp(area * density * f32(size.x * size.y), 1.0, 1e9);
  let level = min(u32(0.5 * log2(texels) + 0.5), (slot.texture >> 12u) & 15u);

  let level_size = max(size >> vec2u(level), vec2u(1u));
  let is_point = nearest || ((slot.texture >> 17u) & 1u) == 0u;
  let at = uv * vec2f(level_size) - select(0.5, 0.0, is_point);
  let low = floor(at);
  let w = select(at - low, vec2f(0.0), is_point);
  var sum = vec4f(0.0);
  // A loop, so that the choice among ten textures is compiled once.
  for (var tap = 0u; tap < select(4u, 1u, is_point); tap += 1u) {
    let corner = vec2u(tap & 1u, tap >> 1u);
    let i = vec2i(low) + vec2i(corner);
    let size_i = vec2i(level_size);
    let texel = vec2i(material_wrap(i.x, size_i.x, modes.x), material_wrap(i.y, size_i.y, modes.y));
    let share = select(1.0 - w, w, corner == vec2u(1u));
    sum += share.x * share.y * material_texel(slot.texture & 15u, texel, (slot.texture >> 4u) & 255u, level);
  }
  return sum;
}

// ---- opacity ----

// Whether `material_opacity` can be below 1.
fn material_is_cut(material: u32) -> bool {
  return (materials[material].flags & (MATERIAL_MASK | MATERIAL_BLEND)) != 0u;
}

// 1 where there is something, 0 in the hole of a mask (its nearest texel), the alpha of a blend.
fn material_opacity(material: u32, point: MeshPoint, area: f32) -> f32 {
  if (!material_is_cut(material)) {
    return 1.0;
  }
  let flags = materials[material].flags;
  let is_mask = (flags & MATERIAL_MASK) != 0u;
  var alpha = materials[material].base.a * point.color.a;
  if (material_has_slot(flags, MATERIAL_SLOT_BASE)) {
    alpha *= material_lookup(materials[material].slots[MATERIAL_SLOT_BASE], point, area, is_mask).a;
  }
  return select(alpha, select(0.0, 1.0, alpha >= materials[material].cutoff), is_mask);
}

// ---- emission ----

// What the front side emits, times radiance_scale.
fn material_emission(material: u32, point: MeshPoint) -> vec3f {
  let flags = materials[material].flags;
  var emission = materials[material].emission;
  if (material_has_slot(flags, MATERIAL_SLOT_EMISSION)) {
    emission *= material_lookup(materials[material].slots[MATERIAL_SLOT_EMISSION], point, 0.0, false).rgb;
  }
  if ((flags & MATERIAL_UNLIT) != 0u) {
    emission *= materials[material].base.rgb * point.color.rgb;
    if (material_has_slot(flags, MATERIAL_SLOT_BASE)) {
      emission *= material_lookup(materials[material].slots[MATERIAL_SLOT_BASE], point, 0.0, false).rgb;
    }
  }
  return emission;
}

// ---- the surface ----

// Seen through a footprint of `area` m^2. The normal is on the front side, emission is the front face's. Coverage is the
// share of the footprint that a mask leaves, or the alpha of a blend.
fn material_surface(material: u32, point: MeshPoint, area: f32) -> Surface {
  let flags = materials[material].flags;
  var base = materials[material].base * point.color;
  var emission = materials[material].emission;
  var metalness = materials[material].metalness;
  var roughness = materials[material].roughness;
  var f0 = materials[material].f0;
  var f90 = materials[material].f90;
  var transmission = materials[material].transmission;
  var mapped = vec3f(0.0, 0.0, 1.0);
  var anisotropy = vec3f(1.0, 0.0, materials[material].anisotropy.z);

  var remaining = flags >> 8u;
  for (var slot = 0u; slot < 8u && remaining != 0u; slot += 1u) {
    if ((remaining & 1u) == 1u) {
      let value = material_lookup(materials[material].slots[slot], point, area, false);
      switch (slot) {
        case MATERIAL_SLOT_BASE: { base *= value; }
        case MATERIAL_SLOT_METALLIC_ROUGHNESS: { roughness *= value.g; metalness *= value.b; }
        case MATERIAL_SLOT_NORMAL: { mapped = 2.0 * value.rgb - 1.0; }
        case MATERIAL_SLOT_EMISSION: { emission *= value.rgb; }
        case MATERIAL_SLOT_TRANSMISSION: { transmission *= value.r; }
        case MATERIAL_SLOT_SPECULAR: { f0 *= value.a; f90 *= value.a; }
        case MATERIAL_SLOT_SPECULAR_COLOR: { f0 *= brdf_luminance(value.rgb); }
        default: { anisotropy = vec3f(2.0 * value.rg - 1.0, anisotropy.z * value.b); }
      }
    }
    remaining >>= 1u;
  }

  var s: Surface;
  let frame_normal = point.normal;
  let tangent = material_perpendicular(point.tangent.xyz, frame_normal);
  let bitangent = cross(frame_normal, tangent) * point.tangent.w;
  mapped = vec3f(mapped.xy * materials[material].normal_scale, mapped.z);
  let bent = mapped.x * tangent + mapped.y * bitangent + mapped.z * frame_normal;
  let bent_length = length(bent);
  s.normal = select(frame_normal, bent / max(bent_length, 1e-6), bent_length > 1e-6);

  // The anisotropy texture's direction, turned by the material's rotation, in the plane of the tangents.
  let turn = materials[material].anisotropy.xy;
  let along = vec2f(turn.x * anisotropy.x - turn.y * anisotropy.y, turn.y * anisotropy.x + turn.x * anisotropy.y);
  s.tangent = material_perpendicular(along.x * tangent + along.y * bitangent, s.normal);
  s.handedness = point.tangent.w;
  // KHR_materials_anisotropy: alpha along the tangent is mix(alpha, 1, strength^2).
  let alpha = roughness * roughness;
  s.roughness = vec2f(sqrt(mix(alpha, 1.0, anisotropy.z * anisotropy.z)), roughness);

  let unlit = (flags & MATERIAL_UNLIT) != 0u;
  s.base = select(base.rgb, vec3f(0.0), unlit);
  s.emission = select(emission, emission * base.rgb, unlit);
  s.metalness = metalness;
  s.absorption = materials[material].absorption;
  s.f0 = f0;
  s.f90 = f90;
  s.transmission = transmission;
  s.coverage = 1.0;
  if (material_is_cut(material)) {
    // The alpha of a mask's texture is 0 or 1 in mip 0, so that it is the covered share in every other.
    let cut = (flags & MATERIAL_MASK) != 0u && !material_has_slot(flags, MATERIAL_SLOT_BASE);
    s.coverage = select(base.a, select(0.0, 1.0, base.a >= materials[material].cutoff), cut);
  }
  s.contour = 0.0;
  s.two_sided = (flags & MATERIAL_TWO_SIDED) != 0u;
  s.thin = (flags & MATERIAL_THIN) != 0u;
  return s;
}

// The part of a vector across a unit normal, unit length; any perpendicular where there is none.
fn material_perpendicular(v: vec3f, normal: vec3f) -> vec3f {
  let across = v - dot(v, normal) * normal;
  let across_length = length(across);
  let axis = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(normal.x) > 0.7);
  return select(normalize(cross(axis, normal)), across / max(across_length, 1e-6), across_length > 1e-6);
}

// A surface as seen from behind: nothing emitted, the tangent frame turned over.
fn material_turn(surface: Surface) -> Surface {
  var s = surface;
  s.normal = -s.normal;
  s.handedness = -s.handedness;
  s.emission = vec3f(0.0);
  return s;
}

const MATERIAL_LEAST_COSINE = 0.01;

// A normal map can turn a normal away from the viewer `wo`, where no light is defined: it is bent back until it just
// faces wo.
fn material_bend(normal: vec3f, wo: vec3f) -> vec3f {
  let cosine = dot(normal, wo);
  if (cosine >= MATERIAL_LEAST_COSINE) {
    return normal;
  }
  return normalize(normal + (MATERIAL_LEAST_COSINE - cosine) * wo);
}
