// Between two rounds: draws the next one if the last one stored something, and nothing otherwise.

struct RoundsParams {
    vertex_count: u32,
    first_vertex: u32,
    // 1: the round to come has atomic minima.
    atomic_round: u32,
    // 1: the round to come is drawn in any case.
    first_round: u32,
}

@group(0) @binding(1) var<uniform> params: RoundsParams;
@group(3) @binding(0) var<storage, read_write> out_changed: u32;
// Vertices, instances, first vertex, first instance.
@group(3) @binding(1) var<storage, read_write> out_draw: vec4u;
// Rounds drawn, atomic ones of them; low and high words.
@group(3) @binding(2) var<storage, read_write> out_counts: vec4u;

@compute @workgroup_size(1)
fn rounds_arm() {
    let armed = min(out_changed + params.first_round, 1u);
    out_draw = vec4u(armed * params.vertex_count, 1u, params.first_vertex, 0u);
    out_counts += vec4u(armed, 0u, armed * params.atomic_round, 0u);
    out_changed = 0u;
}
