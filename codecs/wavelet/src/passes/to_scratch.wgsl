
fn wavelet_store(line: wavelet_Line, i: i32, value: wavelet_Value) {
    if u32(i) < wavelet_samples {
        wavelet_set_to(line.sink + u32(i) * wavelet_to_strides.x, bitcast<u32>(value));
    }
}
