// One segment of a path: what it meets, the light it finds there, where it goes next. See mod.rs.

// Returns the radiance found, demodulated by the path's throughput; the path is advanced or ended.
fn segment_advance(path: ptr<function, Path>, pixel: vec2u) -> vec3f {
    var found = vec3f(0.0);
    atomicAdd(&tally[TALLY_RAYS], 1u);
    let began = (*path).origin;
    var travelled = 0.0;
    // What is passed uses up no bounce and stays in this segment.
    for (var passed = 0u; passed < path_passes; passed += 1u) {
        let bounce = (*path).state >> PATH_BOUNCE_SHIFT;
        let serial = params.first_sample + params.sample;
        let block = select(0u, PATH_FEED_BLOCK, path_is_feeding) + 4u * (bounce + 1u) + 4096u * passed;
        let own = vec2u((*path).own_x, (*path).own_y);
        let hit = hit_trace((*path).origin, (*path).direction, 4.0 * frame.diagonal, own);
        if (!hit.found) {
            found += (*path).throughput * sky_radiance((*path).direction) * path_sky_share((*path).direction, (*path).pdf);
            (*path).first_distance += frame.diagonal;
            (*path).state &= ~PATH_ALIVE;
            return found;
        }
        let wo = -(*path).direction;
        let point = (*path).origin - hit.distance * wo;
        noise_point = point;
        (*path).first_distance += hit.distance;
        travelled += hit.distance;
        var surface = path_surface(hit.surface);
        let front = hit.front;
        let solid = surface.transmission > 0.0 && !surface.thin;
        // Which side of glass this is, its normal says: thin glass can be crossed without its far side being met.
        let inside = solid && !front;
        if (((*path).state & PATH_INSIDE) != 0u && (inside || !solid)) {
            (*path).throughput *= exp(-(*path).absorption * hit.distance);
        }
        let u = noise_at(pixel, serial, block);
        if (path_coverage && u.w >= surface.coverage) {
            (*path).origin = hit_pass(point, hit, (*path).direction);
            path_leaves(path, hit_leaves(hit, (*path).direction));
            continue;
        }
        if (front) {
            let share = path_emitter_share(hit, began, (*path).direction, travelled, (*path).pdf);
            found += (*path).throughput * surface.emission * share;
        } else {
            surface.normal = -surface.normal;
            surface.handedness = -surface.handedness;
        }

        brdf_look(surface, wo);
        let m_diffuse = brdf_diffuse_albedo(surface);
        let m_specular = brdf_modulators(surface, max(dot(surface.normal, wo), 0.0)).specular;
        let q = path_diffuse_probability(m_diffuse, m_specular, brdf_has_specular(surface));
        let more = bounce < params.bounces;
        // A voxel that keeps light answers for all that its diffuse lobe would find.
        var m_sampled = m_diffuse;
        var is_known = false;
        if (path_cache && more && bounce > 0u && q > 0.0) {
            let cached = cache_read(hit);
            is_known = cached.w > 0.0;
            if (is_known) {
                found += (*path).throughput * m_diffuse * brdf_view(surface) * cached.rgb;
                m_sampled = vec3f(0.0);
            }
            let is_followed = noise_at(pixel, serial, block + 3u).x < 0.5;
            // Half of the paths that meet one without a value end and feed it, the others count twice.
            if (select(!is_followed, q == 1.0, is_known)) {
                cache_offer(path, hit, point, pixel);
                (*path).state &= ~PATH_ALIVE;
                return found;
            }
            (*path).throughput *= select(2.0, 1.0, is_known);
        }
        if (path_lights && more && params.lights > 0u) {
            let v = noise_at(pixel, serial, block + 1u);
            let sample = light_sample(0u, params.lights, point, v.xy);
            let light = path_light(surface, wo, hit.face, sample, hit_leave(point, hit, sample.wi), hit.own, q, inside);
            found += (*path).throughput * (m_sampled * light.diffuse + light.specular);
        }
        if (path_areas && more && params.has_areas != 0u) {
            let origin = hit_leave(point, hit, hit.face);
            let sample = path_area_sample(origin, hit.own, pixel, serial, block);
            let light = path_light(surface, wo, hit.face, sample, origin, hit.own, q, inside);
            found += (*path).throughput * (m_sampled * light.diffuse + light.specular);
        }

        let specular = u.z >= q;
        if (is_known && !specular) {
            cache_offer(path, hit, point, pixel);
            (*path).state &= ~PATH_ALIVE;
            return found;
        }
        // What is left of the number once it chose the lobe, uniform again; below 1 whatever the division rounds to.
        let rest = min((u.z - q) / max(1.0 - q, 1e-6), 0.99999994);
        let scatter = path_scatter(surface, wo, hit.face, specular, vec3f(u.xy, rest), inside);
        let passes = scatter.transmitted && brdf_is_straight(surface);
        if (!scatter.valid || (!more && !passes)) {
            (*path).state &= ~PATH_ALIVE;
            return found;
        }
        (*path).throughput *= scatter.weight * select(m_diffuse / max(q, 1e-6), vec3f(1.0 / max(1.0 - q, 1e-6)), specular);
        (*path).direction = scatter.wi;
        path_leaves(path, hit_leaves(hit, scatter.wi));
        if (!passes) {
            (*path).pdf = select(scatter.pdf * select(q, 1.0 - q, specular), LIGHT_CERTAIN, scatter.pdf == LIGHT_CERTAIN);
        }
        if (solid) {
            let now_inside = inside != scatter.transmitted;
            (*path).state = ((*path).state & ~PATH_INSIDE) | select(0u, PATH_INSIDE, now_inside);
            (*path).absorption = surface.absorption;
        }
        if (passes) {
            (*path).origin = hit_pass(point, hit, scatter.wi);
            continue;
        }
        (*path).origin = hit_leave(point, hit, scatter.wi);
        (*path).state += 1u << PATH_BOUNCE_SHIFT;
        if (bounce + 1u >= params.roulette_from) {
            let survival = clamp(max((*path).throughput.x, max((*path).throughput.y, (*path).throughput.z)), 0.05, 0.95);
            if (noise_at(pixel, serial, block + 2u).x >= survival) {
                (*path).state &= ~PATH_ALIVE;
                return found;
            }
            (*path).throughput /= survival;
        }
        return found;
    }
    (*path).state &= ~PATH_ALIVE;
    return found;
}
