// Vertices of slices that are drawn from a ring of layers, one layer pair at a time. The instance index minus one is
// the lower layer.
struct Proxy {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) slice: u32,
    @location(1) @interpolate(flat) between: i32,
}

@vertex
fn proxy(
    @location(0) position: vec2<f32>,
    @location(1) slice: u32,
    @builtin(instance_index) instance: u32,
) -> Proxy {
    return Proxy(vec4<f32>(position, 0.0, 1.0), slice, i32(instance) - 1);
}

// Whether a sample belongs to the current layer pair. A slab may reach over several pairs and is drawn with each of
// them, but each of its samples counts once. A filter reads only these two layers, a gradient one more on each side.
// The comparisons end at halves, so rounding is harmless.
fn drawn_now(proxy: Proxy, x: vec3<f32>) -> bool {
    return i32(floor(layered(x).z - 0.5)) == proxy.between;
}
