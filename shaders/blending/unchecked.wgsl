// The colour that a fragment adds to the picture. A renderer declares it: `shown`, premultiplied.
@fragment
fn blended(proxy: Proxy) -> @location(0) vec4<f32> {
    return shown(proxy);
}
