// The parameters of a view, and the ray of a pixel. Mirror: `render::mirror` in cvr-core.

struct View {
    // Voxel coordinates; see `RayFrame` in cvr-core.
    origin: vec3<f32>,
    step: f32,
    direction: vec3<f32>,
    termination: f32,
    right: vec3<f32>,
    pixel: f32,
    up: vec3<f32>,
    voxel_size: vec3<f32>,
    size: vec2<u32>,
    // What finds the segment of the transfer function; see `SegmentSearch` in cvr-core.
    transfer_keys: array<vec4<f32>, 2>,
}

struct Ray {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

// The part of a ray within the drawn box; empty where far <= near.
struct Crossing {
    near: f32,
    far: f32,
}

fn pixel_ray(pixel: vec2<u32>) -> Ray {
    let centre = vec2<f32>(pixel) + 0.5 - vec2<f32>(inputs.view.size) * 0.5;
    var ray = camera_ray(vec2<f32>(centre.x, -centre.y) * inputs.view.pixel);
    // One unit of t is one voxel length in the world.
    ray.direction /= length(ray.direction * inputs.view.voxel_size);
    return ray;
}

fn crossing(ray: Ray) -> Crossing {
    // A ray along an axis would divide by zero.
    let tiny = abs(ray.direction) < vec3<f32>(1e-9);
    let slope = select(ray.direction, vec3<f32>(1e-9), tiny);
    let t0 = (bounds_low() - ray.origin) / slope;
    let t1 = (bounds_high() - ray.origin) / slope;
    let low = min(t0, t1);
    let high = max(t0, t1);
    return Crossing(max(max(low.x, low.y), max(low.z, 0.0)), min(min(high.x, high.y), high.z));
}
