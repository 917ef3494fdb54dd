// Front-to-back raycasting, one thread per pixel. Mirror: renderers/raycasting/src/mirror.rs.

@compute @workgroup_size(8, 8)
fn raycast(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < view.size.x && id.y < view.size.y {
        image[id.y * view.size.x + id.x] = cast_ray(pixel_ray(id.xy));
    }
}

// What stands for a ray that a device did not follow to its end.
const cut_off = vec4<f32>(-1.0);

// Premultiplied colour and opacity along a ray.
fn cast_ray(ray: Ray) -> vec4<f32> {
    let inside = crossing(ray);
    // From where the ray enters: the smaller the numbers, the less the samples' places depend on rounding.
    let entry = Ray(ray.origin + ray.direction * inside.near, ray.direction);
    let end = inside.far - inside.near;

    var result = vec4<f32>(0.0);
    // A sample stands for the piece of ray around it. The last piece is cut at the border, so that the picture
    // does not depend on how the division rounds.
    var i = next_sample(0u, entry, end);
    while f32(i) * view.step < end {
        let start = f32(i) * view.step;
        let piece = min(view.step, end - start);
        let sample = optical(entry.origin + entry.direction * (start + 0.5 * piece), entry.direction);
        if sample.a > 0.0 {
            let weight = opacity_over(sample.a, piece) * (1.0 - result.a);
            // The last sample counts as far as the ray goes: whether it ends here or one sample later, which
            // rounding may decide, is then the same picture.
            let rest = view.termination - result.a;
            result += vec4<f32>(sample.rgb, 1.0) * min(weight, rest);
            if weight >= rest {
                return result;
            }
        }
        i = next_sample(i + 1u, entry, end);
    }
    // A device may end loops that take it too many rounds, those of the codec among them, and go on behind them.
    if f32(i) * view.step < end {
        return cut_off;
    }
    return result;
}
