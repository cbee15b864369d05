// Records of any number of words, for kernels that look at planes alone.

@group(1) @binding(17) var<storage, read> grid_records: array<u32>;

fn record_plane(index: u32) -> vec2u {
    let at = grid.record_words * index;
    return vec2u(grid_records[at], grid_records[at + 1u]);
}
