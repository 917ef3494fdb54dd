// Trilinear by the texture unit, from a ring of layers that the sampler repeats: a layer lies in the slot of its number.
fn volume_sample(x: vec3<f32>) -> Voxel {
    let size = vec3<f32>(layered(vec3<f32>(volume_extent)).xy, f32(ring_layers));
    let texel = textureSampleLevel(volume_texture, volume_sampler, layered(x) / size, 0.0);
    return voxel_of(texel * texel_scale + texel_offset);
}
