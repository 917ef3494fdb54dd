// The nearest of 256 steps. `value` is in steps. Built-ins are not used, because they may be off by a step.
const texel_bits: u32 = 8u;

fn texel_of(value: f32) -> u32 {
    return u32(clamp(floor(value + 0.5), 0.0, 255.0));
}
