// The light of one path per pixel, modulated, added to the sum of all samples. See camera.rs.

// Sum of radiance, and the number of samples.
@group(3) @binding(0) var<storage, read_write> moments: array<vec4f>;

@compute @workgroup_size(8, 8)
fn path_moments(@builtin(workgroup_id) group: vec3u, @builtin(global_invocation_id) id: vec3u) {
    params = params_of[group.z];
    if (any(id.xy >= vec2u(frame.trace_size.x, params.rows))) {
        return;
    }
    let index = path_index(id.xy);
    var radiance = pixels[index].direct;
    if (first_is_hit(index, id.xy)) {
        let first = first_load(index, id.xy);
        let m = brdf_modulators(first.surface, max(dot(first.surface.normal, first.wo), 0.0));
        radiance += m.diffuse * pixels[index].diffuse.rgb + m.specular * pixels[index].specular.rgb;
    }
    moments[index] += vec4f(radiance, 1.0);
}
