// A scalar: the transfer function says it all.
fn classify(voxel: Voxel) -> vec4<f32> {
    return transfer(voxel);
}
