// Front-to-back raycasting, one thread per pixel. Mirror: renderers/raycasting/src/mirror.rs.

struct View {
    // Voxel coordinates; see `RayFrame` in cvr-core.
    origin: vec3<f32>,
    step: f32,
    direction: vec3<f32>,
    termination: f32,
    right: vec3<f32>,
    pixel: f32,
    up: vec3<f32>,
    transfer_offset: f32,
    voxel_size: vec3<f32>,
    transfer_scale: f32,
    size: vec2<u32>,
}

struct Ray {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

@compute @workgroup_size(8, 8)
fn raycast(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < view.size.x && id.y < view.size.y {
        image[id.y * view.size.x + id.x] = cast_ray(id.xy);
    }
}

// Premultiplied colour and opacity along the ray of a pixel.
fn cast_ray(pixel: vec2<u32>) -> vec4<f32> {
    let centre = vec2<f32>(pixel) + 0.5 - vec2<f32>(view.size) * 0.5;
    var ray = camera_ray(vec2<f32>(centre.x, -centre.y) * view.pixel);
    // One unit of t is one voxel length in the world.
    ray.direction /= length(ray.direction * view.voxel_size);

    // A ray along an axis would divide by zero.
    let tiny = abs(ray.direction) < vec3<f32>(1e-9);
    let slope = select(ray.direction, vec3<f32>(1e-9), tiny);
    let t0 = (vec3<f32>(0.0) - ray.origin) / slope;
    let t1 = (vec3<f32>(volume_extent) - ray.origin) / slope;
    let low = min(t0, t1);
    let high = max(t0, t1);
    let near = max(max(low.x, low.y), max(low.z, 0.0));
    let far = min(min(high.x, high.y), high.z);

    // From where the ray enters: the smaller the numbers, the less the samples' places depend on rounding.
    let entry = ray.origin + ray.direction * near;
    let end = far - near;

    var result = vec4<f32>(0.0);
    // A sample stands for the piece of ray around it. The last piece is cut at the border, so that the picture
    // does not depend on how the division rounds.
    for (var i = 0u; f32(i) * view.step < end; i++) {
        let start = f32(i) * view.step;
        let piece = min(view.step, end - start);
        let sample = classify(volume_sample(entry + ray.direction * (start + 0.5 * piece)));
        if sample.a > 0.0 {
            let weight = opacity_over(sample.a, piece) * (1.0 - result.a);
            // The last sample counts as far as the ray goes: whether it ends here or one sample later, which
            // rounding may decide, is then the same picture.
            let rest = view.termination - result.a;
            result += vec4<f32>(sample.rgb, 1.0) * min(weight, rest);
            if weight >= rest {
                break;
            }
        }
    }
    return result;
}
