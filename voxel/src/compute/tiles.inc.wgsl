// The bricks of a triangle, in tiles of columns. After sat.inc.wgsl.

// Half a brick, and what it may miss by: lists may be too long, never too short.
const COMPUTE_HALF_BRICK = 4.0;
const COMPUTE_BRICK_SLACK = 0.015625;

struct ComputeRange {
    // Columns of bricks along the triangle's axis, both ends included; empty where low > high.
    low: vec2i,
    high: vec2i,
    // Bricks of depth.
    near: i32,
    far: i32,
}

// The bricks that a triangle's box touches.
fn compute_range(t: SatTriangle) -> ComputeRange {
    let slack = t.slack + COMPUTE_BRICK_SLACK;
    // Kept within what integers hold, and within the grid.
    let most = vec3f(grid.bricks);
    let low = clamp((min(t.a, min(t.b, t.c)) - slack) / 8.0, vec3f(0.0), most);
    let high = clamp((max(t.a, max(t.b, t.c)) + slack) / 8.0, vec3f(-1.0), most - 1.0);
    let first = sat_turn(floor(low), t.axis);
    let last = sat_turn(floor(high), t.axis);
    return ComputeRange(vec2i(first.xy), vec2i(last.xy), i32(first.z), i32(last.z));
}

// Tiles of COMPUTE_TILE^2 columns of bricks, per axis.
fn compute_tiles(range: ComputeRange) -> vec2i {
    return max((range.high - range.low + i32(COMPUTE_TILE)) / i32(COMPUTE_TILE), vec2i(0));
}
