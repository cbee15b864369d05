// Heights by material and texture coordinates. Words: heights.rs beside this file.

@group(1) @binding(21) var<storage, read> heights: array<u32>;

struct HeightMap {
  to_u: vec3f,
  to_v: vec3f,
  scale: f32, // metres over 0..1; 0 = no map
  size: vec2u,
  first: u32,
  bits: u32,
};

fn height_map(material: u32) -> HeightMap {
  let at = 12u * material;
  return HeightMap(
    bitcast<vec3f>(vec3u(heights[at], heights[at + 1u], heights[at + 2u])),
    bitcast<vec3f>(vec3u(heights[at + 3u], heights[at + 4u], heights[at + 5u])),
    bitcast<f32>(heights[at + 6u]),
    vec2u(heights[at + 7u], heights[at + 8u]),
    heights[at + 9u],
    heights[at + 10u],
  );
}

// Whether the map lies on the second texture coordinates.
fn height_uv_set(map: HeightMap) -> u32 {
  return (map.bits >> 12u) & 1u;
}

// Coordinates in the map, 0..1 once across.
fn height_place(map: HeightMap, uv: vec2f) -> vec2f {
  return vec2f(dot(map.to_u, vec3f(uv, 1.0)), dot(map.to_v, vec3f(uv, 1.0)));
}

// The mip with two to four texels in `texels` of mip 0, the step between two vertices: fine enough for slopes, coarse
// enough not to miss what lies between.
fn height_level(map: HeightMap, texels: f32) -> u32 {
  let level = floor(log2(clamp(texels, 1.0, 1e9))) - 1.0;
  return min(u32(max(level, 0.0)), map.bits & 255u);
}

// A texel index brought back into 0..size: 0 repeat, 1 mirror, 2 clamp. Repeat and mirror need i >= -2 size.
fn height_wrap(i: i32, size: i32, mode: u32) -> i32 {
  let clamped = clamp(i, 0, size - 1);
  let repeated = (i + 2 * size) % size;
  let folded = (i + 2 * size) % (2 * size);
  let mirrored = select(2 * size - 1 - folded, folded, folded < size);
  return select(select(clamped, mirrored, mode == 1u), repeated, mode == 0u);
}

// First word of a mip, and its size.
struct HeightMip {
  first: u32,
  size: vec2u,
};

fn height_mip(map: HeightMap, level: u32) -> HeightMip {
  var mip = HeightMip(map.first, map.size);
  for (var i = 0u; i < 16u; i += 1u) {
    if (i < level) {
      mip.first += mip.size.x * mip.size.y;
      mip.size = max(mip.size / 2u, vec2u(1u));
    }
  }
  return mip;
}

// Bilinear in a mip, metres.
fn height_bilinear(map: HeightMap, mip: HeightMip, place: vec2f) -> f32 {
  let modes = vec2u(map.bits >> 8u, map.bits >> 10u) & vec2u(3u);
  // Two is the period of repeat and mirror alike; it keeps integers small and leaves the fraction exact.
  let wrapped = select(place - 2.0 * floor(0.5 * place), clamp(place, vec2f(-1.0), vec2f(2.0)), modes == vec2u(2u));
  let at = wrapped * vec2f(mip.size) - vec2f(0.5);
  let low = vec2i(floor(at));
  let part = at - floor(at);
  let size = vec2i(mip.size);
  let x0 = height_wrap(low.x, size.x, modes.x);
  let x1 = height_wrap(low.x + 1, size.x, modes.x);
  let y0 = height_wrap(low.y, size.y, modes.y) * size.x;
  let y1 = height_wrap(low.y + 1, size.y, modes.y) * size.x;
  let top = mix(height_texel(mip, x0 + y0), height_texel(mip, x1 + y0), part.x);
  let bottom = mix(height_texel(mip, x0 + y1), height_texel(mip, x1 + y1), part.x);
  return map.scale * mix(top, bottom, part.y);
}

fn height_texel(mip: HeightMip, index: i32) -> f32 {
  return bitcast<f32>(heights[mip.first + u32(index)]);
}

// Metres, and their slopes along the map's u and v, by central differences of one texel.
fn height_with_slopes(map: HeightMap, level: u32, place: vec2f) -> vec3f {
  let mip = height_mip(map, level);
  let texel = 1.0 / vec2f(mip.size);
  let du = vec2f(texel.x, 0.0);
  let dv = vec2f(0.0, texel.y);
  return vec3f(
    height_bilinear(map, mip, place),
    0.5 * f32(mip.size.x) * (height_bilinear(map, mip, place + du) - height_bilinear(map, mip, place - du)),
    0.5 * f32(mip.size.y) * (height_bilinear(map, mip, place + dv) - height_bilinear(map, mip, place - dv)),
  );
}

fn height_at(map: HeightMap, level: u32, place: vec2f) -> f32 {
  return height_bilinear(map, height_mip(map, level), place);
}
