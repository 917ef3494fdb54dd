// The number that the transfer function maps, and whose gradient is a surface's normal: luminance, or one channel.
fn height(voxel: Voxel) -> f32 {
    return dot(inputs.colour.weights, voxel);
}
