// Only a box within the volume is drawn, in voxel coordinates.
struct Clip {
    low: vec3<f32>,
    high: vec3<f32>,
}

fn bounds_low() -> vec3<f32> {
    return inputs.clip.low;
}

fn bounds_high() -> vec3<f32> {
    return inputs.clip.high;
}
