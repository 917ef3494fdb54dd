// How many of four keys are at or below a value.
fn keys_passed(value: f32, keys: vec4<f32>) -> u32 {
    let passed = vec4<u32>(vec4<f32>(value) >= keys);
    return passed.x + passed.y + passed.z + passed.w;
}
