
fn wavelet_value(word: u32, step: u32, offset: u32) -> f32 {
    return bitcast<f32>(offset) + bitcast<f32>(step) * f32(bitcast<i32>(word));
}
