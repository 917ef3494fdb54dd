// Follows the ray of each pixel through the drawn box, one thread per pixel. A renderer declares `gather`, which adds a
// sample.

@compute @workgroup_size(8, 8)
fn follow_rays(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < inputs.view.size.x && id.y < inputs.view.size.y {
        let pixel = id.y * inputs.view.size.x + id.x;
        let so_far = walk_so_far(pixel);
        if so_far.next < ray_cut {
            keep_walk(pixel, follow_ray(pixel_ray(id.xy), so_far));
        }
    }
}

// The sum of a ray so far, and whether the ray ends here.
struct Gathered {
    // Premultiplied colour and opacity.
    result: vec4<f32>,
    ended: bool,
}

// Progress of a ray.
struct Walk {
    // What it has gathered; of a ray that was cut, the sample where it was, whether there was one, and -1.
    result: vec4<f32>,
    // Number of the sample to go on from, or one of the two below.
    next: u32,
}

// No sample has these numbers. The device cut the ray off; the ray has come to its end.
const ray_cut = 0xfffffffeu;
const ray_end = 0xffffffffu;

// Follows a ray from its current sample to its end, or as long as it may go on.
fn follow_ray(ray: Ray, so_far: Walk) -> Walk {
    let inside = crossing(ray);
    // From where the ray enters: the smaller the numbers, the less the samples' places depend on rounding.
    let entry = Ray(ray.origin + ray.direction * inside.near, ray.direction);
    var end = inside.far - inside.near;

    var result = so_far.result;
    var taken = 0u;
    // A sample stands for the piece of ray around it. The last piece is cut at the border, so that the picture
    // does not depend on how the division rounds.
    var i = next_sample(so_far.next, entry, end);
    while f32(i) * inputs.view.step < end && may_go_on(taken) {
        let start = f32(i) * inputs.view.step;
        let piece = min(inputs.view.step, end - start);
        let gathered =
            gather(result, entry.origin + entry.direction * (start + 0.5 * piece), entry.direction, piece);
        result = gathered.result;
        if gathered.ended {
            end = 0.0;
            break;
        }
        i = next_sample(i + 1u, entry, end);
        taken += 1u;
    }
    // A device may end loops that take it too many rounds, those of the codec among them, and go on behind them.
    let more = f32(i) * inputs.view.step < end;
    if !loops_run() || (more && may_go_on(taken)) {
        return Walk(vec4<f32>(f32(i), f32(more), 0.0, -1.0), ray_cut);
    }
    return Walk(result, select(ray_end, i, more));
}
