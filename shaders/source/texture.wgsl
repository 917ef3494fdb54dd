// A decoded volume in a texture. The scale converts texels to data units.
fn voxel_fetch(p: vec3<i32>) -> Voxel {
    return voxel_of(textureLoad(volume_texture, p, 0) * texel_scale + texel_offset);
}
