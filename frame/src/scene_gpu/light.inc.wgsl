// Light that is no surface. The sun, if there is one, is the first. Kinds and units: lights.rs beside this file.

const LIGHT_SUN = 0u;
const LIGHT_DIRECTIONAL = 1u;
const LIGHT_POINT = 2u;
const LIGHT_SPOT = 3u;

struct Light {
  position: vec3f,  // m; of a point or a spot
  kind: u32,
  direction: vec3f, // unit, the way the light travels; not of a point
  range: f32,       // m, beyond which a point or a spot gives nothing; 1e18 where unlimited
  intensity: vec3f, // times radiance_scale: W/m^2 facing a sun or directional light, W/sr of a point or a spot
  cos_inner: f32,   // a spot's bright core; for a sun the cosine of half the disc's angle
  cos_outer: f32,   // a spot's edge
};

// Four vectors per light, in the order of the fields; whoever binds it may append what it likes.
@group(1) @binding(15) var<storage, read> lights: array<vec4u>;

const LIGHT_VECTORS = 4u;

fn light_at(index: u32) -> Light {
  let at = LIGHT_VECTORS * index;
  let a = lights[at];
  let b = bitcast<vec4f>(lights[at + 1u]);
  let c = bitcast<vec4f>(lights[at + 2u]);
  let d = bitcast<vec4f>(lights[at + 3u]);
  return Light(bitcast<vec3f>(a.xyz), a.w, b.xyz, b.w, c.xyz, c.w, d.x);
}
