// Directions in proportion to the sky's light. Format of a texel and formulas: sky_table.rs beside this file.

@group(1) @binding(19) var sky_table: texture_2d<f32>;

const SKY_TABLE_PI = 3.14159265358979323846;

struct SkySample {
  direction: vec3f,
  pdf: f32, // 1/sr
};

fn sky_table_texel(index: u32, size: vec2u) -> vec4f {
  return textureLoad(sky_table, vec2u(index % size.x, index / size.x), 0);
}

// u.x, u.y choose the cell, u.zw the place in it.
fn sky_sample(u: vec4f) -> SkySample {
  let size = textureDimensions(sky_table);
  let count = size.x * size.y;
  var index = min(u32(u.x * f32(count)), count - 1u);
  var texel = sky_table_texel(index, size);
  if (u.y >= texel.y) {
    index = u32(texel.x);
    texel = sky_table_texel(index, size);
  }
  let uv = (vec2f(vec2u(index % size.x, index / size.x)) + u.zw) / vec2f(size);
  let turn = 2.0 * SKY_TABLE_PI * uv.x;
  let down = SKY_TABLE_PI * uv.y;
  let across = max(sin(down), 1e-6);
  let direction = normalize(vec3f(across * sin(turn), cos(down), -across * cos(turn)));
  return SkySample(direction, texel.z / (2.0 * SKY_TABLE_PI * SKY_TABLE_PI * across));
}

// Density of sky_sample, 1/sr.
fn sky_pdf(direction: vec3f) -> f32 {
  let size = textureDimensions(sky_table);
  let across = length(direction.xz);
  let turns = select(0.0, atan2(direction.x, -direction.z), across > 1e-12) / (2.0 * SKY_TABLE_PI);
  let uv = vec2f(turns - floor(turns), atan2(across, direction.y) / SKY_TABLE_PI);
  let cell = min(vec2u(uv * vec2f(size)), size - 1u);
  return textureLoad(sky_table, cell, 0).z / (2.0 * SKY_TABLE_PI * SKY_TABLE_PI * max(across, 1e-6));
}
