// Records of the words that the scene needs, RECORD_WORDS of them; snippets beside this one say what is in the rest.

@group(1) @binding(17) var<storage, read> grid_records: array<u32>;

// Normal, and what holds the contour.
fn record_plane(index: u32) -> vec2u {
    let at = RECORD_WORDS * index;
    return vec2u(grid_records[at], grid_records[at + 1u]);
}

fn record_words(index: u32) -> vec4u {
    return vec4u(record_plane(index), record_light(index), record_lobe(index));
}
