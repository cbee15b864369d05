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

// The mip with about two texels (1.4 to 2.8) in `texels` of mip 0, the step between two vertices: fine enough for slopes,
// coarse enough not to miss what lies between.
fn height_level(map: HeightMap, texels: f32) -> u32 {
  let level = floor(log2(clamp(texels, 1.0, 1e9)) - 0.5);
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

// Where a place lies in a mip: the texel up and left of it, and how far between that and the next.
struct HeightCell {
  low: vec2i,
  part: vec2f,
}

fn height_cell(map: HeightMap, mip: HeightMip, place: vec2f) -> HeightCell {
  let modes = height_modes(map);
  // Two is the period of repeat and mirror alike; it keeps integers small and leaves the fraction exact.
  let wrapped = select(place - 2.0 * floor(0.5 * place), clamp(place, vec2f(-1.0), vec2f(2.0)), modes == vec2u(2u));
  let at = wrapped * vec2f(mip.size) - vec2f(0.5);
  return HeightCell(vec2i(floor(at)), at - floor(at));
}

fn height_modes(map: HeightMap) -> vec2u {
  return vec2u(map.bits >> 8u, map.bits >> 10u) & vec2u(3u);
}

// 0..1.
fn height_texel(map: HeightMap, mip: HeightMip, at: vec2i) -> f32 {
  let modes = height_modes(map);
  let size = vec2i(mip.size);
  let index = height_wrap(at.y, size.y, modes.y) * size.x + height_wrap(at.x, size.x, modes.x);
  return bitcast<f32>(heights[mip.first + u32(index)]);
}

// Bilinear in a mip, metres.
fn height_bilinear(map: HeightMap, mip: HeightMip, place: vec2f) -> f32 {
  let cell = height_cell(map, mip, place);
  var sum = 0.0;
  for (var tap = 0; tap < 4; tap += 1) {
    let corner = vec2i(tap & 1, tap >> 1u);
    let shares = select(1.0 - cell.part, cell.part, corner == vec2i(1));
    sum += shares.x * shares.y * height_texel(map, mip, cell.low + corner);
  }
  return map.scale * sum;
}

fn height_at(map: HeightMap, level: u32, place: vec2f) -> f32 {
  return height_bilinear(map, height_mip(map, level), place);
}

// Slopes along the map's u and v, metres per once across: central differences of one and two texels, mixed so that their
// errors of second order cancel. Wider ones would flatten what is fine, narrower ones would show the steps of 8 bits.
fn height_slopes(map: HeightMap, level: u32, place: vec2f) -> vec2f {
  let mip = height_mip(map, level);
  var slopes = vec2f(0.0);
  for (var i = 0u; i < 8u; i += 1u) {
    let axis = i & 1u;
    let reach = select(1.0, 2.0, (i & 2u) == 2u);
    let sign = select(-1.0, 1.0, (i & 4u) == 4u);
    let toward = select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), axis == 0u);
    let height = height_bilinear(map, mip, place + sign * reach * toward / vec2f(mip.size));
    let weight = select(2.0 / 3.0, -1.0 / 12.0, reach == 2.0);
    slopes += sign * weight * height * toward * vec2f(mip.size);
  }
  return slopes;
}
