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

// A texel index brought back into 0..size: 0 repeat, 1 mirror, 2 clamp. In floats, which hold these integers exactly and
// divide side by side where integers divide one by one; the half keeps quotients away from whole numbers.
fn height_wrap(i: i32, size: u32, mode: u32) -> u32 {
  let x = f32(i);
  let n = f32(size);
  let repeated = x - n * floor((x + 0.5) / n);
  let folded = x - 2.0 * n * floor((x + 0.5) / (2.0 * n));
  let mirrored = select(2.0 * n - 1.0 - folded, folded, folded < n);
  return u32(select(select(clamp(x, 0.0, n - 1.0), mirrored, mode == 1u), repeated, mode == 0u));
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

// Bilinear, metres.
fn height_at(map: HeightMap, level: u32, place: vec2f) -> f32 {
  let mip = height_mip(map, level);
  let cell = height_cell(map, mip, place);
  let modes = height_modes(map);
  var sum = 0.0;
  for (var tap = 0; tap < 4; tap += 1) {
    let corner = vec2i(tap & 1, tap >> 1u);
    let shares = select(1.0 - cell.part, cell.part, corner == vec2i(1));
    let x = height_wrap(cell.low.x + corner.x, mip.size.x, modes.x);
    let y = height_wrap(cell.low.y + corner.y, mip.size.y, modes.y);
    sum += shares.x * shares.y * bitcast<f32>(heights[mip.first + y * mip.size.x + x]);
  }
  return map.scale * sum;
}

// Slope at `part` between the third and the fourth of six texels in a row, per texel: central differences of one and two
// texels, mixed so that their errors of second order cancel. Wider ones would flatten what is fine, narrower ones would
// show the steps of 8 bits.
fn height_slope(a: vec3f, b: vec3f, part: f32) -> f32 {
  let back_two = mix(a.x, a.y, part);
  let back = mix(a.y, a.z, part);
  let ahead = mix(b.x, b.y, part);
  let ahead_two = mix(b.y, b.z, part);
  return 2.0 / 3.0 * (ahead - back) - (ahead_two - back_two) / 12.0;
}

// Slopes along the map's u and v, metres per once across.
fn height_slopes(map: HeightMap, level: u32, place: vec2f) -> vec2f {
  let mip = height_mip(map, level);
  let cell = height_cell(map, mip, place);
  let modes = height_modes(map);
  // Along u the mean of two rows, along v of two columns.
  let x0 = height_wrap(cell.low.x, mip.size.x, modes.x);
  let x1 = height_wrap(cell.low.x + 1, mip.size.x, modes.x);
  let y0 = height_wrap(cell.low.y, mip.size.y, modes.y) * mip.size.x + mip.first;
  let y1 = height_wrap(cell.low.y + 1, mip.size.y, modes.y) * mip.size.x + mip.first;
  var across: array<f32, 6>;
  var down: array<f32, 6>;
  for (var i = 0; i < 6; i += 1) {
    let x = height_wrap(cell.low.x + i - 2, mip.size.x, modes.x);
    across[i] = mix(bitcast<f32>(heights[y0 + x]), bitcast<f32>(heights[y1 + x]), cell.part.y);
    let y = height_wrap(cell.low.y + i - 2, mip.size.y, modes.y) * mip.size.x + mip.first;
    down[i] = mix(bitcast<f32>(heights[y + x0]), bitcast<f32>(heights[y + x1]), cell.part.x);
  }
  let slopes = vec2f(
    height_slope(vec3f(across[0], across[1], across[2]), vec3f(across[3], across[4], across[5]), cell.part.x),
    height_slope(vec3f(down[0], down[1], down[2]), vec3f(down[3], down[4], down[5]), cell.part.y),
  );
  return map.scale * slopes * vec2f(mip.size);
}
