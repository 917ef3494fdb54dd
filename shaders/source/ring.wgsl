// Layers of a decoded volume in a ring, each in the slot of its number. The scale converts texels to data units.
fn voxel_fetch(p: vec3<i32>) -> Voxel {
    let place = layered_voxel(p);
    let texel = textureLoad(volume_texture, vec3<i32>(place.xy, place.z % ring_layers), 0);
    return voxel_of(texel * texel_scale + texel_offset);
}
