// What the corners that lie at one place have in common.

@group(2) @binding(0) var<storage, read> topology: array<u32>;
@group(3) @binding(0) var<storage, read_write> out_classes: array<f32>;

@compute @workgroup_size(256)
fn classes_join(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= params.count) {
        return;
    }
    let class_index = params.first + id.x;
    let joined = shape_class(class_index);
    let at = 12u * class_index;
    out_classes[at] = joined.position.x;
    out_classes[at + 1u] = joined.position.y;
    out_classes[at + 2u] = joined.position.z;
    out_classes[at + 3u] = joined.height;
    out_classes[at + 4u] = joined.along.x;
    out_classes[at + 5u] = joined.along.y;
    out_classes[at + 6u] = joined.along.z;
    out_classes[at + 7u] = joined.lowest;
    out_classes[at + 8u] = joined.highest;
}
