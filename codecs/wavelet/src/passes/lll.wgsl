// A frame without decompositions: LLL alone.
//
// Constants: wavelet_samples, wavelet_table, wavelet_channels, wavelet_channel, wavelet_scale, wavelet_least,
// wavelet_most. Resources: wavelet_coefficients, wavelet_bands. Scratch: wavelet_to.

@compute @workgroup_size(64)
fn wavelet_lll_pass(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= wavelet_samples {
        return;
    }
    let entry = 3u * wavelet_table;
    let word = wavelet_coefficients(wavelet_bands(entry) + i);
    let value = f32(wavelet_value(word, wavelet_bands(entry + 1u), wavelet_bands(entry + 2u)));
    let sample = min(max(value * wavelet_scale, wavelet_least), wavelet_most);
    wavelet_set_to(i * wavelet_channels + wavelet_channel, bitcast<u32>(sample));
}
