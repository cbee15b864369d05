// What every pass is told.

struct SubdivideParams {
    triangle_count: u32,
    edge_count: u32,
    // Invocations of this pass: from `first` on, `count` of them.
    first: u32,
    count: u32,
    // Vertices of the mesh that came, which lead the list.
    vertex_base: u32,
    // Metres.
    edge_length: f32,
    // Metres of edge per metre of distance; 0 = the camera does not count.
    edge_angle: f32,
    // Factor on displacement: 0 leaves the shape as it was.
    relief: f32,
}

@group(0) @binding(1) var<uniform> params: SubdivideParams;
