// What a ray meets in the voxel grid, for the path kernels. Needs voxel::GRID_WGSL.

struct Hit {
    found: bool,
    // m along the ray.
    distance: f32,
    // As stored; its normal may point away from the ray.
    surface: Surface,
    // Unit, towards the ray: nothing is reflected below it. A voxel's cube says nothing about that, its surface does.
    face: vec3f,
    // Of the voxel's face that the ray entered through, towards the ray.
    entry: vec3f,
}

// Off a face by this share of a voxel: enough to name the cell after rounding a position of 1,024 voxels (2^-14), too
// little to see.
const HIT_NUDGE = 1e-3;

// `fresh`: the ray begins at a surface, whose own voxels it may leave first.
fn hit_trace(origin: vec3f, direction: vec3f, distance: f32, fresh: bool) -> Hit {
    let met = grid_trace(origin, direction, distance, select(1u, 2u, fresh));
    atomicAdd(&tally[TALLY_ITERATIONS], met.iterations);
    if (met.cut) {
        atomicAdd(&tally[TALLY_CUT], 1u);
    }
    var hit: Hit;
    hit.found = met.hit;
    if (met.hit) {
        hit.distance = met.distance;
        hit.surface = surface_unpack_voxel(grid_records[met.record]);
        hit.face = select(hit.surface.normal, -hit.surface.normal, dot(hit.surface.normal, direction) > 0.0);
        var entry = vec3f(0.0);
        entry[met.axis] = select(1.0, -1.0, direction[met.axis] > 0.0);
        hit.entry = entry;
    }
    return hit;
}

// Where a path starts at a surface that was rasterised: one elevation off it, on the side of `side`.
fn hit_start(point: vec3f, face: vec3f, side: vec3f) -> vec3f {
    return point + grid_elevation(face) * side;
}

// Where it starts after scattering at a voxel: just outside the face it entered through, or just inside where it goes
// on into the voxel; then the first cells are left before anything counts ("exit first").
fn hit_leave(point: vec3f, hit: Hit, direction: vec3f) -> vec3f {
    let out = select(-1.0, 1.0, dot(direction, hit.entry) > 0.0);
    return point + (out * HIT_NUDGE * grid.voxel_size) * hit.entry;
}

// Where it goes on after passing a voxel.
fn hit_pass(point: vec3f, hit: Hit, direction: vec3f) -> vec3f {
    return point - (HIT_NUDGE * grid.voxel_size) * hit.entry;
}
