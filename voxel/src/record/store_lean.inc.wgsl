@group(3) @binding(0) var<storage, read_write> out_records: array<u32>;

// What is not kept has place 0.
fn record_store(index: u32, words: vec4u) {
    let at = RECORD_WORDS * index;
    out_records[at] = words.x;
    out_records[at + 1u] = words.y;
    if (RECORD_LIGHT_AT != 0u) {
        out_records[at + RECORD_LIGHT_AT] = words.z;
    }
    if (RECORD_LOBE_AT != 0u) {
        out_records[at + RECORD_LOBE_AT] = words.w;
    }
}
