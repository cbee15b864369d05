// What a ray meets in the voxel grid, for the path kernels. Needs voxel::GRID_WGSL.

struct Hit {
    found: bool,
    // m along the ray.
    distance: f32,
    // As stored; its normal may point away from the ray.
    surface: Surface,
    // Met from the side its normal is on.
    front: bool,
    // Unit, towards the ray: nothing is reflected below it. A voxel's cube says nothing about that, its surface does.
    face: vec3f,
    // Of the voxel's face that the ray entered through, towards the ray.
    entry: vec3f,
    cell: vec3i,
    // Its record's number, which is that of what is kept for it.
    record: u32,
    // Names the surface, for a ray that leaves it: normal code, and bits of normal . cell.
    own: vec2u,
    // It is the surface that the ray leaves or has just passed.
    again: bool,
}

// Off a face by this share of a voxel: enough to name the cell after rounding a position of 1,024 voxels (2^-14), too
// little to see.
const HIT_NUDGE = 1e-3;

// Normals of one surface's neighbouring voxels differ by less than 37 degrees.
const HIT_PARALLEL = 0.8;

// Whether a voxel belongs to the sheet that a ray leaves: its normal is much the same, and so is its height. One voxel
// per column along the dominant axis means that heights of a plane's voxels differ by less than |n|_inf. Without
// this rule 4 to 8 % of the rays that leave a slanted plane or a ball meet it again, from behind; with it 0.03 %. And
// a sheet would count once in every voxel of it that a ray crosses.
fn hit_is_own(own: vec2u, normal: vec3f, cell: vec3i) -> bool {
    if (own.x == PATH_NO_OWN.x) {
        return false;
    }
    let n = surface_normal_unpack(own.x);
    let apart = abs(dot(n, vec3f(cell)) - bitcast<f32>(own.y));
    return abs(dot(n, normal)) > HIT_PARALLEL && apart < 0.999 * max(abs(n.x), max(abs(n.y), abs(n.z)));
}

// `own` is the surface that the ray leaves. A ray from a voxel leaves that voxel, one from a rasterised surface starts
// outside all of the surface's own, but for up to two where it lies in a corner.
fn hit_trace(origin: vec3f, direction: vec3f, distance: f32, own: vec2u) -> Hit {
    let met = grid_trace(origin, direction, distance, select(1u, 2u, own.x == PATH_NO_OWN.x));
    atomicAdd(&tally[TALLY_ITERATIONS], met.iterations);
    if (met.cut) {
        atomicAdd(&tally[TALLY_CUT], 1u);
    }
    var hit: Hit;
    hit.found = met.hit;
    if (met.hit) {
        hit.distance = met.distance;
        let record = grid_records[met.record];
        hit.surface = surface_unpack_voxel(record);
        let normal = hit.surface.normal;
        hit.front = dot(normal, direction) < 0.0;
        hit.face = select(-normal, normal, hit.front);
        var entry = vec3f(0.0);
        entry[met.axis] = select(1.0, -1.0, direction[met.axis] > 0.0);
        hit.entry = entry;
        hit.cell = met.cell;
        hit.record = met.record;
        hit.own = vec2u(record.x & 0xffffffu, bitcast<u32>(dot(normal, vec3f(met.cell))));
        hit.again = hit_is_own(own, normal, met.cell);
    }
    return hit;
}

// Where a ray is inside a cell's cube, m: enters, leaves.
fn hit_chord(cell: vec3i, origin: vec3f, direction: vec3f) -> vec2f {
    let still = abs(direction) < vec3f(GRID_STILL);
    let inverse = select(1.0 / select(direction, vec3f(1.0), still), vec3f(0.0), still);
    let low = (grid.origin + grid.voxel_size * vec3f(cell) - origin) * inverse;
    let high = low + grid.voxel_size * inverse;
    let enter = select(min(low, high), vec3f(0.0), still);
    let leave = select(max(low, high), vec3f(GRID_FAR), still);
    let first = max(max(enter.x, enter.y), max(enter.z, 0.0));
    return vec2f(first, max(min(leave.x, min(leave.y, leave.z)), first));
}

// Density of the directions to uniform points of a cell's cube, 1/sr, for a ray that crosses it: (r1^3 - r0^3) / 3V.
fn hit_cube_pdf(cell: vec3i, origin: vec3f, direction: vec3f) -> f32 {
    let r = hit_chord(cell, origin, direction) / grid.voxel_size;
    return (r.y - r.x) * (r.y * r.y + r.x * r.y + r.x * r.x) / 3.0;
}

// An emitting voxel, seen from `from` through a uniform point of its cube: its radiance, and the density but for the sum
// of all weights.
fn hit_emitter(emitter: vec2u, from_point: vec3f, own: vec2u, u: vec3f) -> LightSample {
    let cell = vec3i(vec3u(emitter.x & 0xffffu, emitter.x >> 16u, emitter.y));
    let point = grid.origin + grid.voxel_size * (vec3f(cell) + u);
    let away = point - from_point;
    let wi = away / max(length(away), 1e-20);
    let surface = surface_unpack_voxel(grid_records[grid_record(cell)]);
    if (dot(surface.normal, wi) >= 0.0 || hit_is_own(own, surface.normal, cell)) {
        return LightSample(wi, 0.0, vec3f(0.0), 0.0);
    }
    let pdf = brdf_luminance(surface.emission) * hit_cube_pdf(cell, from_point, wi);
    // Ends before the cube itself.
    let reach = hit_chord(cell, from_point, wi).x - HIT_NUDGE * grid.voxel_size;
    return LightSample(wi, reach, surface.emission * surface.coverage, pdf);
}

// The density with which hit_emitter chooses what a ray from `from` met.
fn hit_emitter_pdf(hit: Hit, from_point: vec3f, direction: vec3f, distance: f32) -> f32 {
    return brdf_luminance(hit.surface.emission) * hit_cube_pdf(hit.cell, from_point, direction);
}

// A cell says nothing about light that passes it, its surface does.
fn hit_blocked(origin: vec3f, direction: vec3f, distance: f32, own: vec2u) -> u32 {
    return PATH_SHEETS;
}

// Where a path starts at a surface that was rasterised: one elevation off it, on the side of `side`.
fn hit_start(point: vec3f, face: vec3f, side: vec3f) -> vec3f {
    return point + grid_elevation(face) * side;
}

// Where it starts after scattering at a voxel: just outside the face it entered through, or just inside where it goes
// on into the voxel.
fn hit_leave(point: vec3f, hit: Hit, direction: vec3f) -> vec3f {
    let out = select(-1.0, 1.0, dot(direction, hit.entry) > 0.0);
    return point + (out * HIT_NUDGE * grid.voxel_size) * hit.entry;
}

// Where it goes on after passing a voxel.
fn hit_pass(point: vec3f, hit: Hit, direction: vec3f) -> vec3f {
    return point - (HIT_NUDGE * grid.voxel_size) * hit.entry;
}
