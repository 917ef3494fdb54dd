// Voxels of a frame that a codec's own passes have rebuilt: the bits of floats, x fastest, channels interleaved.
fn voxel_fetch(p: vec3<i32>) -> Voxel {
    let v = vec3<u32>(p);
    let first = ((v.z * volume_extent.y + v.y) * volume_extent.x + v.x) * voxel_channels;
    var value: vec4<f32>;
    for (var c = 0u; c < voxel_channels; c++) {
        value[c] = bitcast<f32>(frame_words(first + c));
    }
    return voxel_of(value);
}
