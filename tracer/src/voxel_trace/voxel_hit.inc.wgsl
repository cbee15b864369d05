// What a ray meets in the voxel grid, for the path kernels. Needs voxel::TRACE_WGSL.

struct Hit {
    found: bool,
    // m along the ray.
    distance: f32,
    // As stored; its normal may point away from the ray. Of a cube the normal is that of the face that was met.
    surface: Surface,
    // Met from the side its normal is on.
    front: bool,
    // Unit, towards the ray: nothing is reflected below it.
    face: vec3f,
    // Of what the ray came through, towards the ray: the cell's face, or the plane that was met.
    entry: vec3f,
    // It was met at its cell's face and not at a plane within.
    at_face: bool,
    cell: vec3i,
    // Its record's number, which is that of what is kept for it.
    record: u32,
    // Of the grid it is in, where levels are nested.
    level: u32,
    // For rays that stay on this side of the surface: a point there, packed.
    own: vec2u,
    // The same for rays that cross it.
    beyond: vec2u,
}

// Off a face by this share of a voxel: enough to name the cell after rounding a position of 1,024 voxels (2^-14), too
// little to see.
const HIT_NUDGE = 1e-3;
// Off a plane: more than what neighbouring planes differ by, that of a ball of 20 voxels included.
const HIT_OFF_PLANE = 0.02;

// A point in 21 bits per axis: 1/256 voxel, or what is left of it where levels are nested. Given in voxels.
fn hit_point_pack(p: vec3f) -> vec2u {
    let q = vec3u(clamp(grid_steps_of(p), vec3f(0.0), vec3f(2097150.0)));
    return vec2u(q.x | (q.z << 21u), q.y | ((q.z >> 11u) << 21u));
}

// Left over: the ray crosses glass or leaves it, and what it is behind it is behind.
const HIT_POINT_SHARP = 0x80000000u;

// World, m.
fn hit_point_unpack(code: vec2u) -> vec3f {
    let q = vec3u(code & vec2u(0x1fffffu), (code.x >> 21u) | (((code.y >> 21u) & 0x3ffu) << 11u));
    return grid_point_at(vec3f(q) + 0.5);
}

// A point that no surface separates from the origin of a ray that leaves `own`.
fn hit_beside(origin: vec3f, own: vec2u) -> vec3f {
    return select(hit_point_unpack(own), origin, own.x == PATH_NO_OWN.x && own.y == PATH_NO_OWN.y);
}

fn hit_behind(own: vec2u) -> f32 {
    return select(GRID_BEHIND, 0.0, own.y != PATH_NO_OWN.y && (own.y & HIT_POINT_SHARP) != 0u);
}

fn hit_trace(origin: vec3f, direction: vec3f, distance: f32, own: vec2u) -> Hit {
    let met = grid_first(origin, direction, distance, hit_beside(origin, own), hit_behind(own));
    atomicAdd(&tally[TALLY_ITERATIONS], met.iterations);
    if (met.cut) {
        atomicAdd(&tally[TALLY_CUT], 1u);
    }
    var hit: Hit;
    hit.found = met.hit;
    if (met.hit) {
        hit.distance = met.distance;
        hit.surface = surface_unpack_voxel(record_words(met.record));
        hit.front = dot(met.normal, direction) < 0.0;
        let side = select(-1.0, 1.0, hit.front);
        hit.face = side * met.normal;
        hit.entry = hit.face;
        // No `||`, and no `if` below: they would be branches that a uniform alone decides.
        let is_plane = grid.contours != 0u;
        hit.at_face = met.axis < 3u && (met.is_cube | !is_plane);
        if (hit.at_face) {
            hit.entry = vec3f(0.0);
            hit.entry[met.axis] = select(1.0, -1.0, direction[met.axis] > 0.0);
        }
        if (met.is_cube) {
            hit.face = hit.entry;
        }
        // A cube, or a crease's other plane: its frame turns with it.
        if (any(side * hit.surface.normal != hit.face)) {
            hit.surface.normal = side * hit.face;
            let along = hit.surface.tangent - dot(hit.surface.tangent, hit.face) * hit.face;
            hit.surface.tangent = select(surface_basis(surface_normal_pack(hit.face)).first, normalize(along), dot(along, along) > 1e-4);
        }
        hit.cell = met.cell;
        hit.record = met.record;
        hit.level = grid_level();
        let center = vec3f(met.cell) + 0.5;
        let point = (origin + met.distance * direction - grid.origin) / grid.voxel_size;
        let offset = select(0.0, hit.surface.contour, !met.is_cube);
        let before = point + 0.1 * hit.face - min(0.5, met.distance / grid.voxel_size) * direction;
        let own_point = select(met.beside, before, is_plane);
        let beyond_point = select(center + offset * met.normal - hit.face, point - 0.5 * hit.face, is_plane);
        let sharp = vec2u(0u, select(0u, HIT_POINT_SHARP, hit.surface.transmission > 0.0));
        hit.own = hit_point_pack(own_point) | sharp;
        hit.beyond = hit_point_pack(beyond_point) | sharp;
    }
    return hit;
}

// What a ray that goes on from a hit leaves.
fn hit_leaves(hit: Hit, direction: vec3f) -> vec2u {
    return select(hit.beyond, hit.own, dot(hit.face, direction) > 0.0);
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
    let cell = grid_use_named(emitter);
    let point = grid.origin + grid.voxel_size * (vec3f(cell) + u);
    let away = point - from_point;
    let wi = away / max(length(away), 1e-20);
    let record = grid_record(cell);
    let surface = surface_unpack_voxel(record_words(record));
    // What a ray there would meet.
    let chord = hit_chord(cell, from_point, wi);
    let enter = chord.x / grid.voxel_size;
    let beside = (hit_beside(from_point, own) - grid.origin) / grid.voxel_size;
    let o = (from_point - grid.origin) / grid.voxel_size;
    let met = grid_meet(record, cell, o, wi, enter, chord.y / grid.voxel_size - enter, beside, hit_behind(own), enter <= grid_near(), enter == 0.0);
    if (dot(met.normal, wi) >= 0.0 || met.t < 0.0 || !grid_is_level_at(from_point, wi, chord.x)) {
        return LightSample(wi, 0.0, vec3f(0.0), 0.0, emitter);
    }
    let pdf = grid_face_share() * brdf_luminance(surface.emission) * hit_cube_pdf(cell, from_point, wi);
    // Ends before the cube itself.
    let reach = chord.x - HIT_NUDGE * grid.voxel_size;
    return LightSample(wi, reach, surface.emission * surface.coverage, pdf, emitter);
}

fn hit_is_emitter(hit: Hit, emitter: vec2u) -> bool {
    let cell = vec3u(hit.cell);
    return all(vec2u(cell.x | (cell.y << 16u), cell.z | (hit.level << 16u)) == emitter);
}

// The density with which hit_emitter chooses what a ray from `from` met.
fn hit_emitter_pdf(hit: Hit, from_point: vec3f, direction: vec3f, distance: f32) -> f32 {
    grid_use(hit.level);
    return grid_face_share() * brdf_luminance(hit.surface.emission) * hit_cube_pdf(hit.cell, from_point, direction);
}

// A cell says nothing about light that passes it, its surface does.
fn hit_blocked(origin: vec3f, direction: vec3f, distance: f32, own: vec2u) -> u32 {
    return PATH_SHEETS;
}

fn hit_is_cube(point: vec3f) -> bool {
    let cell = vec3i(floor((point - grid.origin) / grid.voxel_size));
    if (!grid_occupied(cell)) {
        return false;
    }
    return grid_plane(grid_record(cell)).is_cube;
}

// Steps towards the viewer in search of a place to start: half a voxel, 1.25, 2.25, .. 48. At grazing angles a layer of
// cubes is long.
const HIT_STEPS_TO_VIEWER = 18u;

// Where a path starts at a surface that was rasterised, on the side of `side`: one elevation off it, or just off it where
// planes are. Where that is inside a cube, in a corner, it starts between there and the viewer, where nothing is.
fn hit_start(point: vec3f, face: vec3f, side: vec3f, wo: vec3f) -> vec3f {
    grid_use_at(point);
    let height = select(grid_elevation(face), HIT_OFF_PLANE * grid.voxel_size, grid.contours != 0u);
    var start = point + height * side;
    if (dot(side, wo) > 0.0) {
        for (var i = 1u; i <= HIT_STEPS_TO_VIEWER && hit_is_cube(start); i += 1u) {
            start = point + (0.125 * f32(i * (i + 3u)) * grid.voxel_size) * wo;
        }
    }
    return start;
}

// What a path leaves that starts there. Between the point and the viewer nothing is.
fn hit_starts_from(point: vec3f, side: vec3f, wo: vec3f) -> vec2u {
    grid_use_at(point);
    let beside = point + grid.voxel_size * (select(0.5, 0.1, grid.contours != 0u) * side + select(side, wo, dot(side, wo) > 0.0));
    let sharp = vec2u(0u, select(HIT_POINT_SHARP, 0u, dot(side, wo) > 0.0));
    return hit_point_pack((beside - grid.origin) / grid.voxel_size) | sharp;
}

// Just outside what was met, or just inside. Of a face the place is certain: not in a cell beside the two that share it.
fn hit_beyond(point: vec3f, hit: Hit, outside: bool) -> vec3f {
    grid_use(hit.level);
    if (hit.at_face) {
        let low = vec3f(hit.cell) + HIT_NUDGE;
        let within = clamp((point - grid.origin) / grid.voxel_size, low, low + (1.0 - 2.0 * HIT_NUDGE));
        return grid.origin + grid.voxel_size * (within + select(0.0, 2.0 * HIT_NUDGE, outside) * hit.entry);
    }
    let off = grid.voxel_size * select(HIT_NUDGE, HIT_OFF_PLANE, grid.contours != 0u);
    return point + select(-off, off, outside) * hit.entry;
}

// Where it starts after scattering at a voxel: just outside the face it entered through, or just inside where it goes
// on into the voxel.
fn hit_leave(point: vec3f, hit: Hit, direction: vec3f) -> vec3f {
    return hit_beyond(point, hit, dot(direction, hit.entry) > 0.0);
}

// Where it goes on after passing a voxel.
fn hit_pass(point: vec3f, hit: Hit, direction: vec3f) -> vec3f {
    return hit_beyond(point, hit, false);
}
