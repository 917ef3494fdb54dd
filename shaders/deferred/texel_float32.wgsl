// The value unchanged.
const texel_bits: u32 = 32u;

fn texel_of(value: f32) -> u32 {
    return bitcast<u32>(value);
}
