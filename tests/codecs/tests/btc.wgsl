// Decodes one voxel from two levels and a bit. Resource: btc_blocks.

fn btc_value(record: u32, i: u32) -> f32 {
    let bit = (btc_blocks(record + 2u + i / 32u) >> (i % 32u)) & 1u;
    return bitcast<f32>(btc_blocks(record + bit));
}
