// A batch of rays through one search structure: what goes in and what comes out. See mod.rs.

struct Ray {
    origin: vec3f,
    t_max: f32,
    direction: vec3f,
    skip: u32,
}

struct Met {
    primitive: u32,
    distance: f32,
    weights: vec2f,
    visits: u32,
    cut: u32,
}

@group(2) @binding(0) var<storage, read> in_rays: array<Ray>;
@group(3) @binding(0) var<storage, read_write> out_met: array<Met>;
@group(3) @binding(1) var<storage, read_write> out_blocked: array<u32>;
