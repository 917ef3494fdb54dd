// Trilinear by the texture unit, from a texture of whole blocks that reaches beyond the volume: what the sampler's
// clamping does at the border of a texture is done at the border of the volume.
fn volume_sample(x: vec3<f32>) -> Voxel {
    let inside = clamp(x, vec3<f32>(0.5), vec3<f32>(volume_extent) - 0.5);
    let texel = textureSampleLevel(volume_texture, volume_sampler, inside / vec3<f32>(texture_size), 0.0);
    return voxel_of(texel * texel_scale + texel_offset);
}
