
// A quantised coefficient, rounded. Steps are in units of 1/256.
fn wavelet_value(word: u32, step: u32, offset: u32) -> i32 {
    return (bitcast<i32>(word) * bitcast<i32>(step) + 128) >> 8u;
}
