// Trilinear by the texture unit, from a texture of whole blocks that extends beyond the volume. Positions are clamped
// at the border of the volume, because the sampler clamps only at the border of the texture.
fn volume_sample(x: vec3<f32>) -> Voxel {
    let inside = clamp(x, vec3<f32>(0.5), vec3<f32>(volume_extent) - 0.5);
    let texel = textureSampleLevel(volume_texture, volume_sampler, inside / vec3<f32>(texture_size), 0.0);
    return voxel_of(texel * texel_scale + texel_offset);
}
