//! Who is joined to whom.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::{Kind, NONE, Source, Topology};
use frame::scene_gpu::VertexLayout;
use glam::Vec3;

const LAYOUT: VertexLayout = VertexLayout { stride: 7, uv1_offset: 0, color_offset: 0 };

fn words(positions: &[Vec3]) -> Vec<u32> {
    let vertex = |p: &Vec3| {
        let [x, y, z] = p.to_array().map(f32::to_bits);
        [x, y, z, 0, 0, 0, 0]
    };
    positions.iter().flat_map(vertex).collect()
}

/// A square of two triangles that share no vertex, of two objects.
fn square(static_triangle_count: usize, kind: impl Fn(usize) -> Kind) -> Topology {
    // One corner at -0: the same place.
    let a = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let b = [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::new(-0.0, 1.0, -0.0)];
    let vertices = words(&[a, b].concat());
    let triangles = [[0, 1, 2, 0], [3, 4, 5, 1 << 16]];
    let source = Source { vertices: &vertices, triangles: &triangles, layout: LAYOUT, static_triangle_count };
    Topology::new(&source, |t| (kind(t), false))
}

#[test]
fn what_stands_still_is_joined_and_what_moves_apart_is_not() {
    let joined = square(2, |_| Kind::Shaped);
    assert_eq!((joined.class_count, joined.edge_count), (4, 5));
    assert_eq!(joined.static_class_count, 4);
    let apart = square(0, |_| Kind::Shaped);
    assert_eq!((apart.class_count, apart.edge_count), (6, 6));
    assert_eq!(apart.static_class_count, 0);
}

#[test]
fn a_flat_neighbour_gets_the_edge_it_shares_and_no_other() {
    let topology = square(2, |t| if t == 0 { Kind::Flat } else { Kind::Shaped });
    assert_eq!((topology.class_count, topology.edge_count), (3, 3));
    let edges = &topology.words[..3];
    assert_eq!(edges.iter().filter(|&&edge| edge == NONE).count(), 2, "{edges:?}");
    assert_eq!(topology.words[6], Kind::Flat as u32);
}

#[test]
fn nothing_shaped_touches_nothing() {
    assert!(!square(2, |_| Kind::Flat).touched);
}
