// Random numbers without state, by one of four generators. Needs the frame uniform. See mod.rs.

const NOISE_PAPER = 0u;
const NOISE_R2_BLUE = 1u;
const NOISE_SOBOL = 2u;
const NOISE_REFERENCE = 3u;
override noise_kind = 1u;

// Where the path is, world, m: the paper's texture is looked up there.
var<private> noise_point: vec3f;

// Jarzynski and Olano 2020, "Hash Functions for GPU Rendering".
fn noise_pcg4d(input: vec4u) -> vec4u {
    var v = input * 1664525u + 1013904223u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    v ^= v >> vec4u(16u);
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    return v;
}

fn noise_unit(bits: vec4u) -> vec4f {
    return vec4f(bits >> vec4u(8u)) * (1.0 / 16777216.0);
}

fn noise_texture(pixel: vec2u, sample: u32, block: u32) -> vec4u {
    let across = (noise_point.xy + vec2f(0.7548777, 0.5698403) * noise_point.z) * (512.0 / frame.diagonal);
    let shift = noise_pcg4d(vec4u(sample, block, 0x74657875u, frame.seed)).xy;
    let texel = (vec2u(vec2i(floor(clamp(across, vec2f(-1e6), vec2f(1e6))))) + shift) & vec2u(511u);
    return noise_pcg4d(vec4u(texel, 0x6e6f6973u, 0u));
}

// A permutation that moves a bit by lower ones only (Laine and Karras 2011; constants of Vegdahl 2021).
fn noise_lower_bits(x: u32, seed: u32) -> u32 {
    var v = x ^ (x * 0x3d20adeau);
    v += seed;
    v *= (seed >> 16u) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
}

// Owen's scrambling.
fn noise_owen(x: u32, seed: u32) -> u32 {
    return reverseBits(noise_lower_bits(reverseBits(x), seed));
}

// A point of the first two dimensions of Sobol's sequence: radical inverse, and that of Pascal's triangle modulo 2.
fn noise_sobol(index: u32) -> vec2u {
    let x = reverseBits(index);
    var y = x;
    y ^= (y & 0x0000ffffu) << 16u;
    y ^= (y & 0x00ff00ffu) << 8u;
    y ^= (y & 0x0f0f0f0fu) << 4u;
    y ^= (y & 0x33333333u) << 2u;
    y ^= (y & 0x55555555u) << 1u;
    return vec2u(x, y);
}

// Two pairs, each a Sobol sequence of its own order and scrambling (Burley 2020).
fn noise_scrambled(pixel: vec2u, sample: u32, block: u32) -> vec4u {
    let seeds = noise_pcg4d(vec4u(pixel.x | (pixel.y << 16u), 0x736f626fu, block, frame.seed));
    let more = noise_pcg4d(seeds);
    let first = noise_sobol(noise_owen(sample, seeds.x));
    let second = noise_sobol(noise_owen(sample, seeds.y));
    return vec4u(
        noise_owen(first.x, seeds.z), noise_owen(first.y, seeds.w),
        noise_owen(second.x, more.x), noise_owen(second.y, more.y),
    );
}

fn noise_turn_17(x: u32) -> u32 {
    return 668265263u * ((x << 17u) | (x >> 15u));
}

// XXH32 over four words (Collet): nothing in common with the other generators.
fn noise_xxh32(key: vec4u) -> u32 {
    var h = noise_turn_17(key.w + 374761393u + 16u + key.x * 3266489917u);
    h = noise_turn_17(h + key.y * 3266489917u);
    h = noise_turn_17(h + key.z * 3266489917u);
    h = 2246822519u * (h ^ (h >> 15u));
    h = 3266489917u * (h ^ (h >> 13u));
    return h ^ (h >> 16u);
}

// Four numbers in [0, 1) with 24 bits each.
fn noise_at(pixel: vec2u, sample: u32, block: u32) -> vec4f {
    if (noise_kind == NOISE_PAPER) {
        return noise_unit(noise_texture(pixel, sample, block));
    }
    if (noise_kind == NOISE_SOBOL) {
        return noise_unit(noise_scrambled(pixel, sample, block));
    }
    let key = vec4u(pixel.x | (pixel.y << 16u), sample, block, frame.seed);
    if (noise_kind == NOISE_REFERENCE) {
        let of_channel = 4u * key.z;
        return noise_unit(vec4u(
            noise_xxh32(vec4u(key.xy, of_channel, key.w)), noise_xxh32(vec4u(key.xy, of_channel + 1u, key.w)),
            noise_xxh32(vec4u(key.xy, of_channel + 2u, key.w)), noise_xxh32(vec4u(key.xy, of_channel + 3u, key.w)),
        ));
    }
    return noise_unit(noise_pcg4d(key));
}
