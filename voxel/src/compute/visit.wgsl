// Visits the bricks that each tile of a triangle meets, and hands them to compute_found: count.inc.wgsl, then
// fill.inc.wgsl. After tiles.inc.wgsl and one of these.

// By item: triangle, tile.
@group(2) @binding(2) var<storage, read> in_items: array<vec2u>;

@compute @workgroup_size(64)
fn compute_visit(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index >= params.count) {
        return;
    }
    let item = in_items[index];
    let t = sat_triangle(item.x, compute_is_thin());
    let range = compute_range(t);
    let tiles = compute_tiles(range);
    let tile = vec2i(i32(item.y) % tiles.x, i32(item.y) / tiles.x);
    let low = range.low + i32(COMPUTE_TILE) * tile;
    let high = min(low + i32(COMPUTE_TILE) - 1, range.high);
    let slack = t.slack + COMPUTE_BRICK_SLACK;
    for (var v = low.y; v <= high.y; v += 1) {
        for (var u = low.x; u <= high.x; u += 1) {
            let column = 8.0 * vec2f(vec2i(u, v)) + COMPUTE_HALF_BRICK;
            let depths = sat_depths(t, column, COMPUTE_HALF_BRICK, slack, false);
            let bounds = vec2f(f32(range.near), f32(range.far));
            let span = vec2i(clamp(floor((depths - COMPUTE_HALF_BRICK) / 8.0) + vec2f(0.0, 1.0), bounds.xx, bounds.yy));
            for (var w = span.x; w <= span.y; w += 1) {
                let brick = sat_turn_back(vec3i(u, v, w), t.axis);
                let center = 8.0 * vec3f(brick) + COMPUTE_HALF_BRICK;
                let is_kept = all(brick >= params.kept_low) && all(brick < params.kept_high);
                if (is_kept || !sat_overlaps(t, center, COMPUTE_HALF_BRICK, slack, false)) {
                    continue;
                }
                compute_found(grid_index(brick, grid.bricks), item.x);
            }
        }
    }
}
