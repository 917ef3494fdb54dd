
// Samples in data units, within the range of the volume. Constants: wavelet_scale (one over the gain of the low band),
// wavelet_least and wavelet_most.
fn wavelet_store(line: wavelet_Line, i: i32, value: wavelet_Value) {
    if u32(i) < wavelet_samples {
        let sample = min(max(f32(value) * wavelet_scale, wavelet_least), wavelet_most);
        wavelet_set_to(line.sink + u32(i) * wavelet_to_strides.x, bitcast<u32>(sample));
    }
}
