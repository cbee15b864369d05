// One camera ray per pixel through a random point of it (box filter), and what it sees. See camera.rs.

// Blocks of random numbers that no scattering uses: 4 (bounce + 1) and the two after it are taken.
const CAMERA_BLOCK = 3u;

fn camera_ray(pixel: vec2u) -> Pixel {
    var p: Pixel;
    let u = noise_at(pixel, params.first_sample, CAMERA_BLOCK);
    let direction = frame_view_direction(vec2f(pixel) + u.xy, frame.trace_size);
    p.wo = -direction;
    var origin = frame.eye;
    var own = PATH_NO_OWN;
    var travelled = 0.0;
    atomicAdd(&tally[TALLY_RAYS], 1u);
    for (var passed = 0u; passed < path_passes; passed += 1u) {
        let hit = hit_trace(origin, direction, 4.0 * frame.diagonal, own);
        if (!hit.found) {
            p.direct = sky_radiance(direction);
            return p;
        }
        travelled += hit.distance;
        var s = hit.surface;
        if (path_coverage && noise_at(pixel, params.first_sample, CAMERA_BLOCK + 4096u * (passed + 1u)).x >= s.coverage) {
            origin = hit_pass(hit.position, hit, direction);
            own = hit.own;
            continue;
        }
        if (!hit.front) {
            s = material_turn(s);
        }
        p.distance = travelled;
        p.flags = select(0u, FIRST_THIN, s.thin) | select(FIRST_BACK, 0u, hit.front);
        p.direct = s.emission;
        p.f90 = s.f90;
        p.f0 = s.f0;
        p.point = hit.position;
        p.transmission = s.transmission;
        p.metalness = s.metalness;
        p.face = hit.face;
        p.handedness = s.handedness;
        p.normal = s.normal;
        p.tangent = s.tangent;
        p.roughness_t = s.roughness.x;
        p.roughness_b = s.roughness.y;
        p.base = s.base;
        p.absorption = s.absorption;
        return p;
    }
    return p;
}

@compute @workgroup_size(8, 8)
fn path_camera(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    params = params_of[group.z];
    if (all(id.xy < vec2u(frame.trace_size.x, params.rows))) {
        pixels[path_index(id.xy)] = camera_ray(id.xy + vec2u(0u, params.first_row));
    }
    path_count(local);
}
