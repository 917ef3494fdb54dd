// The transfer function: linear between its control points, constant beyond them. Segment k lies between the points k -
// 1 and k. At a step the later point applies. Mirror: `TransferFunction::classify` in cvr-core.
struct Segment {
    number: u32,
    // Where it begins and ends; the same value beyond the points.
    low: f32,
    high: f32,
}

fn transfer_texel(i: u32, row: u32) -> vec4<f32> {
    return textureLoad(transfer_table, vec2<u32>(i, row), 0);
}

// Position of a value within a segment, 0 to 1. The scale is a power of two that brings the larger end to 2 .. 4:
// products with it are exact, and no difference overflows or underflows.
fn share_of(value: f32, low: f32, high: f32) -> f32 {
    let larger = max(max(abs(low), abs(high)), 1e-37);
    let scale = bitcast<f32>(~bitcast<u32>(larger) & 0x7f800000u);
    let first = low * scale;
    return min((clamp(value, low, high) * scale - first) / max(high * scale - first, 1e-9), 1.0);
}

fn transfer(value: f32) -> vec4<f32> {
    let segment = transfer_segment(value);
    let low = transfer_texel(segment.number, 1u);
    let high = transfer_texel(segment.number + 1u, 1u);
    return low + (high - low) * share_of(value, segment.low, segment.high);
}
