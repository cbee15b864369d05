// Records of four words: all that a surface may have.

@group(1) @binding(17) var<storage, read> grid_records: array<vec4u>;

// Normal, and what holds the contour.
fn record_plane(index: u32) -> vec2u {
    return grid_records[index].xy;
}

fn record_words(index: u32) -> vec4u {
    return grid_records[index];
}
