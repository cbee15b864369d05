// First vertex of one path per pixel: light samples, a lobe, a direction. See mod.rs.

// Adds what a light sample found to both lobes. A lobe that is absent stays black.
fn start_light(index: u32, found: PathLight, over_specular: vec3f, q: f32) {
    pixels[index].diffuse += vec4f(select(vec3f(0.0), found.diffuse, q > 0.0), 0.0);
    pixels[index].specular += vec4f(found.specular * over_specular, 0.0);
}

fn start_path(index: u32, pixel: vec2u, first: First) -> Path {
    var path: Path;
    var surface = first.surface;
    let face = first.face;
    let wo = first.wo;
    let point = first.point;
    noise_point = point;
    let inside = first.is_back && surface.transmission > 0.0 && !surface.thin;

    // Which of how many, among those that are spread over the lobes together.
    var sample = params.sample;
    var of_pixel = params.samples;
    if (params.rule == PATH_BY_ROUGHNESS) {
        of_pixel = path_roughness_samples(surface);
    }
    if (params.rule == PATH_BY_VARIANCE) {
        let is_even = sample < params.even;
        of_pixel = select(u32(pixels[index].aside.z), params.even, is_even);
        sample -= select(params.even, 0u, is_even);
    }
    if (sample >= of_pixel) {
        return path;
    }

    let m = brdf_modulators(surface, max(dot(surface.normal, wo), 0.0));
    let q = path_diffuse_probability(m.diffuse, m.specular, brdf_has_specular(surface));
    brdf_look(surface, wo);
    var over_specular = 1.0 / m.specular;
    if (path_one_lobe) {
        over_specular *= surface.base;
        surface.base = vec3f(1.0);
    }
    let serial = params.first_sample + params.sample;

    // Stratified over the pixel's samples, so that n samples give each lobe its share to within one.
    var u = noise_at(pixel, serial, 0u);
    let turn = noise_at(pixel, params.first_sample, 2u).x;
    let specular = fract(turn + f32(sample) / f32(of_pixel)) >= q;
    // Smooth glass is followed both ways, one branch after the other: one sample all the same.
    let branches = specular && params.branch != 0u && surface.transmission > 0.0 && brdf_is_delta(surface);
    let goes_through = params.branch == 2u;
    if (goes_through && !branches) {
        return path;
    }
    if (!goes_through) {
        atomicAdd(&tally[TALLY_PATHS], 1u);
        pixels[index].samples += select(1u, 0x10000u, specular);
    }

    let origin = hit_start(point, face, face, wo);
    let leaves = hit_starts_from(point, face, wo);
    // Where the sun is somebody else's, the first hit leaves it out.
    // No `&&`: it would be a branch that a uniform alone decides, for which drivers build the kernel anew each time.
    let first_light = select(0u, 1u, (frame.sun_elsewhere != 0u) & (light_at(0u).kind == LIGHT_SUN));
    if (params.lights > first_light && !goes_through) {
        let u = noise_at(pixel, serial, 1u);
        let sample = light_sample(first_light, params.lights, point, u.xy);
        start_light(index, path_light(surface, wo, face, sample, origin, leaves, q, inside), over_specular, q);
    }
    if (path_areas && params.has_areas != 0u && !goes_through) {
        let sample = path_area_sample(origin, leaves, pixel, serial, 0u);
        start_light(index, path_light(surface, wo, face, sample, origin, leaves, q, inside), over_specular, q);
    }

    if (branches) {
        u.z = select(0.0, 0.99999994, goes_through);
    }
    var scatter = path_scatter(surface, wo, face, specular, vec3f(noise_stratified(pixel, serial), u.z), inside);
    // A branch that there is not, such as what goes through at total reflection, is the other one's.
    if (!scatter.valid || (branches && scatter.transmitted != goes_through)) {
        return path;
    }
    scatter.weight *= select(1.0, scatter.branch, branches);
    let side = select(face, -face, scatter.transmitted);
    path.origin = hit_start(point, face, side, wo);
    path_leaves(&path, hit_starts_from(point, side, wo));
    path.direction = scatter.wi;
    path.pdf = select(scatter.pdf * select(q, 1.0 - q, specular), LIGHT_CERTAIN, scatter.pdf == LIGHT_CERTAIN);
    path.throughput = scatter.weight * select(vec3f(1.0 / max(q, 1e-6)), over_specular / max(1.0 - q, 1e-6), specular);
    let passes = scatter.transmitted && brdf_is_straight(surface);
    let now_inside = inside != (scatter.transmitted && !surface.thin);
    if (now_inside) {
        path.absorption = surface.absorption;
    }
    path.state = PATH_ALIVE | PATH_FIRST | select(0u, PATH_SPECULAR, specular) | select(0u, PATH_INSIDE, now_inside)
        | (select(1u, 0u, passes) << PATH_BOUNCE_SHIFT);
    return path;
}

@compute @workgroup_size(8, 8)
fn path_start(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    params = params_of[group.z];
    if (all(id.xy < vec2u(frame.trace_size.x, params.rows))) {
        let index = path_index(id.xy);
        let pixel = id.xy + vec2u(0u, params.first_row);
        var path: Path;
        if (first_is_hit(index, pixel)) {
            path = start_path(index, pixel, first_load(index, pixel));
        }
        paths[index] = path;
    }
    path_count(local);
}
