// Rays through nested levels; the same functions as first_one.inc.wgsl. After surface,
// trace.inc.wgsl and GRID_FADE, which mod.rs prints.

const GRID_COARSEST = GRID_LEVELS - 1u;
// Cells of its own by which a path starts within a level's box: more than two of the next one's elevations.
const GRID_MARGIN = 4.0;
// How far before the end of a level a ray's last cell there is looked up, cells.
const GRID_BACK = 0.01;

fn grid_use(level: u32) {
    grid_number = level;
    grid = grid_levels.levels[level];
}

fn grid_level() -> u32 {
    return grid_number;
}

// A point in cells as steps that are the same in all levels, and back, to the world.
fn grid_steps_of(p: vec3f) -> vec3f {
    return (p + vec3f(grid.low)) * grid.point_steps;
}

fn grid_point_at(steps: vec3f) -> vec3f {
    let voxel_size = grid_levels.levels[GRID_COARSEST].voxel_size;
    return grid_levels.levels[GRID_COARSEST].lattice + steps * (voxel_size / grid_levels.levels[GRID_COARSEST].point_steps);
}

// Of a face of the level's cells, as a share of the coarsest level's.
fn grid_face_share() -> f32 {
    let side = grid.voxel_size / grid_levels.levels[GRID_COARSEST].voxel_size;
    return side * side;
}

// The cell that a list of emitters names.
fn grid_use_named(name: vec2u) -> vec3i {
    grid_use(name.y >> 16u);
    return vec3i(vec3u(name.x & 0xffffu, name.x >> 16u, name.y & 0xffffu));
}

// The level that paths start in at a surface there: the finest that all rays from there begin in.
fn grid_use_at(point: vec3f) {
    let away = abs(point - grid_levels.eye);
    let distance = max(away.x, max(away.y, away.z));
    var level = GRID_COARSEST;
    for (var k = 0u; k < GRID_COARSEST; k += 1u) {
        let within = (1.0 - GRID_FADE) * grid_levels.levels[k].reach - GRID_MARGIN * grid_levels.levels[k].voxel_size;
        level = select(level, min(level, k), distance < within);
    }
    grid_use(level);
}

// By which share of its reach a ray's boxes are smaller.
fn grid_shrink(direction: vec3f) -> f32 {
    let bits = bitcast<vec3u>(direction);
    let hash = surface_hash(bits.x + surface_hash(bits.y + surface_hash(bits.z)));
    return 1.0 - GRID_FADE * (f32(hash >> 8u) / 16777216.0);
}

// Where a ray enters and leaves a level's box, m; the first is larger where it does not.
fn grid_span(level: u32, origin: vec3f, inverse: vec3f, still: vec3<bool>, shrink: f32) -> vec2f {
    let half = shrink * grid_levels.levels[level].reach;
    let away = grid_levels.eye - origin;
    let enter = select((away - half * sign(inverse)) * inverse, vec3f(-GRID_FAR), still);
    let leave = select((away + half * sign(inverse)) * inverse, vec3f(GRID_FAR), still);
    let is_beside = any(still & (abs(away) >= vec3f(half)));
    let span = vec2f(max(enter.x, max(enter.y, enter.z)), min(leave.x, min(leave.y, leave.z)));
    return select(span, vec2f(GRID_FAR, -GRID_FAR), is_beside);
}

struct GridStretch {
    level: u32,
    // m along the ray.
    end: f32,
}

// The finest level that holds a ray at t, and until where.
fn grid_stretch(origin: vec3f, direction: vec3f, t: f32, t_max: f32) -> GridStretch {
    let still = abs(direction) < vec3f(GRID_STILL);
    let inverse = select(1.0 / select(direction, vec3f(1.0), still), vec3f(0.0), still);
    let shrink = grid_shrink(direction);
    var stretch = GridStretch(GRID_COARSEST, t_max);
    // From coarse to fine: each box is inside the one before.
    for (var i = 1u; i < GRID_LEVELS; i += 1u) {
        let k = GRID_COARSEST - i;
        let span = grid_span(k, origin, inverse, still, shrink);
        let is_inside = span.x <= t && t < span.y;
        let is_ahead = t < span.x && span.x < span.y;
        stretch.level = select(stretch.level, k, is_inside);
        stretch.end = min(stretch.end, select(select(t_max, span.x, is_ahead), span.y, is_inside));
    }
    return stretch;
}

// Whether it is the level at hand that a ray is in after so many metres.
fn grid_is_level_at(origin: vec3f, direction: vec3f, distance: f32) -> bool {
    return grid_stretch(origin, direction, distance, GRID_FAR).level == grid_number;
}

// As grid_trace, through the finest level that holds the ray. The level of what is hit is then at hand.
fn grid_first(origin: vec3f, direction: vec3f, t_max: f32, beside: vec3f, behind: f32) -> GridHit {
    var hit: GridHit;
    hit.distance = t_max;
    hit.axis = 3u;
    var side = beside;
    var tolerance = behind;
    var t = 0.0;
    // Into each box and out of it.
    for (var i = 0u; i < 2u * GRID_LEVELS && t < t_max && !hit.hit; i += 1u) {
        let stretch = grid_stretch(origin, direction, t, t_max);
        grid_use(stretch.level);
        let from_point = origin + t * direction;
        let iterations = hit.iterations;
        let cut = hit.cut;
        let cell = vec3i(floor((from_point - grid.origin) / grid.voxel_size));
        // A cube that a ray comes into at a change of levels is met, and not left as where a ray starts.
        var is_met = false;
        if (t > 0.0 && grid_occupied(cell)) {
            hit.record = grid_record(cell);
            let plane = grid_plane(hit.record);
            hit.normal = plane.normal;
            is_met = plane.is_cube;
        }
        if (is_met) {
            let size = abs(direction);
            hit.hit = true;
            hit.is_cube = true;
            hit.distance = t;
            hit.cell = cell;
            hit.axis = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= max(size.y, size.z));
            hit.beside = (side - grid.origin) / grid.voxel_size;
        } else {
            hit = grid_trace(from_point, direction, stretch.end - t, side, tolerance);
            hit.distance += t;
            hit.iterations += iterations;
            hit.cut = hit.cut || cut;
            // Where the ray leaves the level it is beside all surfaces for certain, unless it still leaves one.
            let last = origin + (stretch.end - GRID_BACK * grid.voxel_size) * direction;
            let leaves = grid_occupied(vec3i(floor((last - grid.origin) / grid.voxel_size)));
            side = select(last, grid.origin + grid.voxel_size * hit.beside, leaves);
            tolerance = select(0.0, tolerance, leaves);
        }
        t = stretch.end;
    }
    return hit;
}
