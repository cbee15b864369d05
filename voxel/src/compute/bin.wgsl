// Splits triangles into tiles and lists of bricks into chunks. Steps and formulas: mod.rs beside this file.

// Sums of a scan, in and before its blocks.
@group(2) @binding(0) var<storage, read> in_before: array<u32>;
@group(2) @binding(1) var<storage, read> in_blocks: array<u32>;
// Triangles by brick cell.
@group(2) @binding(3) var<storage, read> in_counts: array<u32>;
// Sums of the chunks by brick cell.
@group(2) @binding(6) var<storage, read> in_chunks_before: array<u32>;
@group(2) @binding(7) var<storage, read> in_chunks_blocks: array<u32>;
// Tiles by triangle.
@group(3) @binding(0) var<storage, read_write> out_tiles: array<u32>;
@group(3) @binding(1) var<storage, read_write> out_items: array<vec2u>;
// Chunks by brick cell.
@group(3) @binding(4) var<storage, read_write> out_chunk_counts: array<u32>;
@group(3) @binding(5) var<storage, read_write> out_chunks: array<vec4u>;

// One invocation per triangle: how many tiles it has.
@compute @workgroup_size(64)
fn compute_measure(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index >= params.count) {
        return;
    }
    let t = sat_triangle(params.first_triangle + index, compute_is_thin());
    let range = compute_range(t);
    let tiles = compute_tiles(range);
    out_tiles[index] = select(0u, u32(tiles.x * tiles.y), t.is_there && range.near <= range.far);
}

// One invocation per triangle: names its tiles.
@compute @workgroup_size(64)
fn compute_split(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index >= params.count) {
        return;
    }
    let first = in_before[index] + in_blocks[index / SCAN_BLOCK];
    let tiles = out_tiles[index];
    for (var tile = 0u; tile < tiles; tile += 1u) {
        out_items[first + tile] = vec2u(params.first_triangle + index, tile);
    }
}

// One invocation per brick cell: how many chunks its list is cut into.
@compute @workgroup_size(64)
fn compute_measure_chunks(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index < params.count) {
        out_chunk_counts[index] = (in_counts[index] + COMPUTE_CHUNK - 1u) / COMPUTE_CHUNK;
    }
}

// One invocation per brick cell: names its chunks. Before the lists are filled, which uses the counts up.
@compute @workgroup_size(64)
fn compute_cut(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + params.row * id.y;
    if (index >= params.count) {
        return;
    }
    let first = in_before[index] + in_blocks[index / SCAN_BLOCK];
    let count = in_counts[index];
    var chunk = in_chunks_before[index] + in_chunks_blocks[index / SCAN_BLOCK];
    for (var done = 0u; done < count; done += COMPUTE_CHUNK) {
        out_chunks[chunk] = vec4u(index, first + done, min(COMPUTE_CHUNK, count - done), 0u);
        chunk += 1u;
    }
}
