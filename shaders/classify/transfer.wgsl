// The transfer function: linear between its control points, constant beyond them. Segment k lies between the points
// k - 1 and k; at a step the later point holds. Mirror: `TransferFunction::classify` in cvr-core.
fn transfer_texel(i: u32, row: u32) -> vec4<f32> {
    return textureLoad(transfer_table, vec2<u32>(i, row), 0);
}

fn transfer(value: f32) -> vec4<f32> {
    let segment = transfer_segment(value);
    // Scale, a power of two, then offset, then inverse width.
    let within = transfer_texel(segment, 1u);
    let low = transfer_texel(segment, 2u);
    let high = transfer_texel(segment + 1u, 2u);
    let share = min((value * within.x - within.y) * within.z, 1.0);
    return low + (high - low) * share;
}
