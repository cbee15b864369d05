// The walk through the grid and what a ray meets there: rules and formulas in mod.rs beside this file. Needs surface, the
// grid and its records.

struct GridHit {
    hit: bool,
    // Metres along the unit direction.
    distance: f32,
    cell: vec3i,
    // Index of its record.
    record: u32,
    // Of the face the cell was entered through; 3 = the ray started inside.
    axis: u32,
    iterations: u32,
    // The step limit ended the walk. It never should.
    cut: bool,
    // It has no plane, its cube is met.
    is_cube: bool,
    // Of the plane as stored, or of the crease's other one.
    normal: vec3f,
    // A point on the ray's side of the surface, voxels in grid space.
    beside: vec3f,
}

// Components of a direction below this (2^-40) do not move: their inverse is never formed.
const GRID_STILL = 9.094947e-13;
// Stands for "never" among parameters of a ray, in voxels.
const GRID_FAR = 1e30;
// No ray is followed farther than this, in voxels: a bound that keeps t_max / voxel_size finite.
const GRID_LONGEST = 1e12;

// Voxels within which a ray may still be beside the surface it left, or one that it passed.
const GRID_NEAR = 8.0;
// The same where planes are met: they tell by themselves, but for the cracks between them.
const GRID_NEAR_PLANES = 2.0;
// Less than this behind a surface near its start a ray that leaves an opaque surface is taken to be in front of it: on a
// ball the point beside may lie behind the plane of a cell some voxels on.
const GRID_BEHIND = 0.75;

fn grid_near() -> f32 {
    return select(GRID_NEAR, GRID_NEAR_PLANES, grid.contours != 0u);
}
// Voxels by which the planes of neighbouring cells may miss each other.
const GRID_CRACK = 0.1;
// Voxels beyond its cell within which a plane is met all the same: rounding, and what rasterizing leaves out.
const GRID_SLACK = 0.02;

// What a cell's record says of the surface in it. Voxels from the cell's centre.
struct GridPlane {
    normal: vec3f,
    offset: f32,
    is_cube: bool,
}

fn grid_plane(record: u32) -> GridPlane {
    let words = record_plane(record);
    let code = i32(words.y) >> 24u;
    return GridPlane(surface_normal_unpack(words.x), f32(code) * SURFACE_CONTOUR_STEP, code == SURFACE_CREASE_CODE);
}

// Where a ray meets a plane, voxels along it; negative where it does not. The ray is at `from` when it enters the cell at
// t and has `chord` to go in it. `beside` is on its side of the surface, all from the cell's centre.
fn grid_cross(normal: vec3f, offset: f32, from_point: vec3f, d: vec3f, t: f32, chord: f32, beside: vec3f, behind: f32, is_near: bool) -> f32 {
    let is_plane = grid.contours != 0u;
    let slope = dot(normal, d);
    let side = dot(normal, beside) - offset;
    let leaves = is_near && select((side < 0.0), (side > -select(behind, min(behind, GRID_CRACK), is_plane)), slope > 0.0);
    // Height above the plane as the ray comes.
    let height = (dot(normal, from_point) - offset) * select(1.0, -1.0, slope > 0.0);
    let ahead = max(height, 0.0) / max(abs(slope), 1e-6);
    let is_crossed = height >= -GRID_CRACK && ahead <= chord + GRID_SLACK;
    return select(-1.0, t + select(0.0, ahead, is_plane), !leaves && (is_crossed || !is_plane));
}

struct GridMeeting {
    // Voxels along the ray; negative where it passes.
    t: f32,
    is_cube: bool,
    normal: vec3f,
}

// What a ray meets of an occupied cell. It enters at t, `chord` voxels of it are inside; it `starts` there or comes from
// elsewhere.
fn grid_meet(record: u32, cell: vec3i, o: vec3f, d: vec3f, t: f32, chord: f32, beside: vec3f, behind: f32, is_near: bool, starts: bool) -> GridMeeting {
    let plane = grid_plane(record);
    let center = vec3f(cell) + 0.5;
    let crossed = grid_cross(plane.normal, plane.offset, o + t * d - center, d, t, chord, beside - center, behind, is_near);
    return GridMeeting(select(crossed, select(t, -1.0, starts), plane.is_cube), plane.is_cube, plane.normal);
}

struct GridWalk {
    cell: vec3i,
    // Voxels along the ray.
    t: f32,
    axis: u32,
}

// To the neighbour across the first exit plane of the block of `side` cells around the cell. The other two coordinates
// come from the position on that plane, but never leave the block and never go back: round-off cannot derail the walk.
// Cells are never negative, so that rounding to 0 is rounding down.
fn grid_step(walk: ptr<function, GridWalk>, side: i32, o: vec3f, d: vec3f, inverse: vec3f, still: vec3<bool>) {
    let forward = d > vec3f(0.0);
    // All bits of the axes that it goes forward on; one cell on, per axis.
    let ahead = select(vec3i(0), vec3i(-1), forward);
    let onward = select(vec3i(-1), vec3i(1), forward);
    let cell = (*walk).cell;
    let plane = (cell & vec3i(-side)) + (vec3i(side) & ahead);
    let exits = select((vec3f(plane) - o) * inverse, vec3f(GRID_FAR), still);
    let x = exits.x <= exits.y && exits.x <= exits.z;
    let y = !x && exits.y <= exits.z;
    (*walk).t = max((*walk).t, min(exits.x, min(exits.y, exits.z)));
    let last = plane + ahead;
    let there = clamp(vec3i(o + (*walk).t * d), min(cell, last), max(cell, last));
    (*walk).cell = select(there, last + onward, vec3<bool>(x, y, !x && !y));
    (*walk).axis = select(select(2u, 1u, y), 0u, x);
}

// The first surface along a ray. `origin` in the world, `direction` unit, `t_max` in metres. `beside`, in the world: a
// point that no surface separates from the origin, as far off the surfaces around as is known; it may lie `behind` by
// so many voxels and is in front all the same.
fn grid_trace(origin: vec3f, direction: vec3f, t_max: f32, beside: vec3f, behind: f32) -> GridHit {
    var hit: GridHit;
    hit.distance = t_max;
    hit.axis = 3u;
    let o = (origin - grid.origin) / grid.voxel_size;
    let limit = min(t_max, GRID_LONGEST * grid.voxel_size) / grid.voxel_size;
    let still = abs(direction) < vec3f(GRID_STILL);
    let forward = direction > vec3f(0.0);
    let inverse = select(1.0 / select(direction, vec3f(1.0), still), vec3f(0.0), still);

    // Where the ray is inside the grid's box.
    let size = vec3f(grid.cells);
    if (any(still & ((o < vec3f(0.0)) | (o >= size)))) {
        return hit;
    }
    let enter = select((select(size, vec3f(0.0), forward) - o) * inverse, vec3f(-GRID_FAR), still);
    let leave = select((select(vec3f(0.0), size, forward) - o) * inverse, vec3f(GRID_FAR), still);
    let entered = max(enter.x, max(enter.y, enter.z));
    var walk = GridWalk(vec3i(0), max(entered, 0.0), 3u);
    if (walk.t >= min(leave.x, min(leave.y, leave.z)) || walk.t > limit) {
        return hit;
    }
    walk.cell = clamp(vec3i(floor(o + walk.t * direction)), vec3i(0), grid.cells - 1);
    if (entered > 0.0) {
        let x = enter.x >= enter.y && enter.x >= enter.z;
        let y = !x && enter.y >= enter.z;
        walk.cell = select(walk.cell, select(grid.cells - 1, vec3i(0), forward), vec3<bool>(x, y, !x && !y));
        walk.axis = select(select(2u, 1u, y), 0u, x);
    }

    let first = walk.cell;
    var side = (beside - grid.origin) / grid.voxel_size;
    // Until here `side` stays what it is, and surfaces that the ray leaves are not met.
    var near = walk.t + grid_near();
    // One more for a ray that moves along no axis: there is none, but a bound that uniforms alone decide makes drivers
    // build the kernel anew at each dispatch.
    let most = GRID_STEPS_PER_CELL * u32(max(grid.cells.x, max(grid.cells.y, grid.cells.z))) + u32(all(still));
    var inside = true;
    for (; inside && !hit.hit && hit.iterations < most; ) {
        // To an occupied cell. What it holds is looked up outside this loop: drivers that run SIMD under masks pay for it
        // once a step otherwise.
        var empty = 1;
        var is_after_empty = false;
        for (; inside && hit.iterations < most; ) {
            hit.iterations += 1u;
            empty = grid_block(walk.cell);
            if (empty == 0) {
                break;
            }
            is_after_empty = true;
            grid_step(&walk, empty, o, direction, inverse, still);
            // Negative cells count as large.
            inside = walk.t <= limit && all(vec3u(walk.cell) < vec3u(grid.cells));
        }
        if (!inside || empty != 0) {
            break;
        }
        if (is_after_empty && walk.t > near) {
            var back = vec3f(0.0);
            back[walk.axis] = select(1.0, -1.0, forward[walk.axis]);
            side = vec3f(walk.cell) + 0.5 + back;
        }
        hit.record = grid_record(walk.cell);
        let at = walk;
        grid_step(&walk, 1, o, direction, inverse, still);
        let met = grid_meet(hit.record, at.cell, o, direction, at.t, walk.t - at.t, side, behind, at.t <= near, all(at.cell == first));
        if (met.t >= 0.0) {
            hit.hit = met.t <= limit;
            hit.distance = min(met.t * grid.voxel_size, t_max);
            hit.cell = at.cell;
            hit.axis = at.axis;
            hit.is_cube = met.is_cube;
            hit.normal = met.normal;
            inside = hit.hit;
        } else {
            near = max(near, at.t + grid_near());
            inside = walk.t <= limit && all(vec3u(walk.cell) < vec3u(grid.cells));
        }
    }
    hit.beside = side;
    hit.cut = hit.iterations >= most && !hit.hit && inside;
    return hit;
}
