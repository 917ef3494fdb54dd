// The voxel that covers x, clamped at the border. Voxel i covers i..i+1 along each axis.
fn volume_sample(x: vec3<f32>) -> Voxel {
    let last = vec3<i32>(volume_extent) - 1;
    return voxel_fetch(clamp(vec3<i32>(floor(x)), vec3<i32>(0), last));
}
