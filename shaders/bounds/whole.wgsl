// The whole volume is drawn.
fn bounds_low() -> vec3<f32> {
    return vec3<f32>(0.0);
}

fn bounds_high() -> vec3<f32> {
    return vec3<f32>(volume_extent);
}
