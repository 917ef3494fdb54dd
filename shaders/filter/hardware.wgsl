// Trilinear by the texture unit. Its weights may have only 8 bits.
fn volume_sample(x: vec3<f32>) -> Voxel {
    let texel = textureSampleLevel(volume_texture, volume_sampler, x / vec3<f32>(volume_extent), 0.0);
    return voxel_of(texel * texel_scale + texel_offset);
}
