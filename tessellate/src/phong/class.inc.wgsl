// Corners stay where they are.

fn shape_class(class_index: u32) -> SubdivideClass {
    var joined: SubdivideClass;
    joined.position = mesh_position(subdivide_corner_vertex(topology[subdivide_class(class_index).x]));
    return joined;
}
