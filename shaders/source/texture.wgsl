// A decoded volume in a texture; the scale undoes what the texel format asked for.
fn voxel_fetch(p: vec3<i32>) -> Voxel {
    return voxel_of(textureLoad(volume_texture, p, 0) * texel_scale + texel_offset);
}
