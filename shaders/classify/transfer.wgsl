// The transfer function: a table over the control points' domain, interpolated between its entries.
const transfer_last: f32 = 1023.0;

fn transfer(value: f32) -> vec4<f32> {
    let at = clamp((value - view.transfer_offset) * view.transfer_scale, 0.0, transfer_last);
    let low = min(floor(at), transfer_last - 1.0);
    let a = transfer_table[u32(low)];
    let b = transfer_table[u32(low) + 1u];
    return a + (b - a) * (at - low);
}
