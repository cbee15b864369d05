// A path between two segments, where its light goes, and what happens at a surface. Needs frame, surface, brdf, noise,
// lights, sky, a snippet with `Pixel`, and what the traced structure defines: `hit_trace(origin, direction, distance,
// own)`, `hit_blocked` with the same arguments, `hit_start`, `hit_starts_from`, `hit_leave`, `hit_leaves`, `hit_pass`,
// `hit_is_emitter`, and `Hit` with `found`, `distance`, `surface`, `front` (met from its front side), `face` (towards the
// ray) and `own` (what a ray leaves that stays on this side).

struct Path {
    // Where the next segment starts, world, m.
    origin: vec3f,
    state: u32,
    // Unit.
    direction: vec3f,
    // Length so far of the first segment, m: a pane passed on the way lengthens it.
    first_distance: f32,
    throughput: vec3f,
    // The surface left, as the structure names it.
    own_x: u32,
    // Of the solid the path is in, 1/m; zero outside.
    absorption: vec3f,
    own_y: u32,
    // Of the direction, lobe's choice included, 1/sr; LIGHT_CERTAIN where no light sample could have taken it.
    pdf: f32,
    // The side of a voxel that the path ended at and may renew, from 1; 0 = none. And the face it came in through.
    feed: u32,
    feed_entry: u32,
}

fn path_leaves(path: ptr<function, Path>, own: vec2u) {
    (*path).own_x = own.x;
    (*path).own_y = own.y;
}

// What the scene has; what it has not costs no instruction.
override path_lights = true;
// Emitters, or a sky worth aiming at.
override path_areas = true;
override path_specular = true;
override path_transmission = true;
override path_coverage = true;
// What a first hit reflects takes its base colour, whatever it is made of: the picture is light times albedo.
override path_one_lobe = false;
// Voxels keep radiance, and paths read it.
override path_cache = false;
// Panes, cut-outs, blends and cells of the surface left that one ray may pass.
override path_passes = 16u;

// Bits of `state`; the number of scatterings so far stands above them.
const PATH_ALIVE = 1u;
const PATH_SPECULAR = 2u;
const PATH_INSIDE = 4u;
// The first segment's length has not been noted yet.
const PATH_FIRST = 8u;
const PATH_BOUNCE_SHIFT = 8u;

// A ray that leaves no surface the structure knows.
const PATH_NO_OWN = vec2u(0xffffffffu);

@group(1) @binding(30) var<storage, read_write> paths: array<Path>;
// Where light is summed up; `Pixel` begins with the fields of pixel.inc.wgsl.
@group(1) @binding(31) var<storage, read_write> pixels: array<Pixel>;
// Pairs (low, high word) in the order of the tally; then a word that stays 0 where no path is left alive.
@group(1) @binding(33) var<storage, read_write> counters: array<atomic<u32>>;
const PATH_ANY_ALIVE = 10u;

const TALLY_RAYS = 0u;
const TALLY_CUT = 1u;
const TALLY_ITERATIONS = 2u;
const TALLY_PATHS = 3u;
const TALLY_COUNT = 4u;
var<workgroup> tally: array<atomic<u32>, TALLY_COUNT>;

// The path renews a voxel, and offers to renew no other.
var<private> path_is_feeding: bool;
// Its blocks of random numbers are none of those that the path drew before it ended, for some of these decided that it does.
const PATH_FEED_BLOCK = 0x18000000u;
const PATH_FEED_RAYS = 12u;

// Place of a pixel's path and sums: rows from `first_row` on are in the buffers.
fn path_index(id: vec2u) -> u32 {
    return id.y * frame.trace_size.x + id.x;
}

// Adds the workgroup's tally to the 64-bit counters. Every invocation of the group calls it once, at the end.
fn path_count(local: u32) {
    workgroupBarrier();
    if (local < TALLY_COUNT) {
        let add = atomicLoad(&tally[local]);
        if (add > 0u) {
            let before = atomicAdd(&counters[2u * local], add);
            if (before + add < before) {
                atomicAdd(&counters[2u * local + 1u], 1u);
            }
        }
    }
}

// Adds the tally's rays to those that renew voxels.
fn path_count_feed(local: u32) {
    if (local == TALLY_RAYS) {
        let add = atomicLoad(&tally[TALLY_RAYS]);
        let before = atomicAdd(&counters[PATH_FEED_RAYS], add);
        if (before + add < before) {
            atomicAdd(&counters[PATH_FEED_RAYS + 1u], 1u);
        }
    }
}

// A surface without what the scene does not have: fields become constants, and what depends on them goes.
fn path_surface(stored: Surface) -> Surface {
    var s = stored;
    if (!path_specular) {
        s.f0 = 0.0;
        s.f90 = 0.0;
        s.metalness = 0.0;
    }
    if (!path_transmission) {
        s.transmission = 0.0;
        s.thin = false;
    }
    if (!path_coverage) {
        s.coverage = 1.0;
    }
    return s;
}

// Probability of starting in the diffuse lobe: by luminance, kept in 0.1..0.9 where both lobes are there.
fn path_diffuse_probability(diffuse: vec3f, specular: vec3f, has_specular: bool) -> f32 {
    let d = brdf_luminance(diffuse);
    if (!has_specular) {
        return 1.0;
    }
    if (d <= 0.0) {
        return 0.0;
    }
    return clamp(d / (d + brdf_luminance(specular)), 0.1, 0.9);
}

// The surface with its diffuse modulator left out: f_d / M_d.
fn path_demodulated(surface: Surface) -> Surface {
    var s = surface;
    s.base = vec3f(1.0);
    s.metalness = 0.0;
    s.transmission = 0.0;
    return s;
}

struct PathScatter {
    wi: vec3f,
    // f cos / p, over M_d for a diffuse sample.
    weight: vec3f,
    // 1/sr; LIGHT_CERTAIN where light samples do not go.
    pdf: f32,
    // Probability of the choice between reflection and transmission; part of the weight.
    branch: f32,
    transmitted: bool,
    valid: bool,
}

fn path_scatter(surface: Surface, wo: vec3f, face: vec3f, specular: bool, u: vec3f, inside: bool) -> PathScatter {
    var sample: BrdfSample;
    if (path_specular && specular) {
        sample = brdf_sample_specular(surface, wo, u, inside);
    } else {
        sample = brdf_sample_diffuse(path_demodulated(surface), wo, u.xy);
    }
    // A normal map can aim a reflection below the surface, where there is no light to be had.
    let below = !sample.transmitted && dot(sample.wi, face) <= 0.0;
    let pdf = select(sample.pdf, LIGHT_CERTAIN, sample.delta || sample.transmitted);
    return PathScatter(sample.wi, sample.weight, pdf, sample.branch, sample.transmitted, sample.valid && !below);
}

// What a structure can say of a shadow ray without looking at surfaces.
const PATH_FREE = 0u;
const PATH_BLOCKED = 1u;
// Something lies there that may let light through, or the structure cannot say.
const PATH_SHEETS = 2u;

// Share of light that arrives along a shadow ray: cut-outs, blends and thin panes let theirs through. Each moves the ray a
// little, so that it may meet the `emitter` within the distance: then it has arrived.
fn path_visibility(from_point: vec3f, wi: vec3f, distance: f32, leaves: vec2u, emitter: vec2u) -> vec3f {
    let blocked = hit_blocked(from_point, wi, distance, leaves);
    if (blocked != PATH_SHEETS) {
        return vec3f(select(0.0, 1.0, blocked == PATH_FREE));
    }
    var visibility = vec3f(1.0);
    var origin = from_point;
    var left = distance;
    var own = leaves;
    for (var passed = 0u; passed < path_passes; passed += 1u) {
        let hit = hit_trace(origin, wi, left, own);
        if (!hit.found || hit_is_emitter(hit, emitter)) {
            return visibility;
        }
        let s = path_surface(hit.surface);
        origin = hit_pass(origin + hit.distance * wi, hit, wi);
        left -= hit.distance;
        own = hit_leaves(hit, wi);
        var through = vec3f(1.0 - s.coverage);
        if (s.thin && s.transmission > 0.0) {
            let facet = brdf_facet(s, min(abs(dot(s.normal, wi)), 1.0), false);
            through += s.coverage * facet.transmitted;
        }
        visibility *= through;
        if (max(visibility.x, max(visibility.y, visibility.z)) <= 0.0) {
            return vec3f(0.0);
        }
    }
    return vec3f(0.0);
}

// What one shadow ray finds, times f cos, per lobe: x diffuse over M_d, y specular.
struct PathLight {
    diffuse: vec3f,
    specular: vec3f,
}

// Share of a sample that could as well have come from the other density: power heuristic.
fn path_share(own: f32, other: f32) -> f32 {
    let ratio = min(other / max(own, 1e-12), 1e15);
    return 1.0 / (1.0 + ratio * ratio);
}

// `q`: probability with which a path goes on in the diffuse lobe. After brdf_look.
fn path_light(surface: Surface, wo: vec3f, face: vec3f, sample: LightSample, origin: vec3f, own: vec2u, q: f32, inside: bool) -> PathLight {
    let cosine = dot(surface.normal, sample.wi);
    // Seen from below its shading normal's horizon a surface is black, as for the samples of its lobes.
    if (min(cosine, dot(surface.normal, wo)) < BRDF_LEAST_COSINE || dot(face, sample.wi) <= 0.0 || max(sample.irradiance.x, max(sample.irradiance.y, sample.irradiance.z)) <= 0.0) {
        return PathLight(vec3f(0.0), vec3f(0.0));
    }
    atomicAdd(&tally[TALLY_RAYS], 1u);
    let arriving = sample.irradiance * cosine * path_visibility(origin, sample.wi, sample.distance, own, sample.emitter);
    let value = brdf_eval_side(surface, wo, sample.wi, inside);
    let specular = value.specular * path_share(sample.pdf, (1.0 - q) * value.pdf_specular);
    let diffuse = value.lambert * path_share(sample.pdf, q * cosine / BRDF_PI);
    return PathLight(arriving * diffuse, arriving * specular);
}

// Blocks of random numbers for what path_area_sample draws; scatterings end below them.
const PATH_AREA_BLOCK = 0x20000000u;

// A point of an emitter, or a direction of the sky, as seen from `from`.
fn path_area_sample(from_point: vec3f, own: vec2u, pixel: vec2u, serial: u32, block: u32) -> LightSample {
    let u = noise_at(pixel, serial, PATH_AREA_BLOCK + block);
    let v = noise_at(pixel, serial, 2u * PATH_AREA_BLOCK + block);
    var sample: LightSample;
    if (u.x < params.emitter_share) {
        let index = min(u32(u.y * f32(params.emitter_count)), params.emitter_count - 1u);
        let at = LIGHT_VECTORS * params.lights_stored;
        var emitter = lights[at + index];
        if (u.z >= bitcast<f32>(emitter.w)) {
            emitter = lights[at + emitter.z];
        }
        sample = hit_emitter(emitter.xy, from_point, own, v.xyz);
        sample.pdf *= params.emitter_share / params.emitter_total;
    } else {
        let sky = sky_sample(vec4f(u.yz, v.xy));
        sample = LightSample(sky.direction, 4.0 * frame.diagonal, sky_radiance(sky.direction), sky.pdf * params.sky_share, LIGHT_NO_EMITTER);
    }
    sample.irradiance = select(vec3f(0.0), sample.irradiance / max(sample.pdf, 1e-20), sample.pdf > 0.0);
    return sample;
}

// Share of emission that belongs to a path that met it, `pdf` the one of its direction. The rest is the light samples'.
fn path_emitter_share(hit: Hit, from_point: vec3f, direction: vec3f, distance: f32, pdf: f32) -> f32 {
    if (!path_areas || params.emitter_share == 0.0) {
        return 1.0;
    }
    return path_share(pdf, hit_emitter_pdf(hit, from_point, direction, distance) * params.emitter_share / params.emitter_total);
}

fn path_sky_share(direction: vec3f, pdf: f32) -> f32 {
    if (!path_areas || params.sky_share == 0.0) {
        return 1.0;
    }
    return path_share(pdf, sky_pdf(direction) * params.sky_share);
}

// Who gets how many samples.
const PATH_BY_ROUGHNESS = 1u;
const PATH_BY_VARIANCE = 2u;

// The paper's "maximum of six" for the roughest.
fn path_roughness_samples(surface: Surface) -> u32 {
    let rougher = max(surface.roughness.x, surface.roughness.y);
    return clamp(1u + u32(5.0 * rougher + 0.5), 1u, 6u);
}
