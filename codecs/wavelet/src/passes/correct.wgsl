// Corrections of single samples.
//
// Constants: wavelet_count (corrections), wavelet_start (of this channel), wavelet_channels, wavelet_channel,
// wavelet_unit, wavelet_least, wavelet_most. Resource: wavelet_corrections, two words each: sample, multiple of the
// unit. Scratch: wavelet_to.

@compute @workgroup_size(64)
fn wavelet_correct_pass(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= wavelet_count {
        return;
    }
    let entry = 2u * (wavelet_start + i);
    let place = wavelet_corrections(entry) * wavelet_channels + wavelet_channel;
    let gained = wavelet_unit * f32(bitcast<i32>(wavelet_corrections(entry + 1u)));
    let sample = bitcast<f32>(wavelet_to(place)) + gained;
    wavelet_set_to(place, bitcast<u32>(min(max(sample, wavelet_least), wavelet_most)));
}
