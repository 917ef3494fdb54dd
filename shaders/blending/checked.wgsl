// The colour that a fragment adds to the picture. A device may end loops after too many rounds, also the codec's loops,
// and continue after them. Such a fragment paints a negative red. It stays negative under all later fragments, unless
// they hide it.
@fragment
fn blended(proxy: Proxy) -> @location(0) vec4<f32> {
    let colour = shown(proxy);
    if loops_run() {
        return colour;
    }
    return vec4<f32>(-6e4, -6e4, -6e4, 1.0);
}
