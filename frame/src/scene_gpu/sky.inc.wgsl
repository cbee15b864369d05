// Light from infinitely far, by direction: the twin of `scene::Sky::radiance`.

@group(1) @binding(13) var sky_map: texture_2d<f32>; // equirectangular radiance times radiance_scale; 1 x 1 = constant

fn sky_texel(column: i32, row: i32, size: vec2i) -> vec3f {
  let wrapped = column + select(0, size.x, column < 0) - select(0, size.x, column >= size.x);
  return textureLoad(sky_map, vec2i(wrapped, clamp(row, 0, size.y - 1)), 0).rgb;
}

// Radiance from this unit direction, times radiance_scale. Bilinear: columns wrap, rows stop at the poles.
fn sky_radiance(direction: vec3f) -> vec3f {
  let size = vec2i(textureDimensions(sky_map));
  if (size.x == 1 && size.y == 1) {
    return textureLoad(sky_map, vec2i(0), 0).rgb;
  }
  // Straight up and down have no azimuth, and atan2 of two zeros has no value.
  let across = length(direction.xz);
  let turns = select(0.0, atan2(direction.x, -direction.z), across > 1e-12) / 6.28318530717958647692;
  let down = atan2(across, direction.y) / 3.14159265358979323846;
  let at = vec2f(turns, down) * vec2f(size) - 0.5;
  let low = floor(at);
  let w = at - low;
  let i = vec2i(low) + vec2i(select(0, size.x, low.x < 0.0), 0);
  let row_0 = mix(sky_texel(i.x, i.y, size), sky_texel(i.x + 1, i.y, size), w.x);
  let row_1 = mix(sky_texel(i.x, i.y + 1, size), sky_texel(i.x + 1, i.y + 1, size), w.x);
  return mix(row_0, row_1, w.y);
}
