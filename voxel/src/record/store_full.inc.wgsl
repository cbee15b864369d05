@group(3) @binding(0) var<storage, read_write> out_records: array<vec4u>;

fn record_store(index: u32, words: vec4u) {
    out_records[index] = words;
}
