// Vertices of slices that are drawn at once, from the whole volume.
struct Proxy {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) slice: u32,
}

@vertex
fn proxy(@location(0) position: vec2<f32>, @location(1) slice: u32) -> Proxy {
    return Proxy(vec4<f32>(position, 0.0, 1.0), slice);
}

fn drawn_now(proxy: Proxy, x: vec3<f32>) -> bool {
    return true;
}
