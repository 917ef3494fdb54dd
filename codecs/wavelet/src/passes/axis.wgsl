// Lines along y or x of a level, from scratch.
//
// Constants: wavelet_lines (lines side by side), wavelet_from_strides and wavelet_to_strides (distances of neighbouring
// samples of a line, of lines side by side, and of lines one above the other), wavelet_samples (samples of a line),
// wavelet_to_start. Scratch: wavelet_from.

struct wavelet_Line {
    source: u32,
    sink: u32,
}

fn wavelet_low(line: wavelet_Line, i: i32) -> wavelet_Value {
    return bitcast<wavelet_Value>(wavelet_from(line.source + u32(wavelet_even(i)) * wavelet_from_strides.x));
}

fn wavelet_high(line: wavelet_Line, i: i32) -> wavelet_Value {
    if !wavelet_counts(i) {
        return wavelet_Value(0);
    }
    let at = u32(wavelet_odd(i)) + (wavelet_samples + 1u) / 2u;
    return bitcast<wavelet_Value>(wavelet_from(line.source + at * wavelet_from_strides.x));
}

@compute @workgroup_size(64)
fn wavelet_axis_pass(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= wavelet_lines {
        return;
    }
    let source = id.x * wavelet_from_strides.y + id.y * wavelet_from_strides.z;
    let sink = wavelet_to_start + id.x * wavelet_to_strides.y + id.y * wavelet_to_strides.z;
    let line = wavelet_Line(source, sink);
    if wavelet_samples == 1u {
        wavelet_store(line, 0, wavelet_low(line, 0));
        return;
    }
    wavelet_run(line, i32(id.z * wavelet_pairs));
}
