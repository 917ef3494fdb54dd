// Decodes rows of some layers into texels, packed in words for a copy into a texture: scalars in texels of one channel,
// colours in texels of four. One invocation writes the voxels of one word, or the words of one voxel.
struct Slab {
    // Row and layer of the volume where the slab begins.
    first: vec2<u32>,
    // Rows in each layer of the slab.
    rows: u32,
    // Words from row to row: a copy wants rows of a multiple of 256 bytes.
    row_words: u32,
    // texel_of is asked for (value - offset) * per_unit.
    offset: f32,
    per_unit: f32,
    // Voxels in each row.
    row_voxels: u32,
}

@compute @workgroup_size(64)
fn decode(@builtin(global_invocation_id) id: vec3<u32>) {
    let channels = select(4u, 1u, voxel_channels == 1u);
    let lanes = 32u / texel_bits;
    let voxels = max(lanes / channels, 1u);
    let x = id.x * voxels;
    if x >= inputs.slab.row_voxels {
        return;
    }
    var words: array<u32, 4>;
    for (var v = 0u; v < min(voxels, inputs.slab.row_voxels - x); v++) {
        let voxel = voxel_fetch(voxel_of_layer(vec3<i32>(vec3<u32>(x + v, inputs.slab.first + id.yz))));
        for (var c = 0u; c < voxel_channels; c++) {
            let sample = v * channels + c;
            let texel = texel_of((voxel_channel(voxel, c) - inputs.slab.offset) * inputs.slab.per_unit);
            words[sample / lanes] |= texel << (sample % lanes * texel_bits);
        }
    }
    let count = voxels * channels / lanes;
    let at = (id.z * inputs.slab.rows + id.y) * inputs.slab.row_words + id.x * count;
    for (var w = 0u; w < count; w++) {
        texels[at + w] = words[w];
    }
}
