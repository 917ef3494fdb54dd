// The transfer function gives the opacity, and tints the voxel's own colour.
fn classify(voxel: Voxel) -> vec4<f32> {
    let entry = transfer(height(voxel));
    return vec4<f32>(entry.rgb * light(voxel), entry.a);
}
