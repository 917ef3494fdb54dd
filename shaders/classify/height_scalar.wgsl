// The number whose gradient is a surface's normal: the value.
fn height(voxel: Voxel) -> f32 {
    return voxel;
}
