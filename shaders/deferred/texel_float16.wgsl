// The nearest half, ties to even, with integer arithmetic: built-ins that pack halves may round either way. A value
// that is a half keeps its bits. Values beyond the finite halves become the largest one.
const texel_bits: u32 = 16u;

fn texel_of(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    let sign = (bits >> 16u) & 0x8000u;
    let magnitude = bits & 0x7fffffffu;
    if magnitude < 0x38800000u {
        // Below 2^-14 halves are multiples of 2^-24.
        return sign | u32(round(abs(value) * 16777216.0));
    }
    let nearest = (magnitude + 0xfffu + ((magnitude >> 13u) & 1u)) >> 13u;
    // 112 is the difference between the biases of the exponents.
    return sign | min(nearest - (112u << 10u), 0x7bffu);
}
