// The first vertex of a path that renews a voxel's side: light samples, and one diffuse direction. See mod.rs.

fn feed_start(path: ptr<function, Path>, slot: u32, pixel: vec2u) -> vec3f {
    var surface = path_surface(surface_unpack_voxel(record_words(slot >> 1u)));
    if ((slot & 1u) == 1u) {
        surface.normal = -surface.normal;
        surface.handedness = -surface.handedness;
    }
    let entry = (*path).feed_entry;
    var hit: Hit;
    hit.at_face = (entry & 3u) != CACHE_PLANE;
    hit.entry = surface.normal;
    if (hit.at_face) {
        hit.entry = vec3f(0.0);
        hit.entry[entry & 3u] = select(1.0, -1.0, (entry & CACHE_NEGATIVE) != 0u);
    }
    if (hit.at_face && (entry & CACHE_CUBE) != 0u) {
        surface.normal = hit.entry;
        surface.tangent = surface_basis(surface_normal_pack(surface.normal)).first;
    }
    hit.face = surface.normal;
    hit.cell = vec3i(floor(((*path).origin - grid.origin) / grid.voxel_size));
    hit.own = vec2u((*path).own_x, (*path).own_y);
    // Nothing depends on where it is seen from but a factor, which is left out.
    let wo = surface.normal;
    brdf_look(surface, wo);
    let point = (*path).origin;
    noise_point = point;
    let serial = params.first_sample;

    var found = vec3f(0.0);
    if (path_lights && params.lights > 0u) {
        let v = noise_at(pixel, serial, PATH_FEED_BLOCK + 1u);
        let sample = light_sample(0u, params.lights, point, v.xy);
        found += path_light(surface, wo, hit.face, sample, hit_leave(point, hit, sample.wi), hit.own, 1.0, false).diffuse;
    }
    if (path_areas && params.has_areas != 0u) {
        let origin = hit_leave(point, hit, hit.face);
        let sample = path_area_sample(origin, hit.own, pixel, serial, PATH_FEED_BLOCK);
        found += path_light(surface, wo, hit.face, sample, origin, hit.own, 1.0, false).diffuse;
    }
    let over_view = 1.0 / max(brdf_view(surface), 1e-3);
    let scatter = path_scatter(surface, wo, hit.face, false, vec3f(noise_at(pixel, serial, PATH_FEED_BLOCK + 2u).xy, 0.0), false);
    (*path).throughput = scatter.weight * over_view;
    (*path).direction = scatter.wi;
    (*path).pdf = scatter.pdf;
    (*path).origin = hit_leave(point, hit, scatter.wi);
    (*path).state = select(0u, PATH_ALIVE, scatter.valid) | (2u << PATH_BOUNCE_SHIFT);
    return found * over_view;
}

@compute @workgroup_size(8, 8)
fn path_feed(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    params = params_of[group.z];
    if (all(id.xy < vec2u(frame.trace_size.x, params.rows))) {
        let index = path_index(id.xy);
        var path = paths[index];
        if (path.feed != 0u) {
            let slot = path.feed - 1u;
            if (atomicLoad(&cache[cache_key_at(slot)]) == cache_key(id.xy)) {
                pixels[index].aside = feed_start(&path, slot, id.xy);
            } else {
                path.feed = 0u;
            }
            paths[index] = path;
        }
    }
    path_count(local);
    path_count_feed(local);
}
