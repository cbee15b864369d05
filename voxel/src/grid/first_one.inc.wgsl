// What rays through one grid ask; the same functions as first_levels.inc.wgsl. After trace.inc.wgsl.

// Steps per cell of a packed point.
const GRID_POINT_STEPS = 256.0;

// A point in cells as steps that are the same in all levels, and back, to the world.
fn grid_steps_of(p: vec3f) -> vec3f {
    return p * GRID_POINT_STEPS;
}

fn grid_point_at(steps: vec3f) -> vec3f {
    return grid.origin + steps * (grid.voxel_size / GRID_POINT_STEPS);
}

// The level at hand.
fn grid_level() -> u32 {
    return 0u;
}

fn grid_use(level: u32) {
}

// The level that paths start in at a surface there.
fn grid_use_at(point: vec3f) {
}

// The cell that a list of emitters names.
fn grid_use_named(name: vec2u) -> vec3i {
    return vec3i(vec3u(name.x & 0xffffu, name.x >> 16u, name.y));
}

// Of a face of the level's cells, as a share of the coarsest level's.
fn grid_face_share() -> f32 {
    return 1.0;
}

// Whether it is the level at hand that a ray is in after so many metres.
fn grid_is_level_at(origin: vec3f, direction: vec3f, distance: f32) -> bool {
    return true;
}

fn grid_first(origin: vec3f, direction: vec3f, t_max: f32, beside: vec3f, behind: f32) -> GridHit {
    return grid_trace(origin, direction, t_max, beside, behind);
}
