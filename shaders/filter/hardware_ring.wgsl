// Trilinear by the texture unit, from a ring of layers. The sampler repeats, so a layer is found at its own number.
fn volume_sample(x: vec3<f32>) -> Voxel {
    let size = vec3<f32>(layered(vec3<f32>(volume_extent)).xy, f32(ring_layers));
    let texel = textureSampleLevel(volume_texture, volume_sampler, layered(x) / size, 0.0);
    return voxel_of(texel * texel_scale + texel_offset);
}
