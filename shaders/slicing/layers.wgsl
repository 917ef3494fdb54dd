// Corners of slices that are drawn from a ring of layers, between the centres of two layers at a time: the instance, less
// one, is the lower of them.
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

// Whether a sample is to be taken from the layers that are there now. The slab of a slice may reach over several layers,
// and is drawn with each of them: every sample of it once. A filter reads no further than this and the next layer, a
// gradient one more on each side: rounding keeps to the halves that these comparisons end at.
fn drawn_now(proxy: Proxy, x: vec3<f32>) -> bool {
    return i32(floor(layered(x).z - 0.5)) == proxy.between;
}
